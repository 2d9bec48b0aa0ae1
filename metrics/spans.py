"""Which frames are aligned with each other, and by what: a spatially uniform motion, or exact correspondence."""

from collections.abc import Iterable, Iterator
from dataclasses import dataclass, field
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from metrics import bands
from metrics.clip import Clip
from metrics.tiles import Level, Offset, lay

# A motion field whose values lie this near to each other is taken as uniform, px.
UNIFORM = 1e-4

# Places are held for a whole span, so a span under non-uniform motion ends here, frames.
LONGEST_UNWARPED = 32

# A span may be so long that this share of what a single frame would show is still measured. Under a uniform motion
# long spans cost nothing but area; unwarped ones also lose accuracy.
KEPT = 0.2
KEPT_UNWARPED = 0.3


@dataclass(frozen=True)
class Span:
    """Frames start..stop-1, aligned to one anchor frame.

    offsets: how far the surface is from where the anchor frame has it, (y, x) px, for every frame; all 0 when
        the pictures are unwarped to the anchor's grid, for which `places` and `usable` are set.
    weight: summed w^2 of all tiles, [H, W], in the anchor frame.
    covered: share of wholly covered pixels in the anchor frame.
    bands: for every level the band of distance [n] of each tile; None without depth.
    """

    start: int
    stop: int
    anchor: int
    offsets: list[Offset]
    levels: list[Level]
    weight: NDArray[np.float64] = field(repr=False)
    covered: float
    bands: list[NDArray[np.intp]] | None = field(repr=False)
    places: list[NDArray[np.float32] | None] | None = field(default=None, repr=False)
    usable: NDArray[np.bool_] | None = field(default=None, repr=False)

    @property
    def count(self) -> int:
        return self.stop - self.start

    @property
    def measured(self) -> float:
        """Share of the frame that tiles weigh, 0..1."""
        return float(np.minimum(self.weight, 1.0).mean())

    def align(self, image: NDArray[np.float64], t: int) -> NDArray[np.float64]:
        """Frame t [channels, H, W] in the grid in which tiles lie at `offsets`."""
        if self.places is None or self.usable is None:
            return image
        from metrics.correspondence import unwarp

        return unwarp(image, self.places[t - self.start], self.usable)


@dataclass(frozen=True)
class Alignment:
    """How a clip's frames lie on each other: work that clips of one geometry, such as several techniques, share.

    steps: [count, 2] (y, x) px by which the whole picture moves into each frame; None if it does not move as one.
    """

    steps: NDArray[np.float64] | None
    spans: Iterable[Span]


def align(clip: Clip, *, keep: bool = True) -> Alignment:
    """Align a clip's frames by its motion and coverage.

    keep: hold all spans, to be used again (8 bytes a pixel and frame if the motion is not uniform); else they are
        made as they are asked for, once.
    """
    steps = uniform_steps(clip)
    spans = plan(clip, steps)
    return Alignment(steps, list(spans) if keep else spans)


def uniform_steps(clip: Clip) -> NDArray[np.float64] | None:
    """[count, 2] (y, x) px by which the whole picture moves into each frame, or None if it is not so.

    A field is uniform if it varies by no more than UNIFORM px over the covered pixels; its mean is the step.
    """
    if not callable(clip.motion):
        return np.tile(np.asarray(clip.motion, dtype=np.float64)[::-1], (clip.count, 1))
    steps = np.zeros((clip.count, 2))
    for t in range(1, clip.count):
        covered = clip.covered(t)
        moved = clip.moved(t)
        seen = moved.reshape(-1, 2) if covered is None else moved[covered]
        if len(seen) and np.max(np.ptp(seen, axis=0)) > UNIFORM:
            return None
        steps[t] = seen.mean(axis=0)[::-1] if len(seen) else steps[t - 1]
    return steps


def plan(clip: Clip, steps: NDArray[np.float64] | None) -> Iterator[Span]:
    """Cut a clip in spans as long as tiles stay in view; yields them one by one, in order.

    The spans are about equal, 1, 2, 4, ... of them: as few as measure enough of what a single frame shows.
    """
    kept, longest = (KEPT, clip.count) if steps is not None else (KEPT_UNWARPED, LONGEST_UNWARPED)
    middle = clip.count // 2
    enough = kept * _span(clip, middle, middle + 1, steps).measured
    number = -(-clip.count // longest)
    while True:
        edges = np.linspace(0, clip.count, number + 1).round().astype(int)
        bounds = [(int(start), int(stop)) for start, stop in pairwise(edges)]
        trial = bounds[number // 2]
        span = _span(clip, *trial, steps)
        if span.measured >= enough or clip.count < 4 * number:
            break
        number *= 2
    for bound in bounds:
        yield span if bound == trial else _span(clip, *bound, steps)


def _span(clip: Clip, start: int, stop: int, steps: NDArray[np.float64] | None) -> Span:
    places = usable = None
    if steps is None:
        from metrics.correspondence import follow

        anchor = (start + stop - 1) // 2
        offsets: list[Offset] = [(0.0, 0.0)] * (stop - start)
        places, usable = follow(clip, start, stop)
        levels, weight = lay(clip.shape, offsets[:1], lambda _: usable)
        usable = weight > 0
    else:
        anchor = start
        travelled = np.vstack([np.zeros(2), np.cumsum(steps[start + 1 : stop], axis=0)])
        offsets = [(float(y), float(x)) for y, x in travelled]
        levels, weight = lay(clip.shape, offsets, lambda index: clip.covered(start + index))
    covered = clip.covered(anchor)
    share = 1.0 if covered is None else float(covered.mean())
    tile_bands = bands.of_tiles(clip, levels, anchor)
    return Span(start, stop, anchor, offsets, levels, weight, share, tile_bands, places, usable)
