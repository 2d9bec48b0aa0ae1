"""What every table of a sequence file has in common: unknown keys are errors, values never change."""

from typing import Annotated

from pydantic import AllowInfNan, BaseModel, ConfigDict, Strict

Whole = Annotated[int, Strict()]
"""A whole number; `"3"`, `true` and 3.5 are errors."""

Real = Annotated[float, Strict(), AllowInfNan(False)]
"""A finite number, whole ones included; text and booleans are errors."""


class Table(BaseModel):
    """A table of a sequence file: a frozen record that takes no key it does not know."""

    model_config = ConfigDict(extra="forbid", frozen=True, serialize_by_alias=True)
