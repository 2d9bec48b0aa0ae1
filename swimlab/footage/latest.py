"""Results that are kept for who asks for them next."""

from collections.abc import Callable
from functools import lru_cache
from typing import Any, Generic, TypeVar

Result = TypeVar("Result")


class Latest(Generic[Result]):
    """A function of an index, whose latest results are kept. It is pickled without them."""

    def __init__(self, function: Callable[[int], Result], count: int) -> None:
        """count: how many results are kept."""
        self._function, self._count = function, count
        self._kept = lru_cache(maxsize=count)(function)

    def __call__(self, index: int) -> Result:
        return self._kept(index)

    def __reduce__(self) -> tuple[Any, ...]:
        return Latest, (self._function, self._count)
