"""Texture filters, in which techniques differ.

`sampling` has the plain forms; the native forms fill whole packets. First come the probes of all lanes, and for each
probe the addresses of its texels, in loops that a compiler vectorises; then the taps, lane by lane, a whole texel at a
time. The taps give the bits of the plain form; levels of detail, by a float logarithm, agree to 1e-6.
"""

from collections.abc import Callable
from dataclasses import dataclass
from itertools import product
from typing import Any, NamedTuple

import warp as wp

from metrics.kernels.forms import Form, Twins, Within, form
from metrics.kernels.making import made_once
from swimlab.render.kernels import sampling
from swimlab.render.kernels.addresses import OF_CHAIN, OF_FINEST
from swimlab.render.kernels.packet import WIDTHS, each_lane
from swimlab.render.kernels.probes import ANISOTROPIC_PROBES, FINEST_PROBE, ISOTROPIC_PROBE, LOG2
from swimlab.render.kernels.structs import LANES, TEXELS, Chain

AGREES = Within("native filter against plain")


def _part(name: str, kind: str, first: int, width: int) -> tuple[str, str, str]:
    """Code for floats `first`... of texels of `width`, as vectors `kind`: sums, a bilinear tap, adding a probe."""
    sums = f"    {kind} sum_{name}[{LANES}];\n"
    tap = f"""
    auto tap_{name} = [&](int o, int k) -> {kind} {{
        auto read = [&](int which) -> {kind} {{
            return *(const {kind}*)(data + (long long)at[o][which][k]*{width} + {first});
        }};
        const float a = across[o][k], b = down[o][k];
        const {kind} m = read(0)*(1.0f - a) + read(1)*a, n = read(2)*(1.0f - a) + read(3)*a;
        return m*(1.0f - b) + n*b;
    }};
"""
    add = f"""
            {kind} value_{name} = tap_{name}(0, k);
            if (blend[k] > 1.0e-6f) value_{name} = value_{name}*(1.0f - blend[k]) + tap_{name}(1, k)*blend[k];
            sum_{name}[k] = i == 0 ? value_{name} : sum_{name}[k] + value_{name};
"""
    return sums, tap, add


TRANSPOSED = """
    for (; done + 8 <= count; done += 8) {
        vec_a r[8], s[8];
        for (int i = 0; i < 8; ++i) r[i] = VALUE;
        for (int i = 0; i < 8; i += 2) {
            s[i] = __builtin_shufflevector(r[i], r[i + 1], 0, 8, 2, 10, 4, 12, 6, 14);
            s[i + 1] = __builtin_shufflevector(r[i], r[i + 1], 1, 9, 3, 11, 5, 13, 7, 15);
        }
        for (int i = 0; i < 8; i += i % 4 == 1 ? 3 : 1) {
            r[i] = __builtin_shufflevector(s[i], s[i + 2], 0, 1, 8, 9, 4, 5, 12, 13);
            r[i + 2] = __builtin_shufflevector(s[i], s[i + 2], 2, 3, 10, 11, 6, 7, 14, 15);
        }
        for (int i = 0; i < 4; ++i) {
            float* to = ROWS + i*LANES + done;
            *(vec_a*)to = __builtin_shufflevector(r[i], r[i + 4], 0, 1, 2, 3, 8, 9, 10, 11);
            *(vec_a*)(to + 4*LANES) = __builtin_shufflevector(r[i], r[i + 4], 4, 5, 6, 7, 12, 13, 14, 15);
        }
    }
"""
"""Code that leaves the VALUE of lane `done + i`, eight floats, in the first rows of ROWS, eight lanes at a time."""


def transposed(value: str, rows: str = "out") -> str:
    """That code for some value, a vec_a of lane `done + i`, and some rows of LANES floats: the packet's."""
    return TRANSPOSED.replace("LANES", str(LANES)).replace("VALUE", value).replace("ROWS", rows)


def _store(name: str, first: int, floats: int) -> str:
    """Code that leaves the mean of the other lanes' probes in rows `first`... of the packet."""
    rows = "".join(f" out[{(first + i) * LANES} + k] = mean{f'.s{i:x}' if floats > 1 else ''};" for i in range(floats))
    blocks = transposed("sum_whole[done + i]*share[done + i]") if floats == 8 else ""
    return f"""
    done = 0;
{blocks}
    for (int k = done; k < count; ++k) {{ const auto mean = sum_{name}[k]*share[k];{rows} }}
"""


class Beside(NamedTuple):
    """C++ of what a filter of packets does beside its own work; it may use all that the filter's own code declares.

    declared: once a packet, before any texel is located. located: where lane k's probe is located on level o; (u, v) is
    how far it lies from the lane's first. read: where its texels are read. after: once a packet, when `out` has the
    means; `q` has the footprints.
    """

    declared: str = ""
    located: str = ""
    read: str = ""
    after: str = ""


NOTHING = Beside()


def filter_of(
    plain: wp.Function,
    probes: str,
    width: int,
    addresses: str = OF_CHAIN,
    shape: Any = Chain,
    beside: Beside = NOTHING,
) -> Twins:
    """A filter of texels of `width` floats, by the code of its probes and of where a chain of some shape has texels."""
    declared, located, read, after = (code.replace("LANES", str(LANES)) for code in beside)
    parts = [("whole", "vec_a", 0, min(width, 8))]
    if width > 8:
        parts.append(("rest", "vec_b", 8, width - 8))
    types = "".join(
        f"    typedef float {kind} __attribute__((ext_vector_type({floats}), aligned(4)));\n"
        if floats > 1
        else f"    typedef float {kind};\n"
        for _, kind, _, floats in parts
    )
    sums, taps, adds = zip(*(_part(name, kind, first, width) for name, kind, first, _ in parts), strict=True)
    native = f"""
{types}
    const float* __restrict data = (const float*)texels.data;
    float* __restrict out = lanes.data;
    const double* __restrict q = places.data;
    const double W = (double)chain.width, H = (double)chain.height;
    const bool clamps = chain.clamps == 1;
    const auto clamped = [](int i, int last) {{ return i < 0 ? 0 : i > last ? last : i; }};
    const auto repeated = [](int i, int last) {{ return i & last; }};
    float lod[{LANES}] = {{}}, fu[{LANES}] = {{}}, fv[{LANES}] = {{}}, su[{LANES}] = {{}}, sv[{LANES}] = {{}};
    int number[{LANES}] = {{}};
{LOG2}
{probes.replace("LANES", str(LANES))}
{declared}
{addresses.replace("LANES", str(LANES)).replace("BESIDE", located)}
{"".join(sums)}
{"".join(taps)}
    for (int i = 0; i < most; ++i) {{
        address(0, (float)i);
        if (blended) address(1, (float)i);
        for (int k = 0; k < count; ++k) {{
            if (i >= number[k]) continue;
{"".join(adds)}
{read}
        }}
    }}
    int done;
{"".join(_store(name, first, floats) for name, _, first, floats in parts)}
{after}
"""

    return Twins(each_lane(plain, width, shape), native, width)


@form(cases=WIDTHS, agrees=AGREES)
def finest(width: int) -> Twins:
    """Bilinear samples of level 0 into a packet of texels of `width` floats."""
    return filter_of(sampling.finest, FINEST_PROBE, width, OF_FINEST)


@form(cases=WIDTHS, agrees=AGREES)
def isotropic(width: int) -> Twins:
    """Trilinear samples at the level of the longer derivative."""
    return filter_of(sampling.isotropic, ISOTROPIC_PROBE, width)


@form(cases=product(TEXELS, (1, 3, 16)), agrees=AGREES)
def anisotropic(width: int, most: int) -> Twins:
    """Means of up to `most` probes along each footprint's major axis."""
    return stretched(sampling.anisotropic_to(most), width, most)


def stretched(plain: wp.Function, width: int, most: int, beside: Beside = NOTHING) -> Twins:
    """The anisotropic filter, and C++ of what `plain` does beside it."""
    return filter_of(plain, ANISOTROPIC_PROBES.replace("MOST", f"{most}.0"), width, beside=beside)


@dataclass(frozen=True)
class TextureFilter:
    """A filter of inputs.

    plain: (texels, chain, surface) -> texel. packed: width -> the Form that fills a packet with texels of that many
    floats; None where there is no native form.
    """

    plain: wp.Function
    packed: Callable[[int], Form] | None = None

    def fill(self, width: int, device: str) -> wp.Function:
        """The function that fills a packet: the native form on the CPU where there is one, else the plain form."""
        if self.packed is not None and device == "cpu":
            return self.packed(width).native
        return each_lane(self.plain, width)


FINEST = TextureFilter(sampling.finest, finest)
"""The four texels of level 0 about uv."""

ISOTROPIC = TextureFilter(sampling.isotropic, isotropic)
"""Two levels about log2 of the longer derivative."""


@made_once
def anisotropic_to(most: int) -> TextureFilter:
    """Up to `most` trilinear probes along the footprint's major axis."""
    return TextureFilter(sampling.anisotropic_to(most), lambda width: anisotropic(width, most))
