"""Where the squared error goes: bias, detail and flicker, which add up to it exactly.

At every point of the surface mean_t e^2 = (mean_t e)^2 + var_t e. In surface-locked spectra the first term splits
orthogonally at |k| = CUT into the error of a neighbourhood's mean (bias) and lost or false detail; the second is
flicker. Of T frames of pure noise 1/T of the energy stands in the mean: Bessel's correction moves var_t e / (T - 1)
from the static part to flicker, in every octave of |k|, but no more than there is over all tiles. So noise is flicker,
in short clips as in long ones, the parts stay at or above 0, and they still add up to the squared error. An error that
is fixed to the screen is static as far as it does not travel: 2 / (pi K travel) of content even in a disk |k| < K.
The curve `budget.bands` has the static part and flicker by octave of |k|; both together add up to the squared error.
The curve `budget.strip` has the rms error by octave (rows) and frame (columns, as in `frames`), four digits.
"""

from collections import defaultdict
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from metrics.bands import BANDS, describe
from metrics.measurement import Context, Measurement, Metric
from metrics.octaves import OCTAVES, WHITE
from metrics.parts import pieces
from metrics.ratios import Ratios
from metrics.spans import Span
from metrics.spectra import Batch, split
from metrics.tiles import Level
from metrics.transform import Energy

CUT = 1 / 16
"""Cycles/px at which detail begins; an octave begins there too."""

PARTS = {
    "mse": "squared error of the radiance",
    "bias": f"part of mse: static, below {CUT:g} cycles/px: a neighbourhood's mean is off",
    "detail": f"part of mse: static, from {CUT:g} cycles/px on: lost or false detail",
    "flicker": "part of mse: changes in time on the surface: sparkle, swimming, noise (Bessel's correction)",
    "floor": "the reference's own squared error, which no difference can be resolved below",
}
FORMULAS = {
    "mse": "sum w^2 e^2 / sum w^2",
    "bias": f"sum over |k| < {CUT:g} of max(0, |mean_t E|^2 - var_t E / (T - 1)), over sum w^2",
    "detail": f"sum over |k| >= {CUT:g} of max(0, |mean_t E|^2 - var_t E / (T - 1)), over sum w^2",
    "flicker": "mse - bias - detail: var_t E T / (T - 1) over sum w^2, octave by octave no more than there is",
    "floor": "sum w^2 h^2 / sum w^2; h = (A - B) / 2 of the reference's halves A and B",
}
_SOURCE = "bias-variance decomposition over time, by Parseval on surface-locked tile spectra"
_FRAMES = "flicker cannot be distinguished from a static error in fewer than 2 frames"

SCORES = {
    f"budget.{part}": Metric("radiance^2", "information" if part == "floor" else "lower", text, _SOURCE, FORMULAS[part])
    for part, text in PARTS.items()
} | {
    f"budget.{part}.{band}": Metric(
        "radiance^2",
        "information" if part == "floor" else "lower",
        f"{text}; {describe(band)}",
        _SOURCE,
        FORMULAS[part],
    )
    for part, text in PARTS.items()
    for band in BANDS
}


class FrameEnergies(NamedTuple):
    """Of a part's tiles in one frame: squared errors [octaves], weight, and change since the frame before.

    change: NaN in the first frame of a span.
    """

    octaves: Energy
    weight: float
    change: float


class LevelEnergies(NamedTuple):
    """Of the tiles of one size: their weight [n], what is static and what varies [n, octaves], and the floor [n].

    bands: of distance [n]; None without depth.
    """

    size: int
    weight: Energy
    static: Energy
    varied: Energy
    noise: Energy
    bands: NDArray[np.intp] | None


class BudgetFound(NamedTuple):
    """What a part of a span has: by frame, and, with a reference, by level."""

    frames: dict[int, FrameEnergies]
    levels: list[LevelEnergies]


class Budget:
    """Error energies of all tiles, in total, by octave, and by band of distance."""

    def __init__(self, context: Context) -> None:
        self._context = context
        self._ratios: dict[str, Ratios] = defaultdict(Ratios)
        self._frames: dict[int, dict[str, float]] = {}
        self._strip: dict[int, Energy] = {}

    def held(self, level: Level) -> float:
        del level
        return 0.0

    def begin(self, span: Span) -> None:
        self._span = span
        self._energy, self._varied = ([np.zeros((lv.count, len(OCTAVES))) for lv in span.levels] for _ in range(2))
        self._noise, self._weight = ([np.zeros(lv.count) for lv in span.levels] for _ in range(2))
        # Sums over a piece's tiles, frame by frame.
        self._weights = np.zeros((span.count, len(pieces(span))))
        self._octaves, self._changes = np.zeros((2, span.count, len(pieces(span)), len(OCTAVES)))

    def add(self, batch: Batch) -> None:
        row = (batch.frame - self._span.start, batch.piece)
        followed = batch.followed
        self._weights[row] = 3 * batch.weight * len(followed.energy)
        self._changes[row] = followed.change.sum(axis=0) / 2
        if batch.error is None:
            return
        self._octaves[row] = followed.energy.sum(axis=0)
        self._energy[batch.level][batch.tiles] += followed.energy
        self._varied[batch.level][batch.tiles] += followed.varied["error"]
        self._weight[batch.level][batch.tiles] += 3 * batch.weight
        noise = batch.floor_energy
        if noise is not None:
            self._noise[batch.level][batch.tiles] += noise

    def end(self) -> BudgetFound:
        frames: dict[int, FrameEnergies] = {}
        left = np.ones((self._span.count, len(OCTAVES)))
        if self._span.correspondence is not None:
            left = self._span.correspondence.left_in
        for index in range(self._span.count):
            octaves = self._octaves[index].sum(axis=0) / left[index]
            between = (left[index] + left[index - 1]) / 2
            change = np.nan if index == 0 else float((self._changes[index].sum(axis=0) / between).sum())
            frames[self._span.start + index] = FrameEnergies(octaves, float(self._weights[index].sum()), change)
        if not self._context.has_reference:
            return BudgetFound(frames, [])
        levels = []
        for index, level in enumerate(self._span.levels):
            static, varied = split(self._energy[index], self._varied[index], self._span, index)
            if self._span.left is not None:
                self._noise[index] /= self._span.left[index] @ WHITE
            bands = None if self._span.bands is None else self._span.bands[index]
            levels.append(LevelEnergies(level.size, self._weight[index], static, varied, self._noise[index], bands))
        return BudgetFound(frames, levels)

    def take(self, found: BudgetFound) -> None:
        for frame, (octaves, weight, change) in found.frames.items():
            entry = self._frames.setdefault(frame, dict.fromkeys(("weight", "mse", "change"), 0.0))
            self._strip[frame] = self._strip.get(frame, 0.0) + octaves
            entry["weight"] += weight
            entry["mse"] += float(octaves.sum())
            entry["change"] += change
        for level in found.levels:
            self._settle(*level)

    def _settle(
        self, size: int, weight: Energy, static: Energy, varied: Energy, noise: Energy, bands: NDArray[np.intp] | None
    ) -> None:
        """Add up the parts of the tiles of a level."""
        low = np.array(OCTAVES) < CUT
        parts = {
            "mse": static.sum(axis=1) + varied.sum(axis=1),
            "bias": static[:, low].sum(axis=1),
            "detail": static[:, ~low].sum(axis=1),
            "flicker": varied.sum(axis=1),
            "floor": noise,
        }
        octaves = {f"static {i}": static[:, i] for i in range(len(OCTAVES))}
        octaves |= {f"flicker {i}": varied[:, i] for i in range(len(OCTAVES))}
        self._ratios["all"].add(size, weight, parts | octaves)
        if bands is not None:
            for number, band in enumerate(BANDS):
                members = bands == number
                inside = {name: values[members] for name, values in (parts | octaves).items()}
                self._ratios[band].add(size, weight[members], inside)

    def finish(self) -> Measurement:
        found = Measurement(frames=[self._entry(frame) for frame in sorted(self._frames)])
        for group in ("all", *BANDS):
            ratios = self._ratios[group]
            values = _values(ratios) if ratios.weight else {}
            for part in PARTS:
                name = f"budget.{part}" if group == "all" else f"budget.{part}.{group}"
                reason = self._reason(part, group)
                if reason:
                    found.absent[name] = reason
                else:
                    found.put(name, values[part], "", error=ratios.error(part), replicates=ratios.replicates(part))
        if not self._reason("mse", "all"):
            found.curves["budget.strip"] = {"frequency": list(OCTAVES), "error": self._rms_by_octave()}
        if not self._reason("flicker", "all"):
            static, flicker = _octaves(self._ratios["all"])
            found.curves["budget.bands"] = {"frequency": list(OCTAVES), "static": static, "flicker": flicker}
        return found

    def _reason(self, part: str, group: str) -> str:
        """Why a score cannot be measured; empty if it can."""
        if not self._context.has_reference:
            return "needs a reference"
        if part == "floor" and not self._context.has_floor:
            return "needs the reference's half-difference"
        if group != "all" and not self._context.has_depth:
            return "needs depth"
        if self._ratios[group].weight == 0:
            return "no tile stays wholly covered" + ("" if group == "all" else f" {describe(group)}")
        return _FRAMES if part in ("bias", "detail", "flicker") and self._context.count < 2 else ""

    def _rms_by_octave(self) -> list[list[float | None]]:
        """[octaves][frames], None in a frame that has no tile."""
        columns = []
        for frame in sorted(self._frames):
            weight = self._frames[frame]["weight"]
            columns.append([float(f"{np.sqrt(e / weight):.3e}") if weight else None for e in self._strip[frame]])
        return [list(row) for row in zip(*columns, strict=True)]

    def _entry(self, frame: int) -> dict[str, float]:
        sums = self._frames[frame]
        entry: dict[str, float] = {"frame": frame}
        if self._context.has_reference and sums["weight"] > 0:
            entry["mse"] = sums["mse"] / sums["weight"]
        if not np.isnan(sums["change"]) and sums["weight"] > 0:
            entry["change"] = sums["change"] / sums["weight"]
        return entry


def _octaves(ratios: Ratios) -> tuple[list[float], list[float]]:
    """Static part and flicker by octave, both at or above 0, with the sum that they have."""
    pairs = [(ratios.value(f"static {i}"), ratios.value(f"flicker {i}")) for i in range(len(OCTAVES))]
    return [max(0.0, static) for static, _ in pairs], [varied + min(0.0, static) for static, varied in pairs]


def _values(ratios: Ratios) -> dict[str, float]:
    """The parts of the budget."""
    static, flicker = _octaves(ratios)
    low = sum(octave < CUT for octave in OCTAVES)
    parts = {"bias": sum(static[:low]), "detail": sum(static[low:]), "flicker": sum(flicker)}
    return parts | {"mse": sum(parts.values()), "floor": ratios.value("floor")}


MEASURE = Budget
