"""The error of every pixel: in the reach of tiles, at edges, and in what has just come into view.

Tiles need a surface that stays in view over a span, off every edge of motion. What they leave out, silhouettes and
thin geometry among it, is measured by pairs of frames (see `pixels`).
"""

from dataclasses import dataclass, field
from typing import Any

import numpy as np
from numpy.typing import NDArray

from metrics.glints import Glints
from metrics.levels import rows_of
from metrics.measurement import Measurement, Metric
from metrics.pixels import BLOCK, CLASSES, Cells, FrameFound, cell_of
from metrics.ratios import Ratios

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


@dataclass
class WholeFrame:
    """Takes in what was found of a clip's frames, in order. shape: [H, W] of the frames, px."""

    shape: tuple[int, int]
    has_reference: bool
    glints: Glints = field(default_factory=Glints)
    _frames: list[dict[str, Any]] = field(default_factory=list)
    _cells: Cells = field(default_factory=dict)

    def take(self, found: FrameFound) -> None:
        """Add what was found of the next frame."""
        for name, values in found.cells.items():
            self._cells[name] = self._cells.get(name, 0.0) + values
        if found.counted is not None:
            self.glints.take(found.counted)
        self._frames.append(found.row)

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
        cell = cell_of(self.shape)
        down, right = (np.diff([*range(0, length, cell), length]) for length in self.shape)
        all_pixels = down[:, None] * right[None, :] * len(self._frames)
        shares = {name: np.rint(100 * self._cells[f"{name} pixels"] / all_pixels).astype(int) for name in CLASSES}
        found: dict[str, list[Any]] = {"cell": [cell]}
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
        side = BLOCK // cell_of(self.shape)
        weights = in_blocks(self._cells.get(weight, np.zeros((1, 1))), side)
        if not weights.sum() > 0:
            found.put(score, None, reason)
            return
        if score.endswith((".fraction", ".floor")):  # of geometry alone, no chance in it
            found.put(score, self._cells[part].sum() / weights.sum(), "", error=0.0)
            return
        ratios = Ratios()
        ratios.add(BLOCK, weights, {part: in_blocks(self._cells[part], side)})
        found.put(score, ratios.value(part), "", error=ratios.error(part) or 0.0, replicates=ratios.replicates(part))


def in_blocks(cells: NDArray[np.float64], side: int) -> NDArray[np.float64]:
    """Sums of cells [rows, columns] over blocks of side x side of them, in the order of rows."""
    down, right = (-(-length // side) * side for length in cells.shape)
    padded = np.zeros((down, right))
    padded[: cells.shape[0], : cells.shape[1]] = cells
    return np.asarray(padded.reshape(down // side, side, right // side, side).sum(axis=(1, 3)).ravel())
