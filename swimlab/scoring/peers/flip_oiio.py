"""LDR-FLIP as OpenImageIO has it (experimental there since 3.2): faster, and it wants linear light."""

import numpy as np

from metrics import Clip
from swimlab.scoring.peer import Codes, Peer, PeerError, frame_means

PIXELS_PER_DEGREE = 67.02064514160156
"""FLIP's own default: a 0.7 m wide 4K display seen from 0.7 m."""


def score(test: Clip, reference: Clip) -> dict[str, float]:
    """Mean FLIP of each frame, 0..1; at the clip's pixels per degree, else at FLIP's own 67."""
    import OpenImageIO as oiio  # noqa: N813, heavy

    if not hasattr(oiio.ImageBufAlgo, "FLIP_diff"):
        raise PeerError(f"--peers flip-oiio: OpenImageIO {oiio.VERSION_STRING} has no FLIP_diff; install 3.2 or later")

    def difference(picture: Codes, exact: Codes) -> float:
        first, second = (oiio.ImageBuf(_linear(codes)) for codes in (exact, picture))
        errors = oiio.ImageBufAlgo.FLIP_diff(first, second, hdr=0, ppd=test.pixels_per_degree or PIXELS_PER_DEGREE)
        pixels = errors.get_pixels(oiio.FLOAT)
        if errors.has_error or pixels is None:
            raise PeerError(f"--peers flip-oiio: {errors.geterror()}")
        return float(np.mean(pixels, dtype=np.float64))

    return frame_means("flip-oiio", test, reference, difference)


def _linear(codes: Codes) -> Codes:
    """sRGB codes decoded (IEC 61966-2-1)."""
    decoded = np.where(codes <= 0.04045, codes / 12.92, ((codes + 0.055) / 1.055) ** 2.4)
    return np.ascontiguousarray(decoded, np.float32)


PEER = Peer(
    name="flip-oiio",
    summary="mean FLIP a frame, 0..1, lower is better",
    source="Andersson et al. 2020, OpenImageIO's FLIP_diff",
    extra="",
    score=score,
)
