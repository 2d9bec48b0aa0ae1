"""From linear radiance to what a display is sent."""

from typing import Any, Literal, get_args

import numpy as np
from numpy.typing import NDArray

Domain = Literal["linear", "display"]


def encode(radiance: NDArray[Any]) -> NDArray[np.float64]:
    """sRGB code values in 0..1 of linear radiance, any shape: exposure 1, clamped to 0..1 (IEC 61966-2-1).

    >>> float(encode(np.array(1.0)))
    1.0
    """
    clamped = np.clip(np.asarray(radiance, dtype=np.float64), 0.0, 1.0)
    low = 12.92 * clamped
    return np.where(clamped <= 0.0031308, low, 1.055 * np.maximum(clamped, 0.0031308) ** (1 / 2.4) - 0.055)


def to_domain(radiance: NDArray[Any], domain: Domain) -> NDArray[Any]:
    """The radiance itself in the linear domain, its sRGB codes in the display domain. Raises ValueError for others."""
    if domain not in get_args(Domain):
        raise ValueError(f"domain is {domain!r}; choose one of {', '.join(get_args(Domain))}")
    return encode(radiance) if domain == "display" else radiance
