"""The report on other metrics: errors of one energy and a ladder of samples under each, and which can rank them."""

from collections.abc import Callable, Sequence
from itertools import combinations
from math import inf
from pathlib import Path
from typing import Any

from metrics.kernels.launch import Launcher
from metrics.synthetic import KINDS
from sequences import load
from swimlab.runs.provenance import provenance
from swimlab.studies.other_metrics import clips
from swimlab.studies.other_metrics.clips import Case
from swimlab.studies.other_metrics.judges import OTHERS, OURS, Judge
from swimlab.studies.page import Cell, Section, Table, tables, write_page
from swimlab.studies.trials import Stage, Variant

NAME = "other-metrics"
TOLD = 1.05
"""Two errors are told apart where one counts for so many times the other."""
APART = 0.1
"""Two of the five errors are to be told apart where the shares that flicker differ by so much."""

LADDER = tuple(Variant(f"{n} sample{'s' if n > 1 else ''} a pixel", "supersample", {"samples": n}) for n in (1, 4, 16))
"""Fewer samples are worse in every way."""
OTHER_TECHNIQUES = tuple(Variant(name, name) for name in ("lod-hack", "taa", "tsl"))
REFERENCE_SAMPLES = 256
_MOST = 1000
_ROUNDING = 1e-6

Column = dict[str, float | str]
"""A judge's value by the name of a clip, or why there is none."""


def steps() -> int:
    """How often `advance` is called."""
    return len(KINDS) + 4 + len(LADDER) + len(OTHER_TECHNIQUES)


def write_report(
    folder: Path,
    size: tuple[int, int],
    frames: int,
    *,
    threads: int | None = None,
    command: str = "",
    advance: Callable[[str], None] = lambda _: None,
) -> dict[str, Any]:
    """Write FOLDER/other-metrics.md; the numbers of its tables with their provenance.

    size, frames: of the road. `advance` is called `steps()` times with a word on what is done.
    """
    judges = (*OTHERS, *OURS)
    five, pairs = clips.five_errors(), clips.pairs()
    columns: dict[str, Column] = {judge.name: {} for judge in judges}

    def judge_all(case: Case) -> None:
        for judge in judges:
            columns[judge.name][case.name] = judge.value(case.test, case.reference)
        advance(case.name)

    for case in (*five, *(case for pair in pairs for case in pair)):
        judge_all(case)
    with Launcher(threads=threads) as launcher:
        sequence = load("road-shift").with_changes(size=size)
        stage = Stage(sequence, range(frames), samples=REFERENCE_SAMPLES, launcher=launcher)
        for variant in (*LADDER, *OTHER_TECHNIQUES):
            judge_all(_road(stage, variant))
    sections = [
        _answer(columns, judges, five, pairs),
        _made(columns, judges, five, pairs),
        _roads(columns, judges),
        _ways(columns, judges),
    ]
    about = provenance(command)
    opening = (
        "An error that is glued to its surface is a wrong texture; the same error, moving against the surface or "
        "changing from frame to frame, is flicker, which people notice first. Which metrics tell the two apart?\n\n"
        f"Made by `{command or 'swimlab bench metrics'}` on {about['date']}: {about['machine']}, swimlab "
        f"{about['swimlab']}, NumPy {about['numpy']}, Python {about['python']}."
    )
    write_page(folder / f"{NAME}.md", "Other metrics", opening, sections)
    return {"provenance": about, "tables": tables(sections)}


def _road(stage: Stage, variant: Variant) -> Case:
    pictures = stage.pictures(variant)
    return Case(variant.label, stage.clip(pictures), stage.clip(stage.reference))


def badness(judge: Judge, column: Column, case: str) -> float | None:
    """How bad a judge says a clip is, 0 for the reference and for rounding; None where it has no value."""
    value = column[case]
    if isinstance(value, str):
        return None
    worse = judge.worse(value)
    return worse if worse > _ROUNDING else 0.0


def times(judge: Judge, column: Column, calm: str, wild: str) -> float | None:
    """How many times as bad a judge says one clip is as another; None where it has no value, or calls neither bad."""
    less, more = (badness(judge, column, case) for case in (calm, wild))
    if less is None or more is None or not (less or more):
        return None
    return more / less if less else inf


def in_order(judge: Judge, column: Column, ordered: Sequence[tuple[str, str]]) -> str | None:
    """Of pairs of a better and a worse clip, how many a judge tells apart the right way."""
    found = [(badness(judge, column, better), badness(judge, column, worse)) for better, worse in ordered]
    if any(None in pair for pair in found):
        return None
    right = sum(worse > TOLD * better for better, worse in found if better is not None and worse is not None)
    return f"{right} of {len(ordered)}"


def _answer(
    columns: dict[str, Column], judges: Sequence[Judge], five: Sequence[Case], pairs: Sequence[tuple[Case, Case]]
) -> Section:
    shares = {case.name: case.share or 0.0 for case in five}
    ordered = combinations(sorted(shares, key=lambda name: shares[name]), 2)
    known = [(calm, wild) for calm, wild in ordered if shares[wild] > shares[calm] + APART]
    ladder = list(combinations([variant.label for variant in reversed(LADDER)], 2))
    rows: list[list[Cell]] = []
    blind: list[str] = []
    for judge in judges:
        column = columns[judge.name]
        most = times(judge, column, "glued", "noise")
        ratios = [most, *(times(judge, column, calm.name, wild.name) for calm, wild in pairs)]
        if most is not None and all(ratio is None or ratio < TOLD for ratio in ratios):
            blind.append(judge.name)
        shown = [f"> {_MOST:,}" if ratio is not None and ratio > _MOST else ratio for ratio in ratios]
        rows.append([judge.name, in_order(judge, column, known), *shown, in_order(judge, column, ladder)])
    headings = [
        "metric",
        "five errors in order",
        "noise, times glued",
        "crawling silhouette, times glued",
        "ghost trail, times glued",
        "samples in order",
    ]
    said = f"Blind to all of it, or more pleased by what flickers: {'; '.join(blind)}." if blind else ""
    return Section(
        "The answer",
        [
            "The errors of a column have one energy: what tells them apart is how they change in time. *Five errors*: "
            f"pairs whose shares of flicker, known in closed form, differ by more than {APART:g}; a pair is in order "
            f"where the worse counts for {TOLD:g} times the other. *Times glued*: how many times as bad as an error of "
            "the same energy glued to its surface; 1 is blind to how it moves, and less prefers it; – is neither "
            "found. *Samples*: 1, 4 and 16 a pixel on the road, which differ in energy too: any metric should rank "
            f"these. A metric that did not run has dashes, and a reason at the end. {said}",
            "Metrics that model the eye may well be right that an error which changes 60 times a second is less "
            "visible than one that stands: they say how visible an error is, and not whether it flickers.",
            Table("answer", headings, rows),
        ],
    )


def _made(
    columns: dict[str, Column], judges: Sequence[Judge], five: Sequence[Case], pairs: Sequence[tuple[Case, Case]]
) -> Section:
    cases = [*five, *(case for pair in pairs for case in pair)]
    rows: list[list[Cell]] = [
        [case.name, case.share, *(_cell(columns[judge.name], case.name) for judge in judges)] for case in cases
    ]
    size, count = "{}x{}".format(*clips.SIZE), clips.COUNT
    return Section(
        "Made clips",
        [
            f"{count} frames of {size}. Five errors of one spectrum on a textured surface that moves by (23/32, 19/32) "
            "px a frame; then a disc that moves before a ground which moves otherwise. *Flickers*: the share of the "
            "error's energy in closed form.",
            Table("made clips", ["error", "flickers", *(judge.name for judge in judges)], rows),
        ],
    )


def _roads(columns: dict[str, Column], judges: Sequence[Judge]) -> Section:
    labels = [variant.label for variant in (*LADDER, *OTHER_TECHNIQUES)]
    rows: list[list[Cell]] = [
        [f"`{label}`", *(_cell(columns[judge.name], label) for judge in judges)] for label in labels
    ]
    return Section(
        "The road",
        [
            "`road-shift` under a ladder of samples a pixel, and under techniques that trade detail for calm. Metrics "
            "that look at the test alone call whatever is blurred the best.",
            Table("the road", ["technique", *(judge.name for judge in judges)], rows),
        ],
    )


def _ways(columns: dict[str, Column], judges: Sequence[Judge]) -> Section:
    rows: list[list[Cell]] = []
    for judge in judges:
        absent = next((value for value in columns[judge.name].values() if isinstance(value, str)), "")
        rows.append([judge.name, judge.how, absent or "yes"])
    return Section(
        "How each was run",
        [
            "All but swimlab's own see frames as displayed: clamped to 0..1, sRGB.",
            Table("ways", ["metric", "how", "ran"], rows),
        ],
    )


def _cell(column: Column, case: str) -> Cell:
    value = column[case]
    return None if isinstance(value, str) else value
