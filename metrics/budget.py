"""Where the squared error goes: bias, detail and flicker, which add up to it exactly.

At every point of the surface mean_t e^2 = (mean_t e)^2 + var_t e. In surface-locked spectra the first term splits
orthogonally at |k| = CUT into the error of a neighbourhood's mean (bias) and lost or false detail; the second is
flicker, with the population variance. So a constant span of T frames takes 1/T of a pure noise's energy as static.
"""

from collections import defaultdict

import numpy as np

from metrics.bands import BANDS, describe
from metrics.measurement import Context, Measurement, Metric
from metrics.spans import Span
from metrics.spectra import Batch, RunningMean, energy

CUT = 1 / 16
"""Cycles/px at which detail begins."""

PARTS = {
    "mse": "squared error of the radiance",
    "bias": f"part of mse: static, below {CUT:g} cycles/px: a neighbourhood's mean is off",
    "detail": f"part of mse: static, from {CUT:g} cycles/px on: lost or false detail",
    "flicker": "part of mse: changes in time on the surface: sparkle, swimming, noise",
    "floor": "the reference's own squared error, which no difference can be resolved below",
}
_SOURCE = "bias-variance decomposition over time, by Parseval on surface-locked tile spectra"
_FRAMES = "flicker cannot be told from a static error in fewer than 2 frames"

SCORES = {
    f"budget.{part}": Metric("radiance^2", "information" if part == "floor" else "lower", text, _SOURCE)
    for part, text in PARTS.items()
} | {
    f"budget.{part}.{band}": Metric(
        "radiance^2", "information" if part == "floor" else "lower", f"{text}; {describe(band)}", _SOURCE
    )
    for part, text in PARTS.items()
    for band in BANDS
}


class Budget:
    """Error energies of all tiles, in total and by band of distance."""

    def __init__(self, context: Context) -> None:
        self._context = context
        self._totals: dict[str, dict[str, float]] = defaultdict(lambda: defaultdict(float))
        self._frames: list[dict[str, float]] = []

    def begin(self, span: Span) -> None:
        self._span = span
        self._running = RunningMean(span)
        self._last = [np.zeros_like(mean) for mean in self._running.mean]
        self._squared = [np.zeros(level.count) for level in span.levels]
        self._noise = [np.zeros(level.count) for level in span.levels]
        self._weight = [0.0 for _ in span.levels]

    def add(self, batch: Batch) -> None:
        self._frame(batch)
        if batch.error is None or batch.pixel_energy is None:
            return
        self._running.add(batch, batch.error)
        self._squared[batch.level][batch.tiles] += batch.pixel_energy.sum(axis=1)
        if batch.floor_energy is not None:
            self._noise[batch.level][batch.tiles] += batch.floor_energy.sum(axis=1)
        if batch.tiles.start == 0:
            self._weight[batch.level] += 3 * batch.weight

    def _frame(self, batch: Batch) -> None:
        """Sum up the frame's own error and its change since the previous frame."""
        if not self._frames or self._frames[-1]["frame"] != batch.frame:
            self._frames.append({"frame": batch.frame, "weight": 0.0, "mse": 0.0})
        entry = self._frames[-1]
        spectra = batch.test if batch.error is None else batch.error
        last = self._last[batch.level][batch.tiles]
        entry["weight"] += 3 * batch.weight * len(spectra)
        if batch.pixel_energy is not None:
            entry["mse"] += float(batch.pixel_energy.sum())
        if batch.frame > self._span.start:
            entry["change"] = entry.get("change", 0.0) + float(energy(spectra - last).sum()) / 2
        last[...] = spectra

    def end(self) -> None:
        for index, level in enumerate(self._span.levels):
            mean = self._running.mean[index]
            low = level.radius() < CUT
            parts = {
                "mse": self._squared[index],
                "bias": self._span.count * energy(mean * low).sum(axis=1),
                "detail": self._span.count * energy(mean * ~low).sum(axis=1),
                "flicker": self._running.varied[index],
                "floor": self._noise[index],
                "weight": np.full(level.count, self._weight[index]),
            }
            groups = {"all": np.ones(level.count, dtype=bool)}
            bands = self._span.bands
            if bands is not None:
                groups |= {band: bands[index] == number for number, band in enumerate(BANDS)}
            for group, members in groups.items():
                for part, values in parts.items():
                    self._totals[group][part] += float(values[members].sum())

    def finish(self) -> Measurement:
        found = Measurement(frames=[self._entry(frame) for frame in self._frames])
        for group in ("all", *BANDS):
            total = self._totals[group]
            for part in PARTS:
                name = f"budget.{part}" if group == "all" else f"budget.{part}.{group}"
                reason = self._reason(part, group)
                found.put(name, None if reason else total[part] / total["weight"], reason)
        return found

    def _reason(self, part: str, group: str) -> str:
        """Why a score cannot be had; empty if it can."""
        if not self._context.has_reference:
            return "needs a reference"
        if part == "floor" and not self._context.has_floor:
            return "needs the reference's half-difference"
        if group != "all" and not self._context.has_depth:
            return "needs depth"
        if self._totals[group]["weight"] == 0:
            return "no tile stays wholly covered" + ("" if group == "all" else f" {describe(group)}")
        return _FRAMES if part in ("bias", "detail", "flicker") and self._context.count < 2 else ""

    def _entry(self, frame: dict[str, float]) -> dict[str, float]:
        entry: dict[str, float] = {"frame": int(frame["frame"])}
        if self._context.has_reference:
            entry["mse"] = frame["mse"] / frame["weight"]
        if "change" in frame:
            entry["change"] = frame["change"] / frame["weight"]
        return entry


MEASURE = Budget
