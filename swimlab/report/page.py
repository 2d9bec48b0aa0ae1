"""The report page: scores, pictures, charts and provenance in one HTML file that needs no network, or in a folder."""

import json
from collections.abc import Callable, Mapping, Sequence
from importlib import resources
from pathlib import Path
from typing import Any

from jinja2 import Environment, PackageLoader, StrictUndefined, select_autoescape
from markupsafe import Markup

from metrics import METRICS
from swimlab.report.clips import (
    BUDGET,
    DETAIL_SHARE,
    Clip,
    choose_clips,
    detail_of,
    encode,
    is_wide,
    liveliest,
    outwards,
)
from swimlab.report.figures import figures, speed
from swimlab.report.maps import maps
from swimlab.report.motion_map import checked_motion, motion_map
from swimlab.report.palette import Ink, inks
from swimlab.report.profiles import profiles
from swimlab.report.recorded import ReportError, Run, open_run
from swimlab.report.sentences import notes_of
from swimlab.report.table import headline, score_table
from swimlab.report.verdict import verdict
from swimlab.report.viewer import caption, picture_json
from swimlab.report.worst import worst
from swimlab.runs.columns import MARKS
from swimlab.runs.files import clear_leftovers, replacing_folder, write_text
from swimlab.runs.record import REFERENCE
from swimlab.scoring.resolution import LEGEND

CHARTS = 500_000
"""Bytes that the pictures in the charts of a run take."""

SCRIPTS = ("pictures.js", "view.js", "screen.js", "beside.js", "pointer.js", "viewer.js", "charts.js")


def write_report(
    runs: Sequence[Path], scores: Mapping[str, Any], destination: Path, *, picture_budget: int | None = None
) -> None:
    """Write the page of one or more run folders, one sequence each, whole or not at all.

    scores: the content of scores.json. picture_budget: bytes of the viewer's pictures, all runs together; None: what
    leaves room for those of the charts.
    Raises RunError for a folder without run.json, ReportError for scores that hold NaN or infinity, for a sequence
    whose surface is in no pixel and for two runs of one sequence, and FrameError for a missing frame.
    """
    _refuse_nan(scores)
    _refuse_bare(scores)
    opened = _open(runs)
    budget = max(BUDGET // 4, BUDGET - CHARTS * len(opened)) if picture_budget is None else picture_budget
    clips = choose_clips(opened, scores["sequences"], budget)
    clear_leftovers(destination.parent, destination.name)
    write_text(destination, _page(opened, scores, clips))


def write_report_folder(
    runs: Sequence[Path],
    scores: Mapping[str, Any],
    destination: Path,
    *,
    advance: Callable[[str], None] = lambda _: None,
) -> None:
    """Write the page as `destination`/index.html beside all pictures of the runs, whole or not at all.

    advance is called with the sequence of every run that is done. An earlier report folder is replaced. Raises as
    `write_report` does, and ReportError where `destination` is anything else.
    """
    _refuse_nan(scores)
    _refuse_bare(scores)
    refuse_strange_folder(destination)
    opened = _open(runs)
    clear_leftovers(destination.parent, destination.name)
    with replacing_folder(destination) as folder:
        clips = []
        for place, run in enumerate(opened):
            order = outwards(run.frames, liveliest(run, scores["sequences"]))
            wide = is_wide(run, order)
            clips.append(write_pictures(Clip(run, wide=wide, folder=f"{PICTURES}/{place}"), folder))
            clips += detail_of(run, order, int(DETAIL_SHARE * BUDGET) // len(opened), wide=wide)
            advance(run.sequence)
        write_text(folder / PAGE, _page(opened, scores, clips))


def _open(runs: Sequence[Path]) -> list[Run]:
    opened: dict[str, Run] = {}
    for run in map(open_run, runs):
        other = opened.setdefault(run.sequence, run)
        if other is not run:
            raise ReportError(
                f"{run.folder}: holds {run.sequence}, as {other.folder} does; report one of them, or set them side by "
                "side with 'swimlab compare'"
            )
    return list(opened.values())


def _page(opened: Sequence[Run], scores: Mapping[str, Any], clips: Sequence[Clip]) -> str:
    entries = scores["sequences"]
    colours = inks(_techniques(opened, entries))
    told = verdict(
        entries,
        {run.sequence: run.milliseconds for run in opened},
        {run.sequence: run.settings.get("techniques", {}) for run in opened},
    )
    pick = told.picks[0].name if told.picks else ""
    return (
        _environment()
        .get_template("report.html")
        .render(
            names=[run.sequence for run in opened],
            sections=[_section(run, entries, clips, colours) for run in opened],
            inks=colours,
            called=" or ".join(dict.fromkeys(run.pictures.called for run in opened)),
            kept="; ".join(dict.fromkeys(run.pictures.kept for run in opened)),
            verdict=told,
            provenance=flatten({**scores.get("provenance", {}), **_by_run(opened)}),
            settings=[(run.sequence, json.dumps(run.settings, indent=2)) for run in opened],
            metrics=METRICS,
            legend=LEGEND,
            domain=scores.get("provenance", {}).get("domain", "linear"),
            marks=MARKS,
            pictures=Markup(picture_json(clips, entries, pick)),
            theme=Markup(_static("theme.js")),
            css=Markup(_static("report.css") + _static("charts.css")),
            script=Markup("".join(_static(name) for name in SCRIPTS)),
            folder=any(clip.folder for clip in clips),
            compared=any(REFERENCE in run.techniques for run in opened),
            wide=[clip.run.sequence for clip in clips if clip.wide and clip.region is None],
        )
    )


def flatten(tree: Mapping[str, Any], prefix: str = "") -> list[tuple[str, str]]:
    """Nested mappings as (dotted key, text) pairs."""
    pairs = []
    for key, value in tree.items():
        if isinstance(value, Mapping):
            pairs += flatten(value, f"{prefix}{key}.")
        else:
            pairs.append((f"{prefix}{key}", value if isinstance(value, str) else json.dumps(value, default=str)))
    return pairs


def _refuse_bare(scores: Mapping[str, Any]) -> None:
    """Raise ReportError for a sequence of which nothing could be measured, of one size or of several."""
    for entry in scores["sequences"]:
        scales = entry.get("curves", {}).get("scale", {}).get("scale")
        if entry["scores"].get("covered.fraction") == 0 or scales == []:
            raise ReportError(
                f"{entry['sequence']}: the surface covers no pixel wholly in any frame, so there is nothing to measure "
                "or to report; let the camera see more of it, or mend the mask"
            )


def _refuse_nan(scores: Mapping[str, Any]) -> None:
    for entry in scores["sequences"]:
        try:
            json.dumps(entry, allow_nan=False)
        except ValueError as problem:
            place = f"{entry['sequence']}, {entry['technique']}"
            raise ReportError(f"scores: {place}: hold NaN or infinity; measure the run again") from problem


def _section(
    run: Run, entries: Sequence[Mapping[str, Any]], clips: Sequence[Clip], colours: Mapping[str, Ink]
) -> dict[str, Any]:
    mine = [entry for entry in entries if entry["sequence"] == run.sequence]
    names = sorted({name for entry in mine for name in [*entry["scores"], *entry.get("absent", {})]})
    return {
        "name": run.sequence,
        "headline": headline(mine),
        "table": score_table(mine, run.milliseconds),
        "figures": [
            *speed(mine, run.milliseconds, colours),
            *figures(mine, colours),
            *worst(run, mine, clips),
            *profiles(run),
            *motion_map(run, mine),
        ],
        "maps": maps(run, mine),
        "notes": notes_of(mine),
        "motion": checked_motion(mine),
        "score_names": names,
        "entries": mine,
        "clips": [caption(clip) for clip in clips if clip.run is run],
    }


def _techniques(runs: Sequence[Run], entries: Sequence[Mapping[str, Any]]) -> list[str]:
    rendered = (name for run in runs for name in run.techniques)
    return list(dict.fromkeys([*rendered, *(entry["technique"] for entry in entries)]))


def _by_run(runs: Sequence[Run]) -> dict[str, Any]:
    return {run.sequence: run.provenance for run in runs if run.provenance}


def _environment() -> Environment:
    return Environment(
        loader=PackageLoader("swimlab.report"),
        autoescape=select_autoescape(),
        undefined=StrictUndefined,
        trim_blocks=True,
        lstrip_blocks=True,
    )


def _static(name: str) -> str:
    return (resources.files("swimlab.report") / "static" / name).read_text(encoding="utf-8")


PAGE = "index.html"
PICTURES = "pictures"


def write_pictures(clip: Clip, report: Path) -> Clip:
    """Write the whole frames of a clip's run as scripts into its folder of the report."""
    run = clip.run
    (report / clip.folder).mkdir(parents=True)
    for frame in run.frames:
        step = encode(clip, frame)
        for technique in run.techniques:
            name = f"{clip.folder}/{technique}.{frame:04d}.js"
            error = step.errors.get(technique, {}).get(frame)
            handed = ", ".join(json.dumps(part) for part in (name, step.pictures[technique][frame], error))
            (report / name).write_text(f"received({handed});\n", encoding="utf-8")
        clip.merge(Clip(run, sizes=step.sizes, compared=step.compared))
    return clip


def refuse_strange_folder(folder: Path) -> None:
    """Raise ReportError for a path at which there is something other than an earlier report folder."""
    if not folder.exists():
        return
    strange = sorted({path.name for path in folder.iterdir()} - {PAGE, PICTURES}) if folder.is_dir() else ["a file"]
    if strange:
        raise ReportError(f"{folder}: is no report folder ({strange[0]} is there); name another with --output")
