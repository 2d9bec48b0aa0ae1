"""The motions, one a file. They are discovered: a new file with one subclass of `Motion` adds a motion."""

import importlib
import pkgutil
from collections.abc import Iterable, Iterator
from typing import TYPE_CHECKING, Annotated, Union, get_args

from pydantic import Field

from ..motion import Motion


def _discovered() -> Iterator[type[Motion]]:
    for found in pkgutil.iter_modules(__path__, f"{__name__}."):
        for value in vars(importlib.import_module(found.name)).values():
            if isinstance(value, type) and issubclass(value, Motion) and value.__module__ == found.name:
                yield value


def by_kind(motions: Iterable[type[Motion]]) -> dict[str, type[Motion]]:
    """Motions by their `kind`. Raises ValueError if two have the same one."""
    named: dict[str, type[Motion]] = {}
    for motion in motions:
        (kind,) = get_args(motion.model_fields["kind"].annotation)
        if kind in named:
            raise ValueError(f"two motions are called {kind!r}: {named[kind].__module__}, {motion.__module__}")
        named[kind] = motion
    return named


MOTIONS = by_kind(_discovered())
"""Every motion by its kind."""

if TYPE_CHECKING:
    AnyMotion = Motion
else:
    AnyMotion = Annotated[Union[tuple(MOTIONS.values())], Field(discriminator="kind")]  # noqa: UP007
