"""The charts of the page, drawn from the scores, each with a sentence that says what to look for."""

import math
from collections.abc import Mapping, Sequence
from statistics import median
from typing import Any, NamedTuple

from swimlab.report.charts import Axis, Bar, Line, line_chart, number, stacked_bars
from swimlab.report.palette import PARTS, Ink
from swimlab.report.scatter import Point, scatter
from swimlab.runs.record import REFERENCE

Entry = Mapping[str, Any]

SPIKE = 1.5
"""A change is a spike from so many times its median on."""

SCALE_CURVES = {
    "rmse": ("Scale error", "relative rms error", "Against the reference of the same size; 0 is equal to it."),
    "self_rmse": ("Self error", "relative rms error", "Against its own full-size picture, filtered to this size."),
    "mean_drift": (
        "Drift of the mean",
        "change of mean radiance, %",
        "Global brightness should not depend on size.",
    ),
    "highlight": (
        "High-light energy",
        "ratio to the full-size picture",
        "At 1 high lights keep their energy; below they are lost, above they are too bright or too many.",
    ),
}


class Figure(NamedTuple):
    """A chart: its title, its SVG, what to see in it, and its key (label, ink). shapes: of its marks, not dashes."""

    title: str
    svg: str
    sentence: str
    key: Sequence[tuple[str, Ink]]
    shapes: bool = False


def figures(entries: Sequence[Entry], inks: Mapping[str, Ink]) -> list[Figure]:
    """All charts that the score entries of one sequence have the numbers for."""
    drawn = [
        _budget(entries),
        _change(entries, inks),
        _radial(
            entries,
            inks,
            "error",
            "Spectrum of the error",
            "Lower is better; at low frequencies it is wrong brightness or Moiré, at high ones lost or false detail.",
        ),
        _radial(
            entries,
            inks,
            "test",
            "Spectrum of the picture",
            "Above the reference's line there is false detail, below it detail is lost.",
        ),
        _planes(entries),
        *_scales(entries, inks),
    ]
    return [figure for figure in drawn if figure.svg]


def speed(entries: Sequence[Entry], milliseconds: Mapping[str, float], inks: Mapping[str, Ink]) -> list[Figure]:
    """Error against the time of a frame as the run recorded it, of one sequence; none where there is no error."""
    floor = max((entry["scores"].get("budget.floor", 0.0) for entry in entries), default=0.0)
    points = [
        Point(name, milliseconds[name], math.sqrt(max(entry["scores"].get("budget.mse", 0.0), 0.0)), *inks[name])
        for entry in entries
        if (name := entry["technique"]) in milliseconds
    ]
    x, y = Axis("ms a frame", "log"), Axis("rms error", "log")
    svg = scatter([[point] for point in points], x=x, y=y, title="Error against time", floor=math.sqrt(floor))
    sentence = (
        "Lower left is better: filled marks are the Pareto front, where nothing is as fast and closer (dotted: the "
        "reference's own error; times as rendered, one technique after another)."
    )
    key = [(point.name, inks[point.name]) for point in points]
    return [Figure("Error against time", svg, sentence, key, shapes=True)] if svg else []


def _budget(entries: Sequence[Entry]) -> Figure:
    bars = []
    for entry in entries:
        energies = {part: entry["scores"].get(f"budget.{part}") for part in ("bias", "detail", "flicker")}
        total = sum(value or 0 for value in energies.values())
        if None in energies.values() or total <= 0 or entry["technique"] == REFERENCE:
            continue
        rms = math.sqrt(total)
        parts = [
            (
                part,
                rms * value / total,
                PARTS[part],
                f"{math.sqrt(value):.3g} rms, {value / total:.0%} of the energy",
            )
            for part, value in energies.items()
            if value is not None
        ]
        bars.append(Bar(entry["technique"], parts))
    return Figure(
        "Error budget",
        stacked_bars(bars, label="rms error, linear radiance", title="Error budget"),
        "A bar is as long as the rms error, shared out by energy: bias and detail stand still, only flicker moves.",
        [(part, Ink(PARTS[part], "")) for part in ("bias", "detail", "flicker")],
    )


def _change(entries: Sequence[Entry], inks: Mapping[str, Ink]) -> Figure:
    lines = []
    for entry in entries:
        rows = [row for row in entry.get("frames", []) if row.get("change") is not None]
        roots = [math.sqrt(max(row["change"], 0)) for row in rows]
        lines.append(Line(entry["technique"], [row["frame"] for row in rows], roots, *inks[entry["technique"]]))
    what = "the error" if any("mse" in row for entry in entries for row in entry.get("frames", [])) else "the picture"
    return Figure(
        "Flicker over time",
        line_chart(lines, x=Axis("frame"), y=Axis("rms change since last frame", "log"), title="Flicker over time"),
        f"How much {what} on the surface changes from frame to frame: calm stays low, a pop is a spike" + _spike(lines),
        _line_key(lines),
    )


def _spike(lines: Sequence[Line]) -> str:
    """The sentence's end: what changes most above its own habit, if anything does."""
    highest = (0.0, "", 0.0)
    for line in lines:
        known = [(y, x) for x, y in zip(line.x, line.y, strict=True) if y is not None]
        usual = median(y for y, _ in known) if known else 0.0
        if usual > 0 and line.label != REFERENCE:
            top, frame = max(known)
            highest = max(highest, (top / usual, line.label, frame))
    ratio, name, frame = highest
    if ratio < SPIKE:
        return "."
    return f", such as that of {name} at frame {frame:g}, {number(ratio)} times its median."


def _radial(entries: Sequence[Entry], inks: Mapping[str, Ink], which: str, title: str, sentence: str) -> Figure:
    lines = []
    for entry in entries:
        curve = entry.get("curves", {}).get("moire.radial", {})
        if which in curve:
            lines.append(Line(entry["technique"], curve["frequency"], curve[which], *inks[entry["technique"]]))
        if which == "test" and "reference" in curve and all(line.label != REFERENCE for line in lines):
            lines.append(Line(REFERENCE, curve["frequency"], curve["reference"], *inks[REFERENCE]))
    return Figure(
        title,
        line_chart(lines, x=Axis("spatial frequency, cycles/pixel"), y=Axis("power", "log"), title=title),
        sentence,
        _line_key(lines),
    )


def _planes(entries: Sequence[Entry]) -> Figure:
    names = {"on": "on the plane", "order1": "order 1", "order2": "order 2", "off": "off every plane"}
    bars = []
    for entry in entries:
        shares = {name: entry["scores"].get(f"plane.{key}") for key, name in names.items()}
        parts = [(n, max(v, 0), PARTS[n], f"{v:.2%} of the energy") for n, v in shares.items() if v is not None]
        if parts:
            bars.append(Bar(entry["technique"], parts))
    return Figure(
        "Where the energy moves",
        stacked_bars(bars, label="fraction of the spectral energy", title="Where the energy moves"),
        "On the plane, patterns move with the surface; orders 1 and 2 are aliases that swim.",
        [(name, Ink(PARTS[name], "")) for name in names.values()],
    )


def _scales(entries: Sequence[Entry], inks: Mapping[str, Ink]) -> list[Figure]:
    curves = {e["technique"]: e["curves"]["scale"] for e in entries if "scale" in e.get("curves", {})}
    lengths = {name: len(curve["scale"]) for name, curve in curves.items()}
    keys = dict.fromkeys(
        key
        for name, curve in curves.items()
        for key, values in curve.items()
        if key != "scale" and len(values) == lengths[name]
    )
    drawn = []
    for key in keys:
        title, label, sentence = SCALE_CURVES.get(key, (key, key, "Flat curves are independent of size."))
        lines = [Line(name, c["scale"], c[key], *inks[name]) for name, c in curves.items() if key in c]
        svg = line_chart(lines, x=Axis("size of the picture", "octaves"), y=Axis(label), title=title)
        drawn.append(Figure(title, svg, sentence, _line_key(lines)))
    return drawn


def _line_key(lines: Sequence[Line]) -> list[tuple[str, Ink]]:
    return [(line.label, Ink(line.colour, line.dash)) for line in lines if line.x]
