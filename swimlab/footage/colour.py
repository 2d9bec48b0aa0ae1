"""From stored values to linear radiance, and what their quantisation costs."""

from typing import Any

import numpy as np
from numpy.typing import NDArray

from metrics.display import STANDARD, Display, Domain
from metrics.ocio import WORKING, find_space, to_working

LEVELS = {"uint8": 255, "uint16": 65535}
FLOATS = frozenset({"half", "float", "double"})
"""Types of stored values that may be no number."""

AS_STORED = "linear"
"""Values are radiance as they stand, whatever their primaries."""
SRGB = "srgb"
"""sRGB's curve (IEC 61966-2-1), of whatever primaries."""
AUTO = "auto"

_SRGB_NAME = "srgb_rec709_scene"


def resolve(space: str, *, stored_as: str, metadata: str | None) -> str:
    """Which colour space stored values are in: "linear", "srgb" or a name of OpenColorIO's configuration.

    space: such a name, or "auto": what the file's metadata says; without a word, floats are linear, 8-bit integers sRGB
    and longer ones linear. Raises ValueError for a name that no configuration knows.
    """
    named = metadata if space == AUTO else space
    if named is None:
        return SRGB if stored_as == "uint8" else AS_STORED
    if named.casefold() in (AS_STORED, SRGB):
        return named.casefold()
    found = find_space(named)
    plain = {find_space(WORKING): AS_STORED, find_space(_SRGB_NAME): SRGB}
    return plain.get(found, found.name)


def decode(stored: NDArray[Any], space: str) -> NDArray[Any]:
    """Linear radiance of stored values, of any shape; [H, W, 3] where a space is neither linear nor sRGB.

    sRGB is decoded in closed form, which is exact to rounding where OpenColorIO's is to 2e-5. Raises ValueError.
    """
    if space == AS_STORED:
        return stored
    if space == SRGB:
        return np.where(stored <= 0.04045, stored / 12.92, ((np.maximum(stored, 0) + 0.055) / 1.055) ** 2.4)
    return to_working(stored, find_space(space))


def quantisation_floor(
    stored: NDArray[Any],
    *,
    stored_as: str,
    space: str,
    domain: Domain,
    display: Display = STANDARD,
    full_scale: int | None = None,
) -> float | None:
    """Mean squared error that rounding to the stored codes makes, radiance^2: step^2 / 12 over the codes in use.

    stored: values as stored, integers scaled to 0..1, of a shape that `decode` takes. full_scale: codes from black to
    white, for limited range. display: whose curve it is in the display domain. None where values are not quantised in
    steps that matter (32-bit floats).
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
    return float(np.mean((above.astype(np.float64) - below) ** 2) / 12)
