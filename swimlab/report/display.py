"""Linear radiance to 8-bit pictures: sRGB to look at, signed codes on a fixed scale for errors.

Both as lossless WebP: on sharp 640x360 frames it was 30% smaller than PNG. An error in 63 steps is a third
smaller than in 255.
"""

import base64

import cv2
import numpy as np
from numpy.typing import NDArray

from swimlab.frames import Image

Picture = NDArray[np.uint8]

ERROR_RANGE = 0.5
ERROR_STEPS = 31
UNMEASURED = 0
COVERED = 0.999


def srgb(rgb: Image) -> Picture:
    """Encode linear radiance [..., 3], clamped to 0..1, as sRGB codes 0..255 (IEC 61966-2-1)."""
    linear = np.clip(rgb, 0, 1)
    encoded = np.where(linear <= 0.0031308, 12.92 * linear, 1.055 * linear ** (1 / 2.4) - 0.055)
    codes: Picture = np.rint(255 * encoded).astype(np.uint8)
    return codes


def error_codes(test: Image, reference: Image) -> Picture:
    """Code test - reference (both RGBA [H, W, 4]), mean of R, G, B, as [H, W] codes 1..63.

    Code 32 is no error; one step is ERROR_RANGE / ERROR_STEPS of linear radiance; larger errors are clamped.
    UNMEASURED marks pixels that the reference does not cover wholly.
    """
    error = np.mean(test[..., :3] - reference[..., :3], axis=2)
    steps = np.rint(np.clip(error / ERROR_RANGE, -1, 1) * ERROR_STEPS) + ERROR_STEPS + 1
    return np.where(reference[..., 3] >= COVERED, steps, UNMEASURED).astype(np.uint8)


def webp(picture: Picture) -> str:
    """Lossless WebP of sRGB codes [H, W, 3] or grey codes [H, W], as base64 text."""
    blue_first = picture[..., ::-1] if picture.ndim == 3 else picture
    _, encoded = cv2.imencode(".webp", np.ascontiguousarray(blue_first), [cv2.IMWRITE_WEBP_QUALITY, 101])
    return base64.b64encode(encoded.tobytes()).decode("ascii")
