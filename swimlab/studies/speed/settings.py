"""Speed against error: every technique at several settings, timed in turns and measured against one reference."""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from statistics import quantiles

import numpy as np

from metrics.kernels.launch import Launcher
from sequences import Sequence as Scenery
from swimlab.render.catalogue import techniques
from swimlab.render.material import Material
from swimlab.report.charts import Axis
from swimlab.report.scatter import Point, scatter
from swimlab.report.weighing import front
from swimlab.runs.record import REFERENCE
from swimlab.studies.beyond.reuse import THRIFTY
from swimlab.studies.page import Cell, Figure, Section, Table, shown
from swimlab.studies.panels import Panel, panels
from swimlab.studies.trials import Stage, Trial, Variant
from swimlab.studies.turns import Time, cpu, frame_task, in_turns, wall

SCORES = ("budget", "visible.flicker")
PANEL = (860, 430)


@dataclass(frozen=True)
class Candidate:
    """A variant, the family that it is one setting of, and for the reference its samples a pixel."""

    family: str
    variant: Variant
    samples: int = 0


def _settings(family: str, technique: str, key: str, values: Sequence[int], **others: str) -> list[Candidate]:
    short = family.removeprefix("pixel-")
    return [Candidate(family, Variant(f"{short} {v}", technique, {key: v, **others})) for v in values]


SEVERAL = (
    *_settings("pixel-aniso", "pixel-aniso", "anisotropy", (1, 2, 4, 8, 16)),
    *_settings("supersample", "supersample", "samples", (1, 4, 9, 16)),
    *_settings("tsl", "tsl", "size", (256, 512, 1024)),
    *_settings("tsl vmf", "tsl", "size", (256, 512, 1024), inputs="vmf"),
    Candidate("tsl thrifty", Variant("tsl visible", "tsl", {"texels": "visible"})),
    Candidate("tsl thrifty", Variant("tsl needed vmf", "tsl", {"texels": "needed", "inputs": "vmf"})),
    Candidate("tsl thrifty", Variant("tsl fitted vmf", "tsl", {"sizes": "fitted", "inputs": "vmf"})),
    *(Candidate("tsl thrifty", Variant(f"tsl kept {n}", "tsl", THRIFTY | {"reuse": n})) for n in (2, 8)),
    *(Candidate(REFERENCE, Variant(f"reference {n}", REFERENCE), n) for n in (4, 16, 64)),
)
"""What is tried at several settings; all other techniques are tried at their defaults."""

MOST_SAMPLES = max(each.samples for each in SEVERAL)
"""What the reference's samples must be more than."""

CHAINS = ("toksvig", "vmf", "clean", "lean")
COLOURS = {
    "pixel-aniso": "#4477aa",
    "supersample": "#66ccee",
    "moment chains": "#228833",
    "tsl": "#ee6677",
    "tsl vmf": "#aa3377",
    "tsl thrifty": "#ccbb44",
    REFERENCE: "#222222",
    "others": "#8a8a8a",
}
JOINED = ("pixel-aniso", "supersample", "tsl", "tsl vmf", REFERENCE)


def candidates() -> list[Candidate]:
    """All that are tried: techniques at several settings, and every other technique once."""
    done = {each.variant.technique for each in SEVERAL}
    single = [name for name in techniques() if name not in done]
    return [
        *(Candidate("moment chains" if name in CHAINS else "others", Variant(name, name)) for name in single),
        *SEVERAL,
    ]


@dataclass(frozen=True)
class Row:
    """A candidate's scores and its times."""

    candidate: Candidate
    trial: Trial
    times: Sequence[Time]

    @property
    def label(self) -> str:
        return self.candidate.variant.label

    @property
    def ms(self) -> float:
        """Median milliseconds of all cores a frame."""
        return cpu(self.times)

    @property
    def error(self) -> float | None:
        """Rms error."""
        return self.trial.rms()

    @property
    def flicker(self) -> float | None:
        """Rms flicker of the error."""
        return self.trial.rms("flicker")

    @property
    def visible(self) -> float | None:
        """Visible flicker, thresholds."""
        return self.trial.measurement.scores.get("visible.flicker")


PARTS: dict[str, Callable[[Row], float | None]] = {
    "error": lambda row: row.error,
    "flicker": lambda row: row.flicker,
    "visible flicker": lambda row: row.visible,
}
"""What time is held against."""


@dataclass(frozen=True)
class Found:
    """All rows, the reference's samples a pixel and own rms error, and pixels that the road covers, a frame."""

    rows: Sequence[Row]
    samples: int
    floor: float | None
    covered: float


def speed_study(
    sequence: Scenery,
    launcher: Launcher,
    material: Material,
    *,
    frames: int,
    samples: int,
    rounds: int,
    advance: Callable[[str], None] = lambda _: None,
) -> Found:
    """Time all candidates in turns and measure them against a reference of `samples` a pixel.

    `advance` is called when that is rendered, when all are timed, and for each candidate that is measured.
    """
    tried = candidates()
    stages = {
        n: Stage(sequence, range(frames), samples=n or samples, launcher=launcher, material=material)
        for n in {each.samples for each in tried}
    }
    stage = stages[0]
    covered = float(np.mean([geometry.coverage.sum() for geometry in stage.geometry]))
    _ = stage.reference
    advance("reference")
    times = in_turns({c.variant.label: frame_task(stages[c.samples], c.variant) for c in tried}, rounds)
    advance("times")
    rows = []
    for each in tried:
        pictures = stages[each.samples].pictures(each.variant)
        trial = stage.measure(each.variant, names=SCORES, pictures=pictures)
        rows.append(Row(each, trial, times[each.variant.label]))
        advance(each.variant.label)
    return Found(rows, samples, rows[0].trial.rms("floor"), covered)


def fronts(rows: Sequence[Row]) -> dict[str, list[bool]]:
    """Which rows lie on the Pareto fronts of time against error, flicker and visible flicker."""
    return {name: front([(row.ms, part(row)) for row in rows]) for name, part in PARTS.items()}


def sections(found: Found, *, about: str) -> list[Section]:
    """The answer in words and as a chart, and the table; `about` says what was rendered."""
    rows = sorted(found.rows, key=lambda row: row.ms)
    held = fronts(rows)
    cells: list[list[Cell]] = []
    for place, row in enumerate(rows):
        clock = wall(row.times)
        low, _, high = quantiles([time.wall for time in row.times], n=4) if len(row.times) > 1 else [clock] * 3
        cost: list[Cell] = [row.ms, 1e6 * row.ms / found.covered, clock, f"{shown(low)}–{shown(high)}"]
        parts = [row.trial.rms(part) for part in ("bias", "detail", "flicker")]
        budget = [row.error, row.trial.standard_error(), *parts, row.visible]
        marks = ", ".join(name for name, on in held.items() if on[place])
        cells.append([f"`{row.label}`", *cost, round(row.trial.shaded), *budget, marks])
    reference: list[Cell] = [f"the reference, {found.samples} samples", *[None] * 5, found.floor, *[None] * 5, ""]
    columns = ["technique and setting", "ms of all cores", "ns a covered pixel", "ms a frame", "quartiles"]
    columns += ["shaded a frame", "error", "±", "bias", "detail", "flicker", "visible flicker", "on the front of"]
    table = Section(
        "All settings",
        [
            f"{about} Fastest first. *Ms of all cores* is what a frame costs, undisturbed by other work of the "
            "machine, and what fronts and charts count; *ms a frame* is what one waits for it, by the clock. Error is "
            "rms of linear radiance over wholly covered pixels, ± its standard error; error² = bias² + detail² + "
            "flicker²: *bias* is a neighbourhood's mean that is off, *detail* a lost or false pattern that sticks to "
            "the road, *flicker* what changes in time while the road does not. *Visible flicker* weighs that by what "
            "the eye sees, in thresholds. *Shaded* counts evaluations of the reflectance model: samples, texels and "
            "vertices together. `tsl kept N` shades the texels that are needed and keeps their light for up to N "
            "frames: here the eye and the sun stand still, which is where that saves most; `bench beyond-the-deck` has "
            "it where they move. On the *front* of something is what nothing as cheap has less of. Neighbours on a "
            "front that differ by less than ± may change places. The last row is the reference's own error, below "
            "which no difference counts.",
            Table("speed against error", columns, [*cells, reference]),
        ],
    )
    return [Section("The answer", [_answer(rows, held), _chart(found)]), table]


def _answer(rows: Sequence[Row], held: Mapping[str, Sequence[bool]]) -> str:
    """What is worth its time, in words; rows are fastest first."""
    lines = []
    for part, on in held.items():
        kept = (row for row, is_on in zip(rows, on, strict=True) if is_on)
        named = ", ".join(f"`{row.label}` ({row.ms:.3g} ms, {PARTS[part](row) or 0.0:.2g})" for row in kept)
        lines.append(f"Nothing is as cheap and has less **{part}** than: {named or 'nothing measured'}.")
    ever = [any(each) for each in zip(*held.values(), strict=True)]
    best = {row.candidate.variant.technique for row, is_on in zip(rows, ever, strict=True) if is_on}
    beaten = sorted({row.candidate.variant.technique for row in rows} - best)
    if beaten:
        lines.append(
            "On none of these fronts at any setting that was tried, for something else is as cheap and better: "
            f"{', '.join(f'`{name}`' for name in beaten)}."
        )
    return "\n".join(f"- {line}" for line in lines)


def _chart(found: Found) -> Figure:
    """Error and flicker against time, one panel each."""

    def panel(title: str, part: Callable[[Row], float | None], label: str, floor: float | None) -> Panel:
        series = []
        for family, colour in COLOURS.items():
            mine = [row for row in found.rows if row.candidate.family == family]
            points = [Point(row.label, row.ms, part(row), colour) for row in mine]
            series += [points] if family in JOINED else [[point] for point in points]
        axes = Axis("ms of all cores a frame", "log"), Axis(label, "log")
        return Panel(title, scatter(series, x=axes[0], y=axes[1], title=title, size=PANEL, floor=floor))

    drawn = [
        panel("Error against time", lambda row: row.error, "rms error", found.floor),
        panel("Flicker against time", lambda row: row.flicker, "rms flicker", None),
    ]
    caption = "Each technique and setting; lower left is better. Filled dots, joined by steps, are the Pareto front: "
    caption += "nothing is as cheap and better. Dotted: the reference's own error."
    return panels("error.svg", caption, drawn, columns=1, key=list(COLOURS.items()), size=PANEL)
