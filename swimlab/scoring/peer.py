"""A metric of another project, for cross-checks: it measures the same clips, shown as sRGB."""

from collections.abc import Callable, Iterator
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from metrics import Clip
from metrics.display import encode

Codes = NDArray[np.float32]
"""[H, W, 3] sRGB codes in 0..1, writable and contiguous."""


class PeerError(ValueError):
    """A metric that is not available; the message says why and how to mend it."""


@dataclass(frozen=True)
class Peer:
    """A metric of another project.

    extra: the extra of swimlab that installs it, "" where it comes with the core. score: test and reference to values
    by name.
    """

    name: str
    summary: str
    source: str
    extra: str
    score: Callable[[Clip, Clip], dict[str, float]]


def displayed(clip: Clip, frame: int) -> Codes:
    """A frame as sRGB codes."""
    codes = np.moveaxis(encode(clip.image(frame)), 0, 2)
    return np.array(codes, np.float32, order="C")


def frame_means(
    name: str, test: Clip, reference: Clip, difference: Callable[[Codes, Codes], float]
) -> dict[str, float]:
    """Mean and largest of a picture metric `difference(test, reference)` over the frames."""
    values = [difference(a, b) for a, b in _pairs(test, reference)]
    return {f"{name}.mean": float(np.mean(values)), f"{name}.worst": float(np.max(values))}


def _pairs(test: Clip, reference: Clip) -> Iterator[tuple[Codes, Codes]]:
    for frame in range(test.count):
        yield displayed(test, frame), displayed(reference, frame)
