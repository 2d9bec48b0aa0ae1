"""Metrics of other projects for cross-checks: found in `scoring.peers`, run on the same clips, told apart by name."""

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from functools import cache

import numpy as np
from numpy.typing import NDArray

import swimlab.scoring.peers
from metrics import Clip, ClipError
from metrics.display import encode
from swimlab.runs.registry import discover

Codes = NDArray[np.float32]
"""[H, W, 3] sRGB codes in 0..1, writable and contiguous."""


class PeerError(ValueError):
    """A metric that cannot be had; the message says why and how to mend it."""


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


@cache
def peers() -> dict[str, Peer]:
    """Every peer by its name."""
    return discover(swimlab.scoring.peers, "PEER")


def all_peer_scores(names: Sequence[str], test: Clip, reference: Clip | None) -> dict[str, float]:
    """Scores of several peers by name. Raises PeerError as `peer_scores` does, and where there is no reference."""
    if names and reference is None:
        raise PeerError(f"--peers {','.join(names)}: compares with a reference; give one")
    found: dict[str, float] = {}
    for name in names:
        found |= peer_scores(name, test, reference) if reference is not None else {}
    return found


def peer_scores(name: str, test: Clip, reference: Clip) -> dict[str, float]:
    """Scores of a peer by name, as {"flip.mean": 0.02}.

    Both clips are looked at as displayed: exposure 1, clamped, sRGB. Raises PeerError for an unknown peer, one that is
    not installed, and one that gives no number; ClipError for clips that do not match.
    """
    if name not in peers():
        raise PeerError(f"--peers {name}: there are {', '.join(peers())}")
    if (test.count, test.shape) != (reference.count, reference.shape):
        raise ClipError(f"{name}: test and reference need as many frames of the same size")
    peer = peers()[name]
    try:
        found = peer.score(test, reference)
    except ImportError as error:
        raise PeerError(
            f"--peers {name}: is not installed ({error}); install it: pip install 'swimlab[{peer.extra}]'"
        ) from error
    if not all(map(np.isfinite, found.values())):
        raise PeerError(f"--peers {name}: came out as {found}")
    return found


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
