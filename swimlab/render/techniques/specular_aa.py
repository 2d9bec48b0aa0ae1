"""Specular anti-aliasing: the highlight is widened by how fast the filtered normal turns from pixel to pixel.

It is by the mapped normal: the geometric one of a flat road does not turn at all.
"""

import functools
from typing import Any

import warp as wp
from pydantic import Field

from metrics.kernels.forms import Twins, Within, form
from metrics.kernels.making import made_once
from swimlab.render.kernels.sampling import anisotropic
from swimlab.render.kernels.structs import Chain, Surface
from swimlab.render.kernels.texture_filter import Beside, TextureFilter, stretched, transposed
from swimlab.render.settings import Settings
from swimlab.render.technique import Technique, pixel_shading


class SpecularAaSettings(Settings):
    """By how much the highlight is widened."""

    variance: float = Field(0.15, ge=0, le=1, description="variance of the pixel's filter, px^2")
    threshold: float = Field(0.2, ge=0, le=1, description="most that is added to the squared roughness")
    anisotropy: int = Field(16, ge=1, le=64, description="most probes along the footprint's major axis")


@wp.func
def shifted(surface: Surface, by: wp.vec2d) -> Surface:
    """The same surface at another uv."""
    moved = surface
    moved.uv = surface.uv + by
    return moved


@wp.func
def normal_of(texel: Any) -> wp.vec3:
    """The unit normal."""
    return wp.normalize(wp.vec3(texel[3], texel[4], texel[5]))


@made_once
def widened(variance: float, threshold: float, most: int) -> wp.Function:
    """a^2' = min(1, a^2 + min(2 variance (|dN/dx|^2 + |dN/dy|^2), threshold)) with a^2 = 2/(power + 2)."""

    @wp.func(module="unique")
    def antialiased(texels: wp.array(dtype=Any), chain: Chain, surface: Surface):
        texel = anisotropic(texels, chain, surface, most)
        here = normal_of(texel)
        across = normal_of(anisotropic(texels, chain, shifted(surface, surface.dx), most)) - here
        down = normal_of(anisotropic(texels, chain, shifted(surface, surface.dy), most)) - here
        turn = wp.length_sq(across) + wp.length_sq(down)
        squared = 2.0 / (texel[7] + 2.0) + wp.min(2.0 * variance * turn, threshold)
        texel[7] = 2.0 / wp.min(squared, 1.0) - 2.0
        return texel

    return antialiased


DECLARED = """
    // The places one cell to the right (s = 0) and one down, by the footprint's own probes: where the first lies; of a
    // probe on level o the texels, and how far it lies from the first to the next, across for both s, then down.
    float first_u[2][LANES] = {}, first_v[2][LANES] = {}, between[2][LANES][4];
    int beside[2][2][4][LANES];
    for (int s = 0; s < 2; ++s) {
        #pragma clang loop vectorize(assume_safety)
        for (int k = 0; k < count; ++k) {
            first_u[s][k] = (float)(q[k] + q[(2 + 2*s)*LANES + k]) - au[k];
            first_v[s][k] = (float)(q[LANES + k] + q[(3 + 2*s)*LANES + k]) - av[k];
        }
    }
    // Sums of the normals on both levels, those of s = 0 in the first four floats.
    typedef float vec_n __attribute__((ext_vector_type(4), aligned(4)));
    vec_a fine[LANES], coarse[LANES];
    __builtin_memset(fine, 0, sizeof fine);
    __builtin_memset(coarse, 0, sizeof coarse);
    auto normals = [&](int o, int k) {
        #pragma clang fp contract(fast)
        auto read = [&](int which) -> vec_a {
            auto normal = [&](int s) { return *(const vec_n*)(data + (long)beside[o][s][which][k]*WIDTH + 3); };
            return __builtin_shufflevector(normal(0), normal(1), 0, 1, 2, 3, 4, 5, 6, 7);
        };
        const vec_n far = *(const vec_n*)between[o][k];
        const vec_a a = __builtin_shufflevector(far, far, 0, 0, 0, 0, 1, 1, 1, 1);
        const vec_a b = __builtin_shufflevector(far, far, 2, 2, 2, 2, 3, 3, 3, 3);
        const vec_a upper = read(0) + (read(1) - read(0))*a, lower = read(2) + (read(3) - read(2))*a;
        return upper + (lower - upper)*b;
    };
"""

LOCATED = """
            for (int s = 0; s < 2; ++s) {
                float* far = between[o][k] + s;
                locate(o, k, first_u[s][k] + u, first_v[s][k] + v, beside[o][s], far[0], far[2], inside);
            }
"""

READ = """
            fine[k] += normals(0, k);
            if (blend[k] > 1.0e-6f) coarse[k] += normals(1, k);
"""

MEAN = "fine[done + i]*(1.0f - blend[done + i]) + coarse[done + i]*blend[done + i]"

MEANS = f"""
    float mean[8*LANES];
    done = 0;
{transposed(MEAN, "mean")}
    for (; done < count; ++done) {{
        const int i = 0;
        const vec_a one = {MEAN};
        for (int row = 0; row < 8; ++row) mean[row*LANES + done] = one[row];
    }}
"""

WIDENED = """
    #pragma clang loop vectorize(assume_safety)
    for (int k = 0; k < count; ++k) {
        const float x = out[3*LANES + k], y = out[4*LANES + k], z = out[5*LANES + k], long_n = x*x + y*y + z*z;
        const float unit = long_n > 0.0f ? 1.0f/__builtin_sqrtf(long_n) : 0.0f;
        float turn = 0.0f;
        for (int s = 0; s < 2; ++s) {
            const float* m = mean + 4*s*LANES + k;
            const float a = m[0], b = m[LANES], c = m[2*LANES], long_m = a*a + b*b + c*c;
            const float one = long_m > 0.0f ? 1.0f/__builtin_sqrtf(long_m) : 0.0f;
            const float dx = a*one - x*unit, dy = b*one - y*unit, dz = c*one - z*unit;
            turn += dx*dx + dy*dy + dz*dz;
        }
        const float wider = 2.0f*VARIANCE*turn;
        const float squared = 2.0f/(out[7*LANES + k] + 2.0f) + (wider < THRESHOLD ? wider : THRESHOLD);
        out[7*LANES + k] = 2.0f/(squared < 1.0f ? squared : 1.0f) - 2.0f;
    }
"""


@form(cases=[(8, 0.15, 0.2, 16), (10, 0.5, 0.1, 3)], agrees=Within("native specular-aa, relative", floor=1.0))
def widened_texels(width: int, variance: float, threshold: float, most: int) -> Twins:
    """`widened` over the lanes of a packet, of texels of `width` floats."""
    names = {"WIDTH": str(width), "VARIANCE": f"{variance!r}f", "THRESHOLD": f"{threshold!r}f"}
    parts = (
        functools.reduce(lambda text, name: text.replace(name, names[name]), names, part)
        for part in (DECLARED, LOCATED, READ, MEANS + WIDENED)
    )
    return stretched(widened(variance, threshold, most), width, most, Beside(*parts))


def texture_filter(settings: SpecularAaSettings) -> TextureFilter:
    """The filter of some settings."""
    chosen = settings.variance, settings.threshold, settings.anisotropy
    return TextureFilter(widened(*chosen), lambda width: widened_texels(width, *chosen))


TECHNIQUE = Technique(
    name="specular-aa",
    summary="aniso inputs, highlight widened by the normal's screen derivatives",
    source="Tokuyoshi & Kaplanyan 2019, Improved Geometric Specular Antialiasing; constants of Filament",
    render=pixel_shading(texture_filter),
    settings=SpecularAaSettings,
)
