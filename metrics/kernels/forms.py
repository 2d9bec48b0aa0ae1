"""Native forms: a formula's plain form, its C++ and what a test claims of them, declared side by side.

The plain form is the one to read. The native form is C++ under the same signature, which clang vectorises. A formula in
two forms is a function that returns both, under `form`:

    @form(cases=[(4,), (8,)], agrees=Within("native filter against plain"))
    def finest(width: int) -> Twins:
        return Twins(plain, CPP, width)

`finest(8)` is then a Form, made once. One test (`tests/swimlab/render/test_native_forms.py`) runs both forms of every
declared case on the same inputs.
"""

import re
from collections.abc import Callable, Iterable
from dataclasses import dataclass
from functools import partial, wraps
from types import FunctionType
from typing import Any, NamedTuple

import warp as wp

from metrics.kernels.making import made_once


class Twins(NamedTuple):
    """The two forms as they are written.

    plain: the device function. native: the body in C++, in which the plain form's parameters have the same names.
    width: floats of a texel, or px of a tile; 0 where neither takes part.
    """

    plain: wp.Function
    native: str
    width: int = 0


class Within(NamedTuple):
    """The claim that both forms agree within a tolerance, by its name in `tests/conftest.py`.

    floor: the difference is relative to the plain form's absolute value plus this; None: it is absolute.
    """

    tolerance: str
    floor: float | None = None


@dataclass(frozen=True)
class Form:
    """A formula in two forms under one signature. agrees: None, the same bits."""

    plain: wp.Function
    native: wp.Function
    width: int
    agrees: Within | None

    def on(self, device: str) -> wp.Function:
        """The form that a device runs: the native one is for the CPU."""
        return self.native if device == "cpu" else self.plain


class Declared(NamedTuple):
    """A form that is tested: its name and what makes it."""

    name: str
    make: Callable[[], Form]


DECLARED: list[Declared] = []
"""Every case of every declared form, of the modules imported so far."""


def form(
    *, cases: Iterable[tuple[Any, ...]] = ((),), agrees: Within | None = None
) -> Callable[[Callable[..., Twins]], Callable[..., Form]]:
    """Declare a formula in two forms, as the decorator of a function that returns Twins; decorated, it returns a Form.

    The function's parameters are plain values, given by position.
    cases: the parameters that are tested. agrees: what the test claims; None: the same bits.
    """

    def declare(write: Callable[..., Twins]) -> Callable[..., Form]:
        @made_once
        @wraps(write)
        def make(*parameters: Any) -> Form:
            plain, code, width = write(*parameters)
            name = re.sub(r"\W+", "_", "_".join(map(str, (write.__module__, write.__name__, *parameters))))
            return Form(plain, wp.func_native(code)(_signature(plain, name)), width, agrees)

        for case in cases:
            label = "-".join([write.__name__, *map(str, case)])
            DECLARED.append(Declared(label, partial(make, *case)))
        return make

    return declare


def _signature(plain: wp.Function, name: str) -> FunctionType:
    """A function with the parameters of a device function, under a name of its own."""
    written: Any = plain.func
    twin = FunctionType(written.__code__, written.__globals__, name, written.__defaults__, written.__closure__)
    twin.__annotations__ = written.__annotations__
    twin.__qualname__ = name
    return twin
