"""A property that is made when it is first asked for, and kept."""

from collections.abc import Callable
from typing import Any, Generic, TypeVar

Value = TypeVar("Value")


class lazy(Generic[Value]):  # noqa: N801, used as a decorator
    """As `functools.cached_property`, whose lock lets, until Python 3.12, one object at a time make its own.

    For objects that each belong to one thread.
    """

    def __init__(self, make: Callable[[Any], Value]) -> None:
        self._make = make
        self.__doc__ = make.__doc__

    def __get__(self, instance: Any, owner: type | None = None) -> Value:
        value = instance.__dict__[self._make.__name__] = self._make(instance)
        return value
