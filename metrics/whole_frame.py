"""The error of every pixel: in the reach of tiles, at edges, and in what has just come into view.

Tiles need a surface that stays in view over a span, off every edge of motion. What they leave out, silhouettes and
thin geometry among it, is measured by pairs of frames. A pixel's surface is taken from the frame before at x - m(x),
from pixels of the same surface only, with cubic weights normalised over these pixels and used where their sum is more
than one half. The flicker of a pair is half of its mean squared difference: noise reads its own energy, an error that
is glued to the surface 0, and one that blinks twice its energy. Interpolation takes some energy from the frame before;
of this the share that flickers is given back, so that noise reads its own energy at every sub-pixel place. A pixel
without that surface in the frame before has just come into view.
"""

from collections.abc import Callable, Iterator
from dataclasses import dataclass, field
from typing import Any

import numpy as np
import warp as wp
from numpy.typing import NDArray
from scipy import ndimage

from metrics.clip import Clip, Image
from metrics.kernels.launch import Launcher, Strip
from metrics.kernels.pairs import compare_pairs
from metrics.measurement import Measurement, Metric
from metrics.ratios import Ratios
from metrics.spans import Span
from metrics.synthetic import centres, texture

ALIKE = 0.3
"""Pixels whose motion differs by less show the same surface, px a frame."""

BLOCK = 32
"""Side of the blocks of pixels by which standard errors are found, px."""

CLASSES = ("measured", "edges", "new")

_PATTERN = {"limit": 1 / 8, "waves": 6}
_PAIR = "pairs of frames on the same surface, flicker <d^2>/2 (unbiased variance of two)"
_CLASS = "geometry alone: motion, coverage and where tiles lie"

SCORES = {
    "frame.mse": Metric("radiance^2", "lower", "squared error of all covered pixels, silhouettes included", "pixels"),
    "measured.fraction": Metric("1", "information", "share of covered pixels that tiles reach", _CLASS),
    "edges.mse": Metric("radiance^2", "lower", "squared error of pixels that tiles do not reach, but pairs do", _PAIR),
    "edges.flicker": Metric("radiance^2", "lower", "part of edges.mse that changes from frame to frame", _PAIR),
    "edges.floor": Metric("1", "information", "share of a glued pattern's energy that reads as edges.flicker", _PAIR),
    "edges.fraction": Metric("1", "information", "share of covered pixels that only pairs of frames reach", _CLASS),
    "new.mse": Metric("radiance^2", "lower", "squared error of pixels that the frame before does not show", _CLASS),
    "new.fraction": Metric("1", "information", "share of covered pixels that the frame before does not show", _CLASS),
}

Field = NDArray[np.float32]
Mask = NDArray[np.bool_]


@dataclass(frozen=True)
class Surface:
    """What a frame shows: where, [H, W], and how it moved since the frame before, [H, W, 2] px (x, y).

    known: whether the motion is known, which that of the first frame need not be. uniform: whether it is one for all.
    """

    covered: Mask
    motion: Field
    known: bool
    uniform: bool = False


@dataclass
class WholeFrame:
    """Takes in a clip frame by frame, in order.

    geometry: the clip's motion and coverage. error: frame -> [H, W, 3], test minus reference; None without one.
    """

    geometry: Clip
    error: Callable[[int], Image] | None
    launcher: Launcher
    _frames: list[dict[str, Any]] = field(default_factory=list)
    _blocks: dict[str, Any] = field(default_factory=dict)
    _before: tuple[Surface, Image | None] | None = None

    def add(self, span: Span) -> None:
        """Measure the next span."""
        for t, reached in reached_pixels(span):
            surface = surface_of(self.geometry, t)
            error = None if self.error is None else np.ascontiguousarray(self.error(t), np.float32)
            self._frame(t, reached & surface.covered, surface, error, floor=t == span.start + span.count // 2)
            self._before = surface, error

    def _frame(self, t: int, reached: Mask, surface: Surface, error: Image | None, *, floor: bool) -> None:
        blank = np.zeros((*reached.shape, 3), np.float32)
        if self._before is None:
            pairs = np.zeros((*reached.shape, 4), np.float32)
        else:
            before, last = self._before
            owner = shown_before(surface, before)
            pairs = self._compare(blank if error is None else error, blank if last is None else last, surface, owner)
        seen = pairs[..., 0] > 0
        classes = {
            "measured": reached,
            "edges": surface.covered & ~reached & seen,
            "new": surface.covered & ~reached & ~seen,
        }
        for name, inside in classes.items():
            self._put(f"{name} pixels", inside)
        self._put("covered pixels", surface.covered)
        row: dict[str, Any] = {"frame": t}
        if error is not None:
            squared = np.mean(np.square(error, dtype=np.float64), axis=2)
            self._put("frame", np.where(surface.covered, squared, 0.0))
            row["frame_mse"] = _mean(squared, surface.covered)
            for name in ("edges", "new"):
                self._put(name, np.where(classes[name], squared, 0.0))
                row[f"{name}_mse"] = _mean(squared, classes[name])
            flicker = pair_flicker(pairs, classes["edges"])
            self._put("edges flicker", flicker)
            row["edges_flicker"] = _mean(flicker, classes["edges"])
        if floor and self._before is not None and classes["edges"].any():
            pairs = self._glued(surface, owner)
            self._put("glued flicker", pair_flicker(pairs, classes["edges"]))
            self._put("glued energy", np.where(classes["edges"], pairs[..., 3], 0.0))
        self._frames.append({key: value for key, value in row.items() if value is not None})

    def _glued(self, surface: Surface, owner: Field) -> Field:
        """Pairs of a pattern that is glued to the surface by the motion."""
        pattern = texture(0, **_PATTERN)  # type: ignore[arg-type]
        x, y = centres(*surface.covered.shape)
        # A pattern over a row and a column is made faster than over every place.
        moved = surface.motion[0, 0] if surface.uniform else surface.motion.astype(np.float64)
        here = pattern.at(x - moved[..., 0], y - moved[..., 1]).astype(np.float32)
        return self._compare(here, pattern.at(x, y).astype(np.float32), surface, owner)

    def _compare(self, frame: Image, before: Image, surface: Surface, owner: Field) -> Field:
        launcher = self.launcher
        height, width = surface.covered.shape
        found = launcher.empty((height, width), wp.vec4)
        pictures = [launcher.array(each, wp.vec3) for each in (frame, before)]
        fields = [launcher.array(each, wp.vec2) for each in (surface.motion, owner)]

        def compare(strip: Strip) -> None:
            inputs = [strip.first, *pictures, *fields, ALIKE, found]
            launcher.launch(compare_pairs, (strip.rows, width), inputs)

        launcher.each(launcher.strips(height), compare)
        return np.asarray(found.numpy(), np.float32)

    def _put(self, name: str, values: NDArray[Any]) -> None:
        self._blocks[name] = self._blocks.get(name, 0.0) + block_sums(values)

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
        return found

    def _score(self, found: Measurement, score: str, part: str, weight: str, reason: str) -> None:
        if part not in self._blocks and not part.startswith("glued"):
            found.put(score, None, "needs a reference")
            return
        weights = self._blocks.get(weight, np.zeros(1))
        if not weights.sum() > 0:
            found.put(score, None, reason)
            return
        if score.endswith((".fraction", ".floor")):  # of geometry alone, no chance in it
            found.put(score, self._blocks[part].sum() / weights.sum(), "", error=0.0)
            return
        ratios = Ratios()
        ratios.add(BLOCK, weights, {part: self._blocks[part]})
        found.put(score, ratios.value(part), "", error=ratios.error(part) or 0.0, replicates=ratios.replicates(part))


def surface_of(clip: Clip, t: int) -> Surface:
    """What frame t of a clip shows, silhouettes included.

    A pixel whose centre no surface covers takes the motion of the nearest neighbour that has one.
    """
    share = clip.share(t)
    covered = np.ones(clip.shape, dtype=bool) if share is None else share > 0
    if not callable(clip.motion):
        motion = np.broadcast_to(np.asarray(clip.motion, np.float32), (*clip.shape, 2))
        return Surface(covered, motion, known=True, uniform=True)
    motion = np.nan_to_num(np.asarray(clip.motion(t), dtype=np.float32))
    depth = clip.distance(t)
    if depth is not None:
        bare = covered & ~(depth > 0)
        if bare.any() and not bare[covered].all():
            _, (row, column) = ndimage.distance_transform_edt(~(depth > 0), return_indices=True)
            motion = motion.copy()
            motion[bare] = motion[row[bare], column[bare]]
    return Surface(covered, motion, known=t > 0 or bool(motion.any()))


def shown_before(surface: Surface, before: Surface) -> Field:
    """How what each pixel of the frame before shows moves into this frame, [H, W, 2] px; NaN where it is not known.

    Pixels of this frame claim the places that they come from. Where claims differ, one of the surfaces was hidden, and
    the motion that the frame before has itself decides; so it does where a place is claimed by none.
    """
    height, width = surface.covered.shape
    if surface.uniform:
        return np.where(before.covered[..., None], surface.motion, np.float32(np.nan))
    own = before.motion if before.known else np.full_like(before.motion, np.nan)
    row, column = np.nonzero(surface.covered)
    moved = surface.motion[row, column]
    r, c = np.rint(row - moved[:, 1]).astype(np.intp), np.rint(column - moved[:, 0]).astype(np.intp)
    inside = (r >= 0) & (r < height) & (c >= 0) & (c < width)
    place, moved = (r * width + c)[inside], moved[inside]
    claims = np.empty((height * width, 2), np.float32)
    apart = np.zeros(height * width, dtype=bool)
    for axis in range(2):
        least = np.full(height * width, np.inf, np.float32)
        most = -least
        np.minimum.at(least, place, moved[:, axis])
        np.maximum.at(most, place, moved[:, axis])
        with np.errstate(invalid="ignore"):
            claims[:, axis] = (least + most) / 2
            apart |= ~(most - least <= ALIKE)
    claims[apart] = own.reshape(-1, 2)[apart]
    claims[~before.covered.ravel()] = np.nan
    return claims.reshape(height, width, 2)


def pair_flicker(pairs: Field, inside: Mask) -> NDArray[np.float64]:
    """Flicker [H, W] of the pixels inside, from what `compare_pairs` found.

    Of the energy that interpolation takes, the share that flickers is added to all pixels in proportion.
    """
    difference, smooth, energy = (np.where(inside, pairs[..., k], 0.0).astype(np.float64) for k in (1, 2, 3))
    half, lost, total = difference.sum() / 2, energy.sum() - smooth.sum(), energy.sum()
    if half <= 0 or total <= 0:
        return np.asarray(difference / 2)
    share = lost / (2 * total)
    mended = half / (1 - share)
    mended = mended if mended < total else half + lost / 2
    return np.asarray(difference / 2 * max(1.0, mended / half))


def reached_pixels(span: Span) -> Iterator[tuple[int, Mask]]:
    """Frame by frame of a span, in order, the pixels [H, W] where the surface is that its tiles reach."""
    if span.correspondence is None:
        for t, offset in zip(range(span.start, span.stop), span.offsets, strict=True):
            moved = np.zeros_like(span.reached)
            height, width = span.shape
            down = min(max(round(offset[0]), -height), height)
            right = min(max(round(offset[1]), -width), width)
            to = slice(max(0, down), height + min(0, down)), slice(max(0, right), width + min(0, right))
            of = slice(max(0, -down), height - max(0, down)), slice(max(0, -right), width - max(0, right))
            moved[to] = span.reached[of]
            yield t, moved
        return
    masks: dict[int, Mask] = {}
    order = [*range(span.anchor, span.start - 1, -1), *range(span.anchor + 1, span.stop)]
    for t, places in zip(order, span.correspondence.course(), strict=True):
        masks[t] = span.reached if places is None else _landed(places, span.reached)
    yield from sorted(masks.items())


def _landed(places: Field, reached: Mask) -> Mask:
    """Pixels that some of the reached ones land on; what magnification leaves open is closed."""
    landed = np.zeros_like(reached)
    row, column = (np.rint(place[reached]).astype(np.intp) for place in places)
    inside = (row >= 0) & (row < reached.shape[0]) & (column >= 0) & (column < reached.shape[1])
    landed[row[inside], column[inside]] = True
    return np.asarray(ndimage.binary_closing(landed, np.ones((3, 3), dtype=bool)) | landed)


def block_sums(values: NDArray[Any]) -> NDArray[np.float64]:
    """Sums of [H, W] values over blocks of BLOCK x BLOCK pixels, in the order of rows."""
    height, width = values.shape
    down, right = -(-height // BLOCK), -(-width // BLOCK)
    padded = np.zeros((down * BLOCK, right * BLOCK))
    padded[:height, :width] = values
    return np.asarray(padded.reshape(down, BLOCK, right, BLOCK).sum(axis=(1, 3)).ravel())


def _mean(values: NDArray[np.float64], inside: Mask) -> float | None:
    count = int(inside.sum())
    return float(values[inside].sum() / count) if count else None
