"""The metrics that are compared: each gives a clip one number, and says how it was run."""

from collections.abc import Callable
from dataclasses import dataclass
from functools import partial
from math import isfinite, log10, sqrt

import cv2
import numpy as np

from metrics import Clip, measure
from swimlab.footage.motion import EstimatedMotion
from swimlab.runs.frames import Image
from swimlab.scoring.peer import Codes, PeerError, displayed
from swimlab.scoring.peer_scores import peer_scores

_CONSISTENT = (0.01, 0.5)
"""Flow there and back may differ by this share of its squares, and by so many px^2 (Ruder et al. 2016, eq. 5)."""


@dataclass(frozen=True)
class Judge:
    """score: test and reference to a value. worse: the value to how bad it says the test is, 0 for the reference."""

    name: str
    how: str
    score: Callable[[Clip, Clip], float]
    worse: Callable[[float], float] = float

    def value(self, test: Clip, reference: Clip) -> float | str:
        """The value, or why there is none."""
        try:
            value = self.score(test, reference)
        except PeerError as error:
            return str(error)
        return value if isfinite(value) else f"came out as {value}"


def _psnr(test: Clip, reference: Clip) -> float:
    squares = [np.mean((displayed(test, t) - displayed(reference, t)) ** 2) for t in range(test.count)]
    return float(-10 * log10(np.mean(squares)))


def _ssim(test: Clip, reference: Clip) -> float:
    def one(t: int) -> float:
        exact, picture = (255 * displayed(clip, t) for clip in (reference, test))
        return float(np.mean(cv2.quality.QualitySSIM.create(exact).compute(picture)[:3]))

    return float(np.mean([one(t) for t in range(test.count)]))


def _differences(test: Clip, reference: Clip) -> float:
    del reference  # it looks at the test alone
    changes = [np.mean((displayed(test, t) - displayed(test, t - 1)) ** 2) for t in range(1, test.count)]
    return float(np.sqrt(np.mean(changes)))


def _error_differences(test: Clip, reference: Clip) -> float:
    def error(t: int) -> Codes:
        return displayed(test, t) - displayed(reference, t)

    return float(np.sqrt(np.mean([np.mean((error(t) - error(t - 1)) ** 2) for t in range(1, test.count)])))


def _warping_error(test: Clip, reference: Clip) -> float:
    del reference  # it looks at the test alone
    flow = EstimatedMotion(lambda t: np.asarray(test.frame(t), np.float32))
    changes = []
    for t in range(1, test.count):
        there, back = flow.moved(t, t - 1), flow.moved(t - 1, t)
        squares = (displayed(test, t) - _taken(displayed(test, t - 1), there)) ** 2
        apart = ((there + _taken(back, there)) ** 2).sum(axis=2)
        share, least = _CONSISTENT
        seen = apart < share * ((there**2).sum(axis=2) + (back**2).sum(axis=2)) + least
        # Outside of the frame before nothing is finite.
        seen &= np.isfinite(squares).all(axis=2)
        changes.append(float(squares[seen].mean()) if seen.any() else 0.0)
    return float(np.sqrt(np.mean(changes)))


def _taken(picture: Image, moved: Image) -> Image:
    """A picture [H, W, n] of the frame before, taken from where the surface of each pixel was."""
    y, x = np.indices(moved.shape[:2], dtype=np.float32)
    places = x - moved[..., 0], y - moved[..., 1]
    outside = (float("nan"),) * 4
    return np.asarray(
        cv2.remap(picture, *places, cv2.INTER_LINEAR, borderMode=cv2.BORDER_CONSTANT, borderValue=outside)
    )


def _peer(name: str, score: str, test: Clip, reference: Clip) -> float:
    return peer_scores(name, test, reference)[score]


def _ours(score: str, test: Clip, reference: Clip) -> float:
    found = measure(test, reference, names=[score.partition(".")[0]])
    if score not in found.scores:
        raise PeerError(f"{score}: {found.absent.get(score, 'is absent')}")
    return sqrt(max(0.0, found.scores[score]))


OTHERS = (
    Judge("PSNR, dB", "of sRGB codes over all frames, peak 1", _psnr, lambda value: 10 ** (-value / 20)),
    Judge(
        "SSIM",
        "OpenCV's quality module: Gaussian of 11x11 (Wang et al. 2004), sRGB codes, mean of channels and frames",
        _ssim,
        lambda value: 1 - value,
    ),
    Judge(
        "FLIP", "OpenImageIO's FLIP_diff, 67 px a degree, mean of frames", partial(_peer, "flip-oiio", "flip-oiio.mean")
    ),
    Judge("frame difference", "rms change of sRGB codes from frame to frame; no reference", _differences),
    Judge("change of the error", "rms change of the error, sRGB codes, from frame to frame", _error_differences),
    Judge(
        "warping error",
        "rms difference of sRGB codes to the frame before, taken along the test's optical flow (DIS, medium) where "
        "flow there and back agrees (Lai et al. 2018, with this flow); no reference",
        _warping_error,
    ),
    Judge(
        "ColorVideoVDP, JOD",
        "cvvdp by its Python API on the CPU (extra `vdp`), display standard_4k, the clip's frame rate",
        partial(_peer, "vdp", "vdp.jod"),
        lambda value: 10 - value,
    ),
    Judge(
        "VMAF",
        "libvmaf v0.6.1 in the ffmpeg of imageio-ffmpeg (extra `vmaf`), 8 bit, yuv444p, mean of frames",
        partial(_peer, "vmaf", "vmaf.mean"),
        lambda value: 100 - value,
    ),
)
OURS = tuple(
    Judge(name, f"root of swimlab's `{name}`, linear radiance, exact motion", partial(_ours, name))
    for name in ("budget.flicker", "edges.flicker", "new.mse")
)
