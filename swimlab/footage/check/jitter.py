"""The sub-pixel jitter that motion vectors have and frames have not, or the other way round, found from both."""

from collections.abc import Callable

import numpy as np

from swimlab.footage.check.grey import Frames
from swimlab.footage.check.lucas_kanade import Values
from swimlab.footage.check.pairs import PairFit, fit_pairs
from swimlab.footage.motion import Motion
from swimlab.runs.frames import Image


def estimate_jitter(
    motion: Motion,
    picture: Callable[[int], Image],
    coverage: Callable[[int], Image] | None,
    frames: list[int],
    count: int,
) -> Values:
    """[count, 2] px right and down: the jitter in each frame's vectors that the frames do not have, its mean 0.

    Vectors of frame t since t - 1 hold jitter[t] - jitter[t - 1] too much; frames that are shifted where the vectors
    are not have the jitter of the opposite sign. All that shifts the whole picture is found, swimming and a wrong
    factor too: hold it against the engine's own. picture, coverage: index -> [H, W, 3] radiance, [H, W]. frames: the
    indices that are measured, in order; others get the jitter of the one before. Accurate to a few hundredths of a
    pixel where the frames' noise is small. Source: Lucas and Kanade, IJCAI 1981, frame by frame, and summed.
    """
    pairs = fit_pairs(motion, Frames(picture, coverage, frames), frames)
    return integrated(pairs, count)


def integrated(pairs: list[PairFit], count: int) -> Values:
    """[count, 2] px: the sum over the pairs of what the motion has too much, its mean 0."""
    change = np.zeros((count, 2))
    for pair in pairs:
        change[pair.late] = -np.where(np.isfinite(pair.error), pair.shift, 0.0)
    jitter = np.cumsum(change, axis=0)
    return np.asarray(jitter - jitter.mean(axis=0))
