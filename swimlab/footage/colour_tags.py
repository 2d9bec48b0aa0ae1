"""Which colour space a file itself says that it is in."""

from pathlib import Path
from typing import Any

import numpy as np

# Primaries and white point x, y (red, green, blue, white) of linear floats. Rec.709: BT.709; Rec.2020: BT.2020;
# P3-D65: SMPTE EG 432-1; AP0 and AP1: SMPTE ST 2065-1 and Academy S-2014-004.
_D65, _D60 = (0.3127, 0.329), (0.32168, 0.33767)
_PRIMARIES = {
    "linear": (0.64, 0.33, 0.3, 0.6, 0.15, 0.06, *_D65),
    "lin_rec2020_scene": (0.708, 0.292, 0.17, 0.797, 0.131, 0.046, *_D65),
    "lin_p3d65_scene": (0.68, 0.32, 0.265, 0.69, 0.15, 0.06, *_D65),
    "lin_ap0_scene": (0.7347, 0.2653, 0.0, 1.0, 0.0001, -0.077, *_D60),
    "lin_ap1_scene": (0.713, 0.293, 0.165, 0.83, 0.128, 0.044, *_D60),
}
_ROUNDED = 1.5e-3
"""How far apart two statements of the same chromaticities may be; files give three digits, some two whites."""

# Code points of ITU-T H.273, which PNG's cICP chunk and video streams hold: primaries 1 BT.709, 2 not said, 9 BT.2020,
# 12 P3-D65; transfer 1, 6, 14, 15 BT.709 and its kin, 2 not said, 4 gamma 2.2, 8 linear, 13 sRGB, 16 PQ, 18 HLG.
_CODES = {
    (1, 4): "g22_rec709_scene",
    (2, 4): "g22_rec709_scene",
    (1, 8): "linear",
    (2, 8): "linear",
    (9, 8): "lin_rec2020_scene",
    (12, 8): "lin_p3d65_scene",
    (12, 13): "srgb_p3d65_scene",
    (2, 16): "pq_rec2020_display",
    (9, 16): "pq_rec2020_display",
    (12, 16): "pq_p3d65_display",
    (2, 18): "hlg_rec2020_display",
    (9, 18): "hlg_rec2020_display",
}
_LIKE_SRGB = frozenset({1, 2, 6, 13, 14, 15})
"""Transfers that ordinary screens show by the curve of sRGB."""

_PROFILES = {"display p3": "srgb_p3d65_scene", "adobe rgb (1998)": "g22_adobergb_scene"}
_CHUNKS = (b"sRGB", b"gAMA", b"cICP", b"iCCP")
_NO_WORD = frozenset({"", "unknown", "Undefined", "User defined"})


def space_of_codes(primaries: int, transfer: int) -> str:
    """The colour space of H.273 code points; one that no configuration knows names them."""
    if (primaries, transfer) in _CODES:
        return _CODES[primaries, transfer]
    return "srgb" if transfer in _LIKE_SRGB else f"H.273 primaries {primaries}, transfer {transfer}"


def stated_space(path: Path, spec: Any) -> str | None:
    """The colour space that the metadata of a file's part names, None where it does not say.

    OpenImageIO assumes one of some files that say nothing, and of profiles that it does not read. What has no name in
    any configuration comes back as the words that describe it, to be refused by them.
    """
    codes = spec.getattribute("CICP")
    if codes is not None:
        return space_of_codes(int(codes[0]), int(codes[1]))
    profile = spec.get_string_attribute("ICCProfile:profile_description")
    if profile:
        return _of_profile(profile)
    suffix = path.suffix.lower()
    if suffix == ".png" and not _has_colour_chunk(path):
        return None
    named: str = spec.get_string_attribute("oiio:ColorSpace") or spec.get_string_attribute("dpx:Transfer")
    if named in _NO_WORD:
        primaries = spec.getattribute("chromaticities")
        return None if primaries is None else _of_primaries(primaries)
    # BT.709's curve is for cameras; what is shown by it is meant for sRGB's. A .pfm holds floats.
    return {"Rec709": None if suffix == ".pfm" else "srgb"}.get(named, named)


def _of_profile(description: str) -> str:
    """The colour space of an ICC profile, by what it calls itself."""
    name = description.strip("\0 ").casefold()
    if "linear" in name:
        return f"ICC profile {description}"
    return "srgb" if "srgb" in name else _PROFILES.get(name, f"ICC profile {description}")


def _of_primaries(chromaticities: Any) -> str:
    given = np.array(chromaticities, np.float64)
    for name, primaries in _PRIMARIES.items():
        if np.abs(given - primaries).max() < _ROUNDED:
            return name
    return "chromaticities " + " ".join(f"{value:g}" for value in given)


def _has_colour_chunk(path: Path) -> bool:
    with path.open("rb") as file:
        head = file.read(4096).partition(b"IDAT")[0]
    return any(chunk in head for chunk in _CHUNKS)
