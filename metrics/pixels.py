"""Every pixel of a frame, by pairs of frames.

A pixel's surface is taken from the frame before at x - m(x), from pixels of the same surface only, with cubic weights
normalised over these pixels and used where their sum is more than one half. The flicker of a pair is half of its mean
squared difference: noise reads its own energy, an error that is glued to the surface 0, and one that blinks twice its
energy. Interpolation takes some energy from the frame before; of this the share that flickers is given back, so that
noise reads its own energy at every sub-pixel place. A pixel without that surface in the frame before has just come into
view.
"""

from typing import Any, NamedTuple

import numpy as np
import warp as wp
from numpy.typing import NDArray

from metrics.clip import Image
from metrics.correspondence import claims
from metrics.geometry import Field, Geometry, Mask, Surface
from metrics.glints import Counted, count
from metrics.kernels.claims import own_places
from metrics.kernels.launch import Launcher
from metrics.kernels.pairs import COLUMNS, columns, mark_landed, sum_blocks
from metrics.kernels.pattern import pattern_at
from metrics.memory import unset
from metrics.spans import Placement, Span
from metrics.synthetic import texture

ALIKE = 0.3
"""Pixels whose motion differs by less show the same surface, px a frame."""

BLOCK = 32
"""Side of the blocks of pixels by which standard errors are found, px."""

FINE = 1024
"""Up to this width and height, px, a cell of the map is half as wide as a block, and beyond as wide."""

CLASSES = ("measured", "edges", "new")

_PATTERN = {"limit": 1 / 8, "waves": 6}

Cells = dict[str, NDArray[np.float64]]


class FrameFound(NamedTuple):
    """What was found of a frame. row: its errors. cells: sums, cell by cell of the map. counted: see `glints.count`."""

    row: dict[str, Any]
    cells: Cells
    counted: Counted | None


class Paired(NamedTuple):
    """How a frame goes with the one before.

    covered, reached: [H, W], where a surface is, and where tiles reach it. motion: since the frame before. owner: what
    that frame shows, as `shown_before` has it; None: there is none. floor: cells of a pattern that is glued to the
    surface, in the middle of a span.
    """

    covered: Mask
    reached: Mask
    motion: Field
    owner: Any
    floor: Cells


class Pixels:
    """Looks at a clip's frames one by one, in order, from any one on."""

    def __init__(self, geometry: Geometry, launcher: Launcher, *, has_reference: bool) -> None:
        self.geometry, self.launcher, self.has_reference = geometry, launcher, has_reference
        self._last: Image | None = None
        self._before: Surface | None = None

    def lead(self, error: Image | None) -> None:
        """The error of the frame before the first one looked at, as `look` takes it."""
        self._last, self._before = self._error(error), None

    def begin(self, span: Span) -> None:
        """The frames of the next span follow."""
        self._span, self._places = span, span.placements()

    def pair(self, t: int, place: Placement | None = None) -> Paired:
        """How the next frame goes with the one before: large ones leave room for it before their pictures are read.

        place: where it lies on all rows of the span; None: found here, for all frames of the span.
        """
        before = self._before
        if self._last is None or t in self.geometry.clip.cuts:
            before = None
        elif before is None:
            before = self.geometry.surface(t - 1)
        surface = self._before = self.geometry.surface(t)
        reached = reached_pixels(place or next(self._places), self.launcher) & surface.covered
        owner = None if before is None else shown_before(surface, before, self.launcher)
        found = Paired(surface.covered, reached, surface.motion, owner, {})
        middle = t == (self._span.start + self._span.stop) // 2
        return found._replace(floor=self._floor(found)) if middle and owner is not None else found

    def look(self, t: int, error: Image | None, paired: Paired) -> FrameFound:
        """What is found of the next frame by its error [3, H, W], test minus reference; None without one."""
        error = self._error(error)
        sums = self._sum(paired, error, self._last)
        self._last = error
        covered = np.sum([sums[name] for name in CLASSES], axis=0)
        cells = {f"{name} pixels": sums[name] for name in CLASSES} | {"covered pixels": covered}
        row: dict[str, Any] = {"frame": t}
        if self.has_reference:
            flicker = pair_flicker(sums)
            for name, values, pixels in (
                ("frame", sums["squared"], covered),
                ("edges", sums["edges squared"], sums["edges"]),
                ("new", sums["new squared"], sums["new"]),
                ("edges flicker", flicker, sums["edges"]),
            ):
                cells[name] = values
                if pixels.sum() > 0:
                    key = "edges_flicker" if name == "edges flicker" else f"{name}_mse"
                    row[key] = float(values.sum() / pixels.sum())
        counted = count(error, paired.covered, paired.reached, self.launcher) if self.has_reference else None
        return FrameFound(row, cells | paired.floor, counted)

    def _error(self, error: Image | None) -> Image:
        return np.zeros((3, *self.geometry.shape), np.float32) if error is None else np.asarray(error, np.float32)

    def _floor(self, paired: Paired) -> Cells:
        """Pairs of a pattern that is glued to the surface by the motion."""
        waves = texture(0, **_PATTERN)  # type: ignore[arg-type]
        here, before = (unset((3, *paired.reached.shape), np.float32) for _ in range(2))
        for pattern, times in ((here, -1.0), (before, 0.0)):
            for channel in range(3):
                phase = waves.phase + channel
                pattern[channel] = pattern_at(self.launcher, waves.frequency, phase, paired.motion, times=times)
        sums = self._sum(paired, here, before)
        return {"glued flicker": pair_flicker(sums), "glued energy": sums["energy"]}

    def _sum(self, paired: Paired, frame: Image, before: Image | None) -> Cells:
        """Sums of every cell of the map, [rows, columns]."""
        launcher, cell = self.launcher, cell_of(self.geometry.shape)
        down, right = (-(-length // cell) for length in paired.reached.shape)
        sums = launcher.empty((down, right), columns)
        masks = [launcher.view(mask.view(np.uint8), wp.uint8) for mask in (paired.covered, paired.reached)]
        here, motion = launcher.view(frame, wp.float32), launcher.view(paired.motion, wp.vec2)
        pair = [False, here, motion, motion]
        if paired.owner is not None and before is not None:
            pair = [True, launcher.view(before, wp.float32), motion, paired.owner]
        launcher.over(down, sum_blocks(launcher.device), (right,), [cell, *masks, here, *pair, ALIKE, sums], strip=1)
        return dict(zip(COLUMNS, np.moveaxis(sums.numpy(), 2, 0), strict=True))


def cell_of(shape: tuple[int, int]) -> int:
    """Side of a cell of the map of frames [H, W], px."""
    return BLOCK // 2 if max(shape) <= FINE else BLOCK


def shown_before(surface: Surface, before: Surface, launcher: Launcher) -> Any:
    """How what each pixel of the frame before shows moves into this frame, [H, W] px, NaN where it is not known.

    Pixels of this frame claim the places that they come from. Where claims differ, one of the surfaces was hidden, and
    the motion that the frame before has itself decides; so it does where a place is claimed by none.
    """
    covered = before.covered
    if surface.uniform:
        return launcher.view(np.where(covered[..., None], surface.motion, np.float32(np.nan)), wp.vec2)
    own = before.motion if before.known else np.full_like(before.motion, np.nan)
    least, most = claims(launcher, surface.motion, surface.covered)
    # What is found of a place stands where its least claim stood.
    fields = [launcher.view(own, wp.vec2), launcher.view(covered.view(np.uint8), wp.uint8), ALIKE, least]
    launcher.over(covered.shape[0], own_places(launcher.device), (), [least, most, *fields])
    return least


def pair_flicker(sums: Cells) -> NDArray[np.float64]:
    """Flicker of every cell's edges, summed over their pixels.

    Of the energy that interpolation takes, the share that flickers is added to all in proportion.
    """
    difference, smooth, energy = (sums[name] for name in ("difference", "smooth", "energy"))
    half, lost, total = difference.sum() / 2, energy.sum() - smooth.sum(), energy.sum()
    if half <= 0 or total <= 0:
        return np.asarray(difference / 2)
    share = lost / (2 * total)
    mended = half / (1 - share)
    mended = mended if mended < total else half + lost / 2
    return np.asarray(difference / 2 * max(1.0, mended / half))


def reached_pixels(place: Placement, launcher: Launcher) -> Mask:
    """The pixels [H, W] of a frame where the surface is that the tiles of its span reach."""
    span = place.span
    if place.away is not None:
        return span.reached if place.t == span.anchor else _landed(place.away, span.reached, launcher)
    moved = np.zeros_like(span.reached)
    height, width = span.shape
    offset = span.offsets[place.t - span.start]
    down = min(max(round(offset[0]), -height), height)
    right = min(max(round(offset[1]), -width), width)
    to = slice(max(0, down), height + min(0, down)), slice(max(0, right), width + min(0, right))
    of = slice(max(0, -down), height - max(0, down)), slice(max(0, -right), width - max(0, right))
    moved[to] = span.reached[of]
    return moved


def _landed(away: Field, reached: Mask, launcher: Launcher) -> Mask:
    """Pixels that some of the reached ones land on; what magnification leaves open is closed."""
    import cv2  # heavy

    landed = launcher.zeros(reached.shape, wp.uint8)
    inputs = [launcher.view(reached.view(np.uint8), wp.uint8), launcher.view(away, wp.vec2), landed]
    launcher.over(reached.shape[0], mark_landed, (), inputs)
    square = np.ones((3, 3), np.uint8)
    closed = cv2.morphologyEx(landed.numpy(), cv2.MORPH_CLOSE, square, borderType=cv2.BORDER_CONSTANT, borderValue=0)
    return np.asarray((closed > 0) | (landed.numpy() > 0))
