"""Blinn-Phong (Blinn 1977; Sloan & Baker): C = sat(N.H)^p n(p) Ks + sat(N.L) diffuse Kd, p the power.

The specular term is not gated by N.L: this is the deck's radiance as written. Its normalisation n(p) is
deck: p;
ndf: (p + 2) / (2 pi), for which the lobe is a distribution of normals, its integral over N.H d(omega) 1;
energy: (p + 2)(p + 4) / (8 pi (2^(-p/2) + p)), with which Ks of the light is reflected at normal incidence;
the usual (p + 8) / (8 pi) is above that by 7.5% at p = 10 and .2% at p = 1000.
"""

from typing import Literal

import warp as wp
from pydantic import Field

from metrics.kernels.forms import Twins, Within, form
from metrics.kernels.making import made_once
from swimlab.render.brdf import Brdf, Model
from swimlab.render.kernels.cpp import EXP2, LOGARITHM, half_vector_code
from swimlab.render.kernels.packet import plain_packet
from swimlab.render.kernels.shading import in_local_frame, power_of_cosine
from swimlab.render.settings import Settings


class BlinnPhongSettings(Settings):
    """How bright the highlight is."""

    normalisation: Literal["deck", "ndf", "energy"] = Field(
        "deck",
        description="the lobe's factor: deck (p), ndf ((p+2) / (2 pi)), energy ((p+2)(p+4) / (8 pi (2^(-p/2) + p)))",
    )


@wp.func
def deck(power: wp.float32) -> wp.float32:
    """The power itself."""
    return power


@wp.func
def ndf(power: wp.float32) -> wp.float32:
    """(p + 2) / (2 pi)."""
    return (power + 2.0) / (2.0 * wp.PI)


@wp.func
def energy(power: wp.float32) -> wp.float32:
    """(p + 2)(p + 4) / (8 pi (2^(-p/2) + p))."""
    return (power + 2.0) * (power + 4.0) / (8.0 * wp.PI * (wp.exp(-0.5 * wp.log(2.0) * power) + power))


FACTORS = {"deck": deck, "ndf": ndf, "energy": energy}
"""Normalisations by name."""

NATIVE_FACTORS = {
    "deck": "power",
    "ndf": "(power + 2.0f)*0.159154943f",
    "energy": "(power + 2.0f)*(power + 4.0f)/(25.1327412f*(exp2(-0.5f*power) + power))",
}
"""The same in the native form."""

NATIVE = f"""{EXP2}{LOGARITHM}
    float* __restrict a = lanes.data;
    const float lx = sun.direction[0], ly = sun.direction[1], lz = sun.direction[2], diffuse = sun.diffuse;
    #pragma clang loop vectorize(assume_safety) vectorize_width(16)
    for (int k = 0; k < 64; ++k) {{
{half_vector_code(8)}
        const float h = 1.0f/__builtin_sqrtf(hx*hx + hy*hy + hz*hz), ux = hx*h, uy = hy*h, uz = hz*h;
        float nx = a[3*64 + k], ny = a[4*64 + k], nz = a[5*64 + k];
        const float n = 1.0f/__builtin_sqrtf(nx*nx + ny*ny + nz*nz);
        nx *= n; ny *= n; nz *= n;
        const float cosine = nx*ux + ny*uy + nz*uz;
        const float cx = ny*uz - nz*uy, cy = nz*ux - nx*uz, cz = nx*uy - ny*ux;
        const float s = cx*cx + cy*cy + cz*cz;
        // log(1 - s): log(u) s/(1 - u) with u = 1 - s as rounded, beyond 45 degrees log(u) with u = (N.H)^2.
        const float squared = s > 0.5f ? cosine*cosine : 1.0f - s;
        const float u = squared > 1.2e-38f ? squared : 1.2e-38f;
        int e; const float rest = log_of_mantissa(u, e), log_u = rest + (float)e*0.693147181f;
        const float log_1s = s > 0.5f ? log_u : u < 1.0f ? log_u*(s/(1.0f - u)) : -s;
        const float power = a[7*64 + k];
        const float lobe = power > 0.0f ? (cosine > 0.0f ? exp2(0.72134752f*power*log_1s) : 0.0f) : 1.0f;
        const float specular = lobe*(FACTOR)*a[6*64 + k];
        float lambert = nx*lx + ny*my + nz*mz;
        lambert = (lambert > 0.0f ? (lambert < 1.0f ? lambert : 1.0f) : 0.0f)*diffuse;
        a[k] = a[k]*lambert + specular;
        a[64 + k] = a[64 + k]*lambert + specular;
        a[128 + k] = a[128 + k]*lambert + specular;
    }}
"""


@made_once
def evaluate_with(normalisation: str) -> wp.Function:
    """The plain model."""
    factor = FACTORS[normalisation]

    @wp.func(module="unique")
    def evaluate(
        albedo: wp.vec3, ks: wp.float32, power: wp.float32, light: wp.vec3, view: wp.vec3, diffuse: wp.float32
    ) -> wp.vec3:
        specular = power_of_cosine(wp.normalize(light + view), power) * factor(power) * ks
        lambert = wp.clamp(light[2], 0.0, 1.0) * diffuse
        return albedo * lambert + wp.vec3(specular, specular, specular)

    return evaluate


@form(cases=[(name,) for name in FACTORS], agrees=Within("native against plain"))
def packet_with(normalisation: str) -> Twins:
    """The model over a packet of 8-float texels."""
    plain = plain_packet(in_local_frame(evaluate_with(normalisation), 8), 8)
    return Twins(plain, NATIVE.replace("FACTOR", NATIVE_FACTORS[normalisation]), 8)


@made_once
def with_normalisation(settings: BlinnPhongSettings) -> Model:
    """The model, plain and native."""
    name = settings.normalisation
    return Model(evaluate_with(name), packet_with(name).native, slopes_are_gaussian=name == "deck")


BRDF = Brdf(
    name="blinn-phong",
    summary="Blinn-Phong, normalised by the deck's power, as a distribution or by energy",
    source="Blinn 1977; Sloan & Baker, Part II: Techniques",
    model=with_normalisation,
    settings=BlinnPhongSettings,
)
