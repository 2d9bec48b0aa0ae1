"""From stored values to linear radiance, and what their quantisation costs."""

from typing import Any, Literal

import numpy as np
from numpy.typing import NDArray

from metrics.display import STANDARD, Display, Domain

ColourSpace = Literal["auto", "linear", "srgb"]

LEVELS = {"uint8": 255, "uint16": 65535}


def resolve(space: ColourSpace, *, stored_as: str, metadata: str | None) -> Literal["linear", "srgb"]:
    """Which colour space stored values are in.

    auto: floats are linear; integers are what the file's metadata says; without a word, 8-bit integers are sRGB and
    longer ones linear.
    """
    if space != "auto":
        return space
    if stored_as in ("half", "float", "double"):
        return "linear"
    if metadata is not None:
        return "linear" if metadata.lower().startswith(("lin", "acescg", "scene_linear", "raw")) else "srgb"
    return "srgb" if stored_as == "uint8" else "linear"


def decode(stored: NDArray[Any], space: Literal["linear", "srgb"]) -> NDArray[Any]:
    """Linear radiance of stored values, of any shape (sRGB: IEC 61966-2-1)."""
    if space == "linear":
        return stored
    return np.where(stored <= 0.04045, stored / 12.92, ((np.maximum(stored, 0) + 0.055) / 1.055) ** 2.4)


def quantisation_floor(
    stored: NDArray[Any],
    *,
    stored_as: str,
    space: Literal["linear", "srgb"],
    domain: Domain,
    display: Display = STANDARD,
    full_scale: int | None = None,
) -> float | None:
    """Mean squared error that rounding to the stored codes makes, radiance^2: step^2 / 12 over the codes in use.

    stored: values as stored, integers scaled to 0..1, any shape. full_scale: codes from black to white, for limited
    range. display: whose curve it is in the display domain. None where values are not quantised in steps that matter
    (32-bit floats).
    """
    if stored_as == "half":
        half: NDArray[Any] = np.spacing(np.abs(stored).astype(np.float16)).astype(np.float64) / 2
    elif stored_as in LEVELS:
        half = np.asarray(0.5 / (full_scale or LEVELS[stored_as]))
    else:
        return None
    values = stored.astype(np.float64)
    below, above = (decode(edge, space) for edge in (values - half, values + half))
    if domain == "display":
        below, above = display.curve(below), display.curve(above)
    return float(np.mean((above - below) ** 2) / 12)
