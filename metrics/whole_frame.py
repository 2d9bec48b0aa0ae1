"""The error of every pixel: in the reach of tiles, at edges, and in what has just come into view.

Tiles need a surface that stays in view over a span, off every edge of motion. What they leave out, silhouettes and
thin geometry among it, is measured by pairs of frames. A pixel's surface is taken from the frame before at x - m(x),
from pixels of the same surface only, with cubic weights normalised over these pixels and used where their sum is more
than one half. The flicker of a pair is half of its mean squared difference: noise reads its own energy, an error that
is glued to the surface 0, and one that blinks twice its energy. Interpolation takes some energy from the frame before;
of this the share that flickers is given back, so that noise reads its own energy at every sub-pixel place. A pixel
without that surface in the frame before has just come into view.
"""

from dataclasses import dataclass, field
from typing import Any

import numpy as np
import warp as wp
from numpy.typing import NDArray

from metrics.clip import Image
from metrics.correspondence import claims
from metrics.geometry import Field, Geometry, Mask, Surface
from metrics.glints import Glints
from metrics.kernels.launch import Launcher
from metrics.kernels.pairs import COLUMNS, columns, compare_pairs, mark_landed, own_places, sum_blocks
from metrics.kernels.pattern import pattern_at
from metrics.levels import rows_of
from metrics.measurement import Measurement, Metric
from metrics.ratios import Ratios
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
_PAIR = "pairs of frames on the same surface, flicker <d^2>/2 (unbiased variance of two)"
_CLASS = "geometry alone: motion, coverage and where tiles lie"

_PAIRED = "sum (e_t - e_{t-1} there)^2 / 2 over edges, with what interpolation took given back, over their pixels"
_SHARE = "pixels of the class / covered pixels, all frames"
SCORES = {
    "frame.mse": Metric(
        "radiance^2", "lower", "squared error of all covered pixels, silhouettes included", "pixels", "mean of e^2"
    ),
    "measured.fraction": Metric("1", "information", "share of covered pixels that tiles reach", _CLASS, _SHARE),
    "edges.mse": Metric(
        "radiance^2", "lower", "squared error of pixels that tiles do not reach, but pairs do", _PAIR, "mean of e^2"
    ),
    "edges.flicker": Metric(
        "radiance^2", "lower", "part of edges.mse that changes from frame to frame", _PAIR, _PAIRED
    ),
    "edges.floor": Metric(
        "1",
        "information",
        "share of a glued pattern's energy that reads as edges.flicker",
        _PAIR,
        "the same of a glued pattern, over its energy",
    ),
    "edges.fraction": Metric(
        "1", "information", "share of covered pixels that only pairs of frames reach", _CLASS, _SHARE
    ),
    "new.mse": Metric(
        "radiance^2", "lower", "squared error of pixels that the frame before does not show", _CLASS, "mean of e^2"
    ),
    "new.fraction": Metric(
        "1", "information", "share of covered pixels that the frame before does not show", _CLASS, _SHARE
    ),
}

Cells = dict[str, NDArray[np.float64]]


@dataclass
class WholeFrame:
    """Takes in a clip frame by frame, in order."""

    geometry: Geometry
    has_reference: bool
    launcher: Launcher
    glints: Glints = field(default_factory=Glints)
    _frames: list[dict[str, Any]] = field(default_factory=list)
    _cells: Cells = field(default_factory=dict)
    _last: Image | None = None

    def begin(self, span: Span) -> None:
        """The frames of the next span follow."""
        self._span, self._places = span, span.placements()

    def add(self, t: int, error: Image | None, place: Placement | None = None) -> None:
        """The next frame's error [3, H, W], test minus reference; None without one.

        place: where it lies on all rows of the span; None: found here, for all frames of the span.
        """
        surface = self.geometry.surface(t)
        reached = reached_pixels(place or next(self._places), self.launcher) & surface.covered
        error = np.zeros((3, *reached.shape), np.float32) if error is None else np.asarray(error, np.float32)
        owner = None
        if self._last is None or t in self.geometry.clip.cuts:
            pairs = self.launcher.zeros(reached.shape, wp.vec4)
        else:
            owner = shown_before(surface, self.geometry.surface(t - 1), self.launcher)
            pairs = self._compare(error, self._last, surface, owner, reached)
        self._last = error
        sums = self._sum(surface.covered, reached, pairs, error)
        row: dict[str, Any] = {"frame": t}
        for name in CLASSES:
            self._put(f"{name} pixels", sums[name])
        covered = np.sum([sums[name] for name in CLASSES], axis=0)
        self._put("covered pixels", covered)
        if self.has_reference:
            self.glints.add(error, surface.covered, reached, self.launcher)
            flicker = pair_flicker(sums)
            for name, values, pixels in (
                ("frame", sums["squared"], covered),
                ("edges", sums["edges squared"], sums["edges"]),
                ("new", sums["new squared"], sums["new"]),
                ("edges flicker", flicker, sums["edges"]),
            ):
                self._put(name, values)
                if pixels.sum() > 0:
                    key = "edges_flicker" if name == "edges flicker" else f"{name}_mse"
                    row[key] = float(values.sum() / pixels.sum())
        self._frames.append(row)
        if t == (self._span.start + self._span.stop) // 2 and owner is not None and sums["edges"].any():
            self._measure_floor(surface, reached, owner)

    def _measure_floor(self, surface: Surface, reached: Mask, owner: Any) -> None:
        """Pairs of a pattern that is glued to the surface by the motion."""
        waves = texture(0, **_PATTERN)  # type: ignore[arg-type]
        rest = np.zeros_like(surface.motion)
        here, before = (
            np.stack([pattern_at(self.launcher, waves.frequency, waves.phase + c, away) for c in range(3)])
            for away in (-surface.motion, rest)
        )
        pairs = self._compare(here, before, surface, owner, reached)
        sums = self._sum(surface.covered, reached, pairs, here)
        self._put("glued flicker", pair_flicker(sums))
        self._put("glued energy", sums["energy"])

    def _compare(self, frame: Image, before: Image, surface: Surface, owner: Any, reached: Mask) -> Any:
        """What `compare_pairs` finds of the pixels that tiles do not reach."""
        launcher, height = self.launcher, len(reached)
        skipped = reached | ~surface.covered
        found = launcher.empty(reached.shape, wp.vec4)
        pictures = [launcher.view(each, wp.float32) for each in (frame, before)]
        fields = [launcher.view(surface.motion, wp.vec2), owner, ALIKE]
        masks = [launcher.view(skipped.view(np.uint8), wp.uint8), found]
        launcher.over(height, compare_pairs, (), [*pictures, *fields, *masks])
        return found

    @property
    def _cell(self) -> int:
        """Side of a cell of the map, px."""
        return BLOCK // 2 if max(self.geometry.shape) <= FINE else BLOCK

    def _sum(self, covered: Mask, reached: Mask, pairs: Any, error: Image) -> Cells:
        """Sums of every cell of the map, [rows, columns]."""
        launcher, cell = self.launcher, self._cell
        down, right = (-(-length // cell) for length in covered.shape)
        sums = launcher.empty((down, right), columns)
        masks = [launcher.view(mask.view(np.uint8), wp.uint8) for mask in (covered, reached)]
        inputs = [cell, *masks, pairs, launcher.view(error, wp.float32), sums]
        launcher.each(range(down), lambda row: launcher.launch(sum_blocks, (1, right), [row, *inputs]))
        return dict(zip(COLUMNS, np.moveaxis(sums.numpy(), 2, 0), strict=True))

    def _put(self, name: str, values: NDArray[np.float64]) -> None:
        self._cells[name] = self._cells.get(name, 0.0) + values

    def finish(self) -> Measurement:
        """Scores, and the errors of each frame."""
        found = Measurement(frames=self._frames)
        self._score(found, "frame.mse", "frame", "covered pixels", "no pixel is covered")
        for name in CLASSES:
            self._score(found, f"{name}.fraction", f"{name} pixels", "covered pixels", "no pixel is covered")
        for name, reason in (("edges", "tiles reach every pixel"), ("new", "every pixel is shown by the frame before")):
            self._score(found, f"{name}.mse", name, f"{name} pixels", reason)
        self._score(found, "edges.flicker", "edges flicker", "edges pixels", "tiles reach every pixel")
        self._score(found, "edges.floor", "glued flicker", "glued energy", "tiles reach every pixel")
        if self._cells:
            found.curves["frame.map"] = self._map()
        return found

    def _map(self) -> dict[str, list[Any]]:
        """Cell by cell, a text a row of the picture: shares of the classes in percent of all pixels and frames, and the
        flicker of edges in decibels to 1 radiance^2, as `levels.rows_of` has them. cell: its side, px.
        """
        down, right = (np.diff([*range(0, length, self._cell), length]) for length in self.geometry.shape)
        all_pixels = down[:, None] * right[None, :] * len(self._frames)
        shares = {name: np.rint(100 * self._cells[f"{name} pixels"] / all_pixels).astype(int) for name in CLASSES}
        found: dict[str, list[Any]] = {"cell": [self._cell]}
        found |= {name: [" ".join(map(str, row)) for row in share.tolist()] for name, share in shares.items()}
        if self.has_reference:
            edges = self._cells["edges pixels"]
            flicker = np.divide(self._cells["edges flicker"], edges, out=np.zeros_like(edges), where=edges > 0)
            found["flicker"] = list(rows_of(flicker))
        return found

    def _score(self, found: Measurement, score: str, part: str, weight: str, reason: str) -> None:
        if part not in self._cells and not part.startswith("glued"):
            found.put(score, None, "needs a reference")
            return
        weights = in_blocks(self._cells.get(weight, np.zeros((1, 1))), BLOCK // self._cell)
        if not weights.sum() > 0:
            found.put(score, None, reason)
            return
        if score.endswith((".fraction", ".floor")):  # of geometry alone, no chance in it
            found.put(score, self._cells[part].sum() / weights.sum(), "", error=0.0)
            return
        ratios = Ratios()
        ratios.add(BLOCK, weights, {part: in_blocks(self._cells[part], BLOCK // self._cell)})
        found.put(score, ratios.value(part), "", error=ratios.error(part) or 0.0, replicates=ratios.replicates(part))


def in_blocks(cells: NDArray[np.float64], side: int) -> NDArray[np.float64]:
    """Sums of cells [rows, columns] over blocks of side x side of them, in the order of rows."""
    down, right = (-(-length // side) * side for length in cells.shape)
    padded = np.zeros((down, right))
    padded[: cells.shape[0], : cells.shape[1]] = cells
    return np.asarray(padded.reshape(down // side, side, right // side, side).sum(axis=(1, 3)).ravel())


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
    launcher.over(covered.shape[0], own_places, (), [*limits, *fields])
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
