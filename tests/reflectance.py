"""The reflectance models in double-precision numpy, as their papers write them; no code shared with swimlab.

Each takes albedo and Ks (numbers), the power, unit vectors [..., 3] to light and eye in the local frame, and the deck's
diffuse intensity, and gives radiance [...] of a grey surface.
"""

import numpy as np
from oracle import unit

PI = np.pi


def blinn_phong(kd, ks, p, light, view, diffuse, normalisation="deck"):
    factor = {
        "deck": p,
        "ndf": (p + 2) / (2 * PI),
        "energy": (p + 2) * (p + 4) / (8 * PI * (2 ** (-p / 2) + p)),
    }[normalisation]
    cosine = np.clip(unit(light + view)[..., 2], 0, 1)
    return ks * factor * cosine**p + kd * diffuse * np.clip(light[..., 2], 0, 1)


def banks(kd, ks, p, light, view, diffuse, normalisation="none", exponent=1.0):
    p = exponent * p
    ks = ks * {"none": 1, "energy": np.sqrt((2 * p + 5) / (16 * PI))}[normalisation]
    lt, vt, nl = light[..., 0], view[..., 0], np.clip(light[..., 2], 0, 1)
    d = np.sqrt(1 - lt**2) * np.sqrt(1 - vt**2) - lt * vt
    return ks * np.clip(d, 0, 1) ** p * nl + kd * diffuse * nl


def ashikhmin_shirley(kd, ks, p, light, view, diffuse, anisotropy=1.0):
    nu, nv = p / anisotropy, p * anisotropy
    h = unit(light + view)
    nh, hv, nl, ne = h[..., 2], (h * view).sum(-1), light[..., 2], view[..., 2]
    aside = 1 - nh**2
    exponent = np.where(aside > 0, (nu * h[..., 0] ** 2 + nv * h[..., 1] ** 2) / np.where(aside > 0, aside, 1), 0)
    fresnel = ks + (1 - ks) * (1 - hv) ** 5
    specular = np.sqrt((nu + 1) * (nv + 1)) / (8 * PI) * nh**exponent / (hv * np.maximum(nl, ne)) * fresnel
    body = 28 * kd / (23 * PI) * (1 - ks) * (1 - (1 - nl / 2) ** 5) * (1 - (1 - ne / 2) ** 5)
    return np.where((nl > 0) & (ne > 0), PI * (specular + body) * nl, 0)


def lafortune(kd, ks, p, light, view, diffuse, lobes=((-1, -1, 1, 0.25),), normalisation="none"):
    nl = np.clip(light[..., 2], 0, 1)
    total = sum(
        np.clip((np.array(coefficients) * light * view).sum(-1), 0, None) ** (n * p)
        * ((n * p + 2) / (2 * PI) if normalisation == "energy" else 1)
        for *coefficients, n in lobes
    )
    return PI * (kd / PI + ks * np.where(view[..., 2] > 0, total, 0)) * nl


def cook_torrance(kd, ks, p, light, view, diffuse):
    m = np.sqrt(2 / (p + 2))
    h = unit(light + view)
    nh, vh, nl, nv = h[..., 2], (h * view).sum(-1), light[..., 2], view[..., 2]
    beckmann = np.exp(-(1 - nh**2) / (nh * m) ** 2) / (PI * m**2 * nh**4)
    grooves = np.minimum(1, np.minimum(2 * nh * nv / vh, 2 * nh * nl / vh))
    fresnel = ks + (1 - ks) * (1 - vh) ** 5
    with np.errstate(divide="ignore", invalid="ignore"):
        specular = np.where((nl > 0) & (nv > 0), fresnel * beckmann * grooves / (4 * nl * nv), 0)
    return PI * (kd / PI + specular) * np.clip(nl, 0, 1)
