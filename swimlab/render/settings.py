"""Settings of techniques and reflectance models."""

from pydantic import BaseModel, ConfigDict


class Settings(BaseModel):
    """Plain values with defaults and bounds. This one has none."""

    model_config = ConfigDict(extra="forbid", frozen=True)
