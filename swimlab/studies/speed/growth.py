"""How a frame's cost grows: with pixels, segments in sight, samples a pixel, threads, and a clip's with frames."""

from collections.abc import Callable, Iterator, Sequence
from contextlib import ExitStack
from dataclasses import dataclass

import numpy as np

from metrics.kernels.launch import Launcher
from sequences import Sequence as Scenery
from swimlab.render.material import Material
from swimlab.render.techniques.tsl import TslSettings, planned_alone
from swimlab.report.charts import Axis, Line, line_chart
from swimlab.studies.page import Cell, Section, Table
from swimlab.studies.panels import Panel, panels
from swimlab.studies.trials import Stage, Variant
from swimlab.studies.turns import Task, Time, clip_task, cpu, frame_task, in_turns, wall

HEIGHTS = (180, 360, 720, 1080, 2160)
LENGTHS = (16.0, 32.0, 64.0, 128.0, 240.0)
SAMPLES = (4, 16, 64, 256)
CLIP = (1, 2, 4, 8, 16)
FEW = 4
"""Samples a pixel of the reference where it grows with something else."""

COMPARED = ("pixel-aniso", "tsl", "reference")
COLOURS = {
    "pixel-aniso": "#4477aa",
    "tsl": "#ee6677",
    "reference": "#222222",
    "supersample": "#66ccee",
    "taa": "#ccbb44",
}


@dataclass(frozen=True)
class Curve:
    """Times of a technique at values of what it grows with, least first; by the clock, or else of all cores."""

    over: str
    technique: str
    x: Sequence[float]
    times: Sequence[Sequence[Time]]
    by_clock: bool = False

    @property
    def ms(self) -> list[float]:
        """Median milliseconds at each x."""
        return [wall(each) if self.by_clock else cpu(each) for each in self.times]

    @property
    def exponent(self) -> float:
        """Of the power of x that fits best over the whole range."""
        return slope(self.x, self.ms)

    @property
    def last_exponent(self) -> float:
        """Of the power between the two largest x."""
        return slope(self.x[-2:], self.ms[-2:])


def slope(x: Sequence[float], y: Sequence[float]) -> float:
    """Of the straight line with the least squares through (log x, log y)."""
    across, up = np.log(x), np.log(y)
    across = across - across.mean()
    return float(across @ (up - up.mean()) / (across @ across))


@dataclass(frozen=True)
class Sight:
    """A road of which `length` is in sight at some size of the picture."""

    sequence: Scenery
    material: Material
    launcher: Launcher

    def stage(self, *, height: int = 0, length: float = 0.0, samples: int = FEW, frames: int = 1) -> Stage:
        """A stage of it; height (px, the shape of the picture kept) and length (m) are the sequence's unless given."""
        changed = self.sequence
        if height:
            changed = changed.with_changes(size=(round(height * changed.size[0] / changed.size[1]), height))
        if length:
            scene = changed.scene.model_dump()
            changed = changed.with_changes(scene=scene | {"road": scene["road"] | {"length": length}})
        return Stage(changed, range(frames), samples=samples, launcher=self.launcher, material=self.material)


def growth_study(sequence: Scenery, launcher: Launcher, material: Material, *, rounds: int) -> list[Curve]:
    """Time every point of every curve in turns."""
    with ExitStack() as stack:
        threads = [count for count in (1, 2, 4, 8, 16, 32, 64) if count <= launcher.threads]
        launchers = {count: stack.enter_context(Launcher(threads=count, device=launcher.device)) for count in threads}
        planned = list(_planned(Sight(sequence, material, launcher), launchers))
        tasks = {f"{place} {k}": task for place, (_, _, points) in enumerate(planned) for k, task in points.items()}
        times = in_turns(tasks, rounds)
    return [
        Curve(over, name, list(points), [times[f"{place} {x}"] for x in points], over == "threads")
        for place, (over, name, points) in enumerate(planned)
    ]


def _planned(sight: Sight, launchers: dict[int, Launcher]) -> Iterator[tuple[str, str, dict[float, Task]]]:
    def curve(
        name: str, values: Sequence[float], stage: Callable[[float], Stage], x: Callable[[Stage], float] | None = None
    ) -> dict[float, Task]:
        stages = {value: stage(value) for value in values}
        return {x(each) if x else value: frame_task(each, Variant(name, name)) for value, each in stages.items()}

    for name in COMPARED:
        yield "pixels", name, curve(name, HEIGHTS, lambda h: sight.stage(height=int(h)), _pixels)
    for name in COMPARED:
        yield "segments", name, curve(name, LENGTHS, lambda length: sight.stage(length=length), _segments)
    yield "samples", "reference", curve("reference", SAMPLES, lambda n: sight.stage(samples=int(n)))
    here = sight.stage()
    brute = [Variant(f"supersample {n}", "supersample", {"samples": n}) for n in (1, *SAMPLES[:-1])]
    yield "samples", "supersample", {each.settings["samples"]: frame_task(here, each) for each in brute}
    for name in COMPARED:
        points = {n: Sight(sight.sequence, sight.material, launcher).stage() for n, launcher in launchers.items()}
        yield "threads", name, {n: frame_task(each, Variant(name, name)) for n, each in points.items()}
    for name in ("pixel-aniso", "taa"):
        clips = {n: sight.stage(frames=n) for n in CLIP}
        yield "frames", name, {n: clip_task(each, Variant(name, name)) for n, each in clips.items()}


def _pixels(stage: Stage) -> float:
    return float(stage.sequence.size[0] * stage.sequence.size[1])


def _segments(stage: Stage) -> float:
    screen, _ = planned_alone(stage.shot(0), TslSettings(size=16))
    return float(len(screen.segments))


TITLES = {
    "pixels": "pixels of the picture",
    "segments": "segments of road in sight",
    "samples": "samples a pixel",
    "threads": "threads",
    "frames": "frames of a clip, all of it timed",
}


def section(curves: Sequence[Curve], *, about: str) -> Section:
    """What the study shows; `about` says how large the picture is where it does not grow."""
    rows: list[list[Cell]] = []
    drawn = []
    for over, title in TITLES.items():
        mine = [curve for curve in curves if curve.over == over and len(curve.x) > 1]
        for curve in mine:
            name = _named(curve)
            ends: list[Cell] = [round(curve.x[0]), round(curve.x[-1]), curve.ms[0], curve.ms[-1]]
            rows.append([title, name, *ends, curve.exponent, curve.last_exponent])
        lines = [Line(_named(curve), curve.x, curve.ms, COLOURS[curve.technique]) for curve in mine]
        what = "ms, by the clock" if over == "threads" else "ms of all cores"
        drawn.append(Panel("", line_chart(lines, x=Axis(title, "log"), y=Axis(what, "log"), title=title)))
    columns = ["grows with", "technique", "from", "to", "ms there", "ms here", "exponent", "at the end"]
    figure = panels(
        "growth.svg",
        "Milliseconds against what they grow with, both axes logarithmic",
        [panel for panel in drawn if panel.svg],
        columns=2,
        key=list(COLOURS.items()),
    )
    return Section(
        "How the cost grows",
        [
            f"{about} The exponent is the slope of log time against log size, by least squares over the range and "
            "between its two largest values: 1 is linear, 0 does not grow, -1 with threads is a perfect share. Times "
            "are medians of what all cores spent, which other programs hardly disturb; against threads, by the clock. "
            f"The reference has {FEW} samples a pixel unless it grows with them; targets of `tsl` are 1024x1024; a "
            "clip of `taa` begins with the frames before it that its history needs.",
            Table("growth", columns, rows),
            figure,
        ],
    )


def _named(curve: Curve) -> str:
    return f"`{curve.technique}`"
