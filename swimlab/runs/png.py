"""Pictures as PNG."""

import cv2
import numpy as np
from numpy.typing import NDArray

COMPRESSION = 6


def png(codes: NDArray[np.uint8]) -> bytes:
    """The bytes of a PNG file of codes [H, W, 3], red first."""
    bgr = np.ascontiguousarray(codes[..., ::-1])
    encoded: NDArray[np.uint8] = cv2.imencode(".png", bgr, [cv2.IMWRITE_PNG_COMPRESSION, COMPRESSION])[1]
    return encoded.tobytes()
