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


class Pixels:
    """Looks at a clip's frames one by one, in order, from any one on."""

    def __init__(self, geometry: Geometry, launcher: Launcher, *, has_reference: bool) -> None:
        self.geometry, self.launcher, self.has_reference = geometry, launcher, has_reference
        self._last: Image | None = None

    def lead(self, error: Image | None) -> None:
        """The error of the frame before the first one looked at, as `look` takes it."""
        self._last = self._error(error)

    def begin(self, span: Span) -> None:
        """The frames of the next span follow."""
        self._span, self._places = span, span.placements()

    def look(self, t: int, error: Image | None, place: Placement | None = None) -> FrameFound:
        """What is found of the next frame by its error [3, H, W], test minus reference; None without one.

        place: where it lies on all rows of the span; None: found here, for all frames of the span.
        """
        paired = self._last is not None and t not in self.geometry.clip.cuts
        # In this order: of large frames only the surfaces asked for last are held, and the next pair needs this one.
        before = self.geometry.surface(t - 1) if paired else None
        surface = self.geometry.surface(t)
        reached = reached_pixels(place or next(self._places), self.launcher) & surface.covered
        error = self._error(error)
        owner = None if before is None else shown_before(surface, before, self.launcher)
        sums = self._sum(surface, reached, error, self._last, owner)
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
        if t == (self._span.start + self._span.stop) // 2 and owner is not None and sums["edges"].any():
            cells |= self._floor(surface, reached, owner)
        return FrameFound(
            row, cells, count(error, surface.covered, reached, self.launcher) if self.has_reference else None
        )

    def _error(self, error: Image | None) -> Image:
        return np.zeros((3, *self.geometry.shape), np.float32) if error is None else np.asarray(error, np.float32)

    def _floor(self, surface: Surface, reached: Mask, owner: Any) -> Cells:
        """Pairs of a pattern that is glued to the surface by the motion."""
        waves = texture(0, **_PATTERN)  # type: ignore[arg-type]
        here, before = np.empty((2, 3, *reached.shape), np.float32)
        for pattern, moved in ((here, -1), (before, 0)):
            away = moved * surface.motion
            for channel in range(3):
                pattern[channel] = pattern_at(self.launcher, waves.frequency, waves.phase + channel, away)
        sums = self._sum(surface, reached, here, before, owner)
        return {"glued flicker": pair_flicker(sums), "glued energy": sums["energy"]}

    def _sum(self, surface: Surface, reached: Mask, frame: Image, before: Image | None, owner: Any) -> Cells:
        """Sums of every cell of the map, [rows, columns]. owner: from `shown_before`; None: no frame is before."""
        launcher, cell = self.launcher, cell_of(self.geometry.shape)
        down, right = (-(-length // cell) for length in reached.shape)
        sums = launcher.empty((down, right), columns)
        masks = [launcher.view(mask.view(np.uint8), wp.uint8) for mask in (surface.covered, reached)]
        here, motion = launcher.view(frame, wp.float32), launcher.view(surface.motion, wp.vec2)
        pair = [False, here, motion, motion]
        if owner is not None and before is not None:
            pair = [True, launcher.view(before, wp.float32), motion, owner]
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
    limits = [launcher.view(limit, wp.float32) for limit in claims(launcher, surface.motion, surface.covered)]
    owner = launcher.empty(covered.shape, wp.vec2)
    fields = [launcher.view(own, wp.vec2), launcher.view(covered.view(np.uint8), wp.uint8), ALIKE, owner]
    launcher.over(covered.shape[0], own_places(launcher.device), (), [*limits, *fields])
    return owner


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
