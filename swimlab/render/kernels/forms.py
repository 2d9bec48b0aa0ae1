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
from functools import cache, wraps
from types import FunctionType
from typing import Any, NamedTuple

import warp as wp

from swimlab.render.kernels.structs import LANES


class Twins(NamedTuple):
    """The two forms as they are written.

    plain: the device function. native: the body in C++, in which the plain form's parameters have the same names.
    width: floats of a texel; 0 where no texel takes part.
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
        @cache
        @wraps(write)
        def make(*parameters: Any) -> Form:
            plain, code, width = write(*parameters)
            name = re.sub(r"\W+", "_", "_".join(map(str, (write.__module__, write.__name__, *parameters))))
            return Form(plain, wp.func_native(code)(_signature(plain, name)), width, agrees)

        for case in cases:
            label = "-".join([write.__name__, *map(str, case)])
            DECLARED.append(Declared(label, lambda case=case: make(*case)))
        return make

    return declare


def _signature(plain: wp.Function, name: str) -> FunctionType:
    """A function with the parameters of a device function, under a name of its own."""
    written = plain.func
    twin = FunctionType(written.__code__, written.__globals__, name, written.__defaults__, written.__closure__)
    twin.__annotations__ = written.__annotations__
    twin.__qualname__ = name
    return twin


EXP2 = """
    // 2^t = 2^r 2^g, |g| <= 1/2, by the polynomial of Cephes' exp2f.
    const auto exp2 = [](float t) {
        t = t > -126.0f ? t : -126.0f;
        const float r = __builtin_floorf(t + 0.5f), g = t - r;
        float p = 1.535336188319500e-4f;
        p = p*g + 1.339887440266574e-3f; p = p*g + 9.618437357674640e-3f; p = p*g + 5.550332471162809e-2f;
        p = p*g + 2.402264791363012e-1f; p = p*g + 6.931472028550421e-1f; p = p*g + 1.0f;
        const int scale = ((int)r + 127) << 23;
        float two; __builtin_memcpy(&two, &scale, 4);
        return p*two;
    };
"""

LOGARITHM = """
    // log(x 2^-e) of a positive float, with sqrt(1/2) < x 2^-e < sqrt(2), by the polynomial of Cephes' logf.
    const auto log_of_mantissa = [](float x, int& e) {
        int bits; __builtin_memcpy(&bits, &x, 4);
        e = (bits - 0x3f3504f3) >> 23;
        bits -= e << 23;
        float m; __builtin_memcpy(&m, &bits, 4);
        const float f = m - 1.0f;
        float p = 7.0376836292e-2f;
        p = p*f - 1.1514610310e-1f; p = p*f + 1.1676998740e-1f; p = p*f - 1.2420140846e-1f;
        p = p*f + 1.4249322787e-1f; p = p*f - 1.6668057665e-1f; p = p*f + 2.0000714765e-1f;
        p = p*f - 2.4999993993e-1f; p = p*f + 3.3333331174e-1f;
        return f + (p*f - 0.5f)*f*f;
    };
"""


def half_vector_code(width: int) -> str:
    """The light (lx, my, mz) and the half vector (hx, hy, hz), not of unit length, of lane k in its tangent frame.

    For the loop over k of a packet `a` whose texels have `width` floats; (lx, ly, lz) is the light in world axes. The
    half vector is made as `shading.half_vector` makes it.
    """
    rows = {name: f"a[{(width + row) * LANES} + k]" for row, name in enumerate(("px", "py", "pz", "slope"))}
    return "\n".join(f"        const float {name} = {value};" for name, value in rows.items()) + (
        """
        const float tilt = 1.0f/__builtin_sqrtf(1.0f + slope*slope);
        const float toward = -1.0f/__builtin_sqrtf(px*px + py*py + pz*pz);
        const float my = (ly + slope*lz)*tilt, mz = (lz - slope*ly)*tilt;
        const float vx = px*toward, vy = (py + slope*pz)*tilt*toward, vz = (pz - slope*py)*tilt*toward;
        const float sx = lx + vx, sy = my + vy, sz = mz + vz, dx = lx - vx, dy = my - vy, dz = mz - vz;
        const float along = 0.25f*(sx*dx + sy*dy + sz*dz);
        const float hx = sx - along*dx, hy = sy - along*dy, hz = sz - along*dz;"""
    )
