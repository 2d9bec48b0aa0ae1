"""Kernels and device functions are made, built and loaded by one thread at a time.

Python's parser, which Warp calls on a kernel's source, and Warp's builder are not safe in several threads at once.
"""

from collections.abc import Callable
from functools import wraps
from threading import RLock
from typing import ParamSpec, TypeVar

Parameters = ParamSpec("Parameters")
Made = TypeVar("Made")

MAKING = RLock()
"""Held by the thread that makes, builds or loads a kernel."""


def made_once(make: Callable[Parameters, Made]) -> Callable[Parameters, Made]:
    """Decorate what makes a kernel, a device function or a form: for equal parameters it is made once, and kept."""
    kept: dict[object, Made] = {}

    @wraps(make)
    def get(*args: Parameters.args, **kwargs: Parameters.kwargs) -> Made:
        parameters = (args, tuple(kwargs.items()))
        if parameters not in kept:
            with MAKING:
                if parameters not in kept:
                    kept[parameters] = make(*args, **kwargs)
        return kept[parameters]

    return get
