"""Scores by metrics of other projects, which are found in `scoring.peers`, a file each."""

from collections.abc import Sequence
from functools import cache

import numpy as np

from metrics import Clip, ClipError
from metrics.plugins import discover
from swimlab.scoring import peers as folder
from swimlab.scoring.peer import Peer, PeerError


@cache
def peers() -> dict[str, Peer]:
    """Every peer by its name."""
    return discover(folder, "PEER")


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
        raise PeerError(f"--peers {name}: is no metric that is known; there are {', '.join(peers())}")
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
