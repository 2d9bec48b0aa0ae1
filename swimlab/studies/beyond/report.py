"""The report on what lies beyond the deck: every study at work, and the page made of them."""

import tempfile
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from metrics.kernels.launch import Launcher
from sequences import load
from swimlab.render.catalogue import brdf_settings, technique_settings
from swimlab.render.plan import Plan
from swimlab.render.run import render_run
from swimlab.runs.provenance import provenance
from swimlab.studies.beyond import moments, reuse, slivers, tsl, vertex
from swimlab.studies.beyond import techniques as comparison
from swimlab.studies.beyond.display import Row, display_study
from swimlab.studies.page import Section, Table, tables, write_page
from swimlab.studies.trials import Stage

NAME = "beyond-the-deck"
SHORT = 8
"""Frames of studies whose answer more frames do not change."""

STEPS = ("techniques", "tsl sizes", "tsl savings", "tsl costs", "kept light", "moments", "vertex", "slivers", "display")
DISPLAYED = ("pixel-point", "pixel-aniso", "vmf", "tsl")


@dataclass(frozen=True)
class Effort:
    """How much is rendered: pixels, frames of the comparison of techniques, the reference's samples, rounds of
    timing."""

    size: tuple[int, int] = (640, 360)
    frames: int = 16
    samples: int = 256
    rounds: int = 9

    @property
    def short(self) -> int:
        """Frames of the other studies."""
        return min(self.frames, SHORT)

    @property
    def half(self) -> tuple[int, int]:
        """Half the size along each side."""
        return max(8, self.size[0] // 2), max(8, self.size[1] // 2)


def write_report(
    folder: Path,
    effort: Effort,
    *,
    threads: int | None = None,
    command: str = "",
    advance: Callable[[str], None] = lambda _: None,
) -> dict[str, Any]:
    """Write FOLDER/beyond-the-deck.md and its pictures; the numbers of its tables with their provenance.

    `advance` is called with the name of each of `STEPS` when it is done.
    """
    with Launcher(threads=threads) as launcher:
        sections = _sections(launcher, effort, advance)
    about = provenance(command)
    opening = (
        "The deck *Implementation of Reflectance Models for Games* ends on two open questions: how to make non-linear "
        "mip chains, and what texture-space lighting costs. Here they are answered by rendering a road under every "
        "technique and measuring each against a supersampled reference.\n\n"
        f"Made by `{command or 'swimlab bench ' + NAME}` on {about['date']}: {about['machine']}, swimlab "
        f"{about['swimlab']}, Warp {about['warp']}, NumPy {about['numpy']}, Python {about['python']}. Pictures are "
        f"{effort.size[0]}x{effort.size[1]} and the reference has {effort.samples} samples a pixel, unless a section "
        f"says otherwise; the comparison of techniques has {effort.frames} frames, other clips have {effort.short}. "
        "Times are medians of frames rendered in turns, on the CPU: their ratios count."
    )
    write_page(folder / f"{NAME}.md", "Beyond the deck", opening, sections)
    return {"provenance": about, "tables": tables(sections)}


def _sections(launcher: Launcher, effort: Effort, advance: Callable[[str], None]) -> list[Section]:
    def stage(name: str, frames: int, size: tuple[int, int] = effort.size) -> Stage:
        sequence = load(name).with_changes(size=size)
        count = sequence.frames if sequence.motion.resizes else min(frames, sequence.frames)
        return Stage(sequence, range(count), samples=effort.samples, launcher=launcher)

    about = f"`road-shift`: the picture slides by (23/32, 19/32) px a frame, {effort.frames} frames."
    compared = comparison.compare(stage("road-shift", effort.frames), rounds=effort.rounds)
    advance("techniques")
    shift = stage("road-shift", effort.short)
    small = stage("road-shift", effort.short // 2, effort.half)
    sizes = {each: tsl.sizes_study(each) for each in (shift, small)}
    advance("tsl sizes")
    savings = {name: tsl.saving(stage(name, 1)) for name in ("road-shift", "road-turn", "road-hills")}
    advance("tsl savings")
    costs = {
        each.sequence.name: tsl.cost_study(each, rounds=effort.rounds // 2, known=sizes.get(each))
        for each in (shift, stage("road-drive", effort.short))
    }
    by_size = {"{}x{}, {} frames".format(*each.sequence.size, len(each.frames)): sizes[each] for each in sizes}
    affordable = tsl.section(by_size, savings, costs, tsl.sheet(shift))
    advance("tsl costs")
    found = {
        name: reuse.reuse_study(stage(name, effort.short), rounds=effort.rounds // 2 + 1) for name in reuse.SEQUENCES
    }
    kept = reuse.section(found)
    advance("kept light")
    wide = moments.section(moments.moment_study(launcher))
    advance("moments")
    corners = vertex.section(vertex.vertex_study(stage("road-scale", 0)))
    advance("vertex")
    thin = slivers.section(slivers.sliver_study(stage("road-sliver", effort.short)))
    advance("slivers")
    shown = _display_section(effort)
    advance("display")
    answer = comparison.answer(compared.rows, also=[*tsl.answers(costs), *reuse.answers(found)])
    return [answer, *comparison.sections(compared, about=about), affordable, kept, wide, corners, thin, shown]


def _display_section(effort: Effort) -> Section:
    """The display study of a small run that is rendered for it."""
    sequence = load("road-shift", technique_settings=technique_settings(), brdfs=brdf_settings())
    small = sequence.with_changes(size=effort.half)
    plan = Plan(small, (*DISPLAYED, "reference"), tuple(range(effort.short)), samples=64)
    with tempfile.TemporaryDirectory() as folder:
        render_run(plan, Path(folder))
        rows = display_study(Path(folder))
    return Section(
        "What the display makes of it",
        [
            f"`road-shift` at {small.size[0]}x{small.size[1]}: the share of flicker in the error (rms of flicker over "
            "rms of error) as radiance and as a display shows it: clamped and encoded as sRGB or by the deck's square "
            "root, with bloom, tone-mapped, and in 8 bits. Errors themselves do not compare across ways. "
            f"{_display_verdict(rows)}",
            _display_table(rows),
        ],
    )


def _display_table(rows: list[Row]) -> Table:
    ways = list(dict.fromkeys(row.settings for row in rows))
    share = {(row.settings, row.technique): row.flicker / row.error for row in rows}
    return Table("display", ["shown as", *DISPLAYED], [[way, *(share[way, n] for n in DISPLAYED)] for way in ways])


def _display_verdict(rows: list[Row]) -> str:
    """What bloom and the square root do, in words."""
    flicker = {(row.settings, row.technique): row.flicker for row in rows}

    def change(way: str, base: str) -> str:
        ratios = [flicker[way, name] / flicker[base, name] for name in DISPLAYED if flicker[base, name] > 0]
        if not ratios:
            return "is not known: there is no flicker"
        return f"multiplies flicker by {min(ratios):.2g} to {max(ratios):.2g}"

    return f"Against plain sRGB, bloom {change('bloom', 'sRGB')}; the square root {change('sqrt', 'sRGB')}."
