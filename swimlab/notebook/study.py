"""A study: a sequence rendered under some techniques, measured, and at hand to look at."""

import atexit
import shutil
import tempfile
from collections.abc import Sequence
from html import escape
from pathlib import Path
from typing import Any, get_args

import numpy as np

import sequences
from metrics import Clip
from metrics.display import Domain
from swimlab.footage.keys import in_words_of
from swimlab.footage.shot import is_shot, load_shot
from swimlab.notebook.picture import GAP, Codes, Panel, Picture, enlarge, error_colours, scale_bar, sheet
from swimlab.notebook.scores import Scores
from swimlab.render.plan import check_threads, make_plan
from swimlab.render.run import render_run
from swimlab.report.clips import Region, disputed_region
from swimlab.report.display import ERROR_RANGE, srgb
from swimlab.report.page import write_report
from swimlab.report.recorded import open_run as open_recorded
from swimlab.runs.beside import read_current
from swimlab.runs.frames import Image
from swimlab.runs.record import REFERENCE, Record, RunError
from swimlab.runs.scores import run_folders
from swimlab.scoring.brought import measure_brought
from swimlab.scoring.clips import run_clip
from swimlab.scoring.measure import measure_run

SCALE_BAR = 160
"""Least width of the printed scale of errors, px."""
PAGE = 1000
"""Width that panels are set in, px."""


class Study:
    """A measured run folder of one sequence. Frames are read from it when they are asked for.

    folder: the run folder. techniques: their names, the reference last. frames: their numbers.
    """

    def __init__(self, folder: Path) -> None:
        """Raises RunError where the folder holds no run, or none that has been measured since it was rendered."""
        self.folder = folder
        self._record = Record.read(folder)
        self._content = read_current(folder)
        run = open_recorded(folder)
        self._pictures = run.pictures
        self.sequence, self.techniques, self.frames = run.sequence, run.techniques, run.frames

    @property
    def scores(self) -> Scores:
        """The scores of every technique but the reference, as a table."""
        return Scores(self._content["sequences"])

    @property
    def curves(self) -> dict[str, dict[str, dict[str, list[Any]]]]:
        """Technique -> curve -> axis -> values."""
        return {entry["technique"]: dict(entry["curves"]) for entry in self._content["sequences"]}

    @property
    def by_frame(self) -> dict[str, list[dict[str, Any]]]:
        """Technique -> one dictionary a frame, as in frames.csv."""
        return {entry["technique"]: list(entry["frames"]) for entry in self._content["sequences"]}

    @property
    def notes(self) -> list[str]:
        """What a reader should know beside the scores, each once."""
        return list(dict.fromkeys(note for entry in self._content["sequences"] for note in entry["notes"]))

    @property
    def costs(self) -> dict[str, dict[str, float]]:
        """Technique -> ms_per_frame and shaded_per_frame (samples, texels or vertices), medians over `frames`.

        Times are as rendered, one technique after another: good to one digit.
        """
        return {name: dict(cost) for name, cost in self._record.times.items()}

    def frame(self, technique: str = REFERENCE, frame: int | None = None) -> Image:
        """A frame as [H, W, 4] linear premultiplied radiance; None: the first. Raises RunError for one not there."""
        frame = self.frames[0] if frame is None else frame
        for what, wanted, there in (("technique", technique, self.techniques), ("frame", frame, self.frames)):
            if wanted not in there:
                raise RunError(f"{self.folder}: has no {what} {wanted}; it has {', '.join(map(str, there))}")
        return self._pictures.read(technique, frame)

    def clip(self, technique: str = REFERENCE) -> Clip:
        """All frames of a technique with motion, coverage and depth, as `metrics.measure` takes them.

        Raises RunError for a technique that is not there, and for a run whose frames have different sizes.
        """
        self.frame(technique)
        if self._record.resizes:
            raise RunError(f"{self.sequence}: its frames have different sizes, which no clip can have")
        return run_clip(self.folder, self._record, technique)

    def detail(self, size: tuple[int, int] = (48, 32), frame: int | None = None) -> Region:
        """x, y, width and height of the part of a frame, of that size, where the techniques differ most, px."""
        return disputed_region(open_recorded(self.folder), self.frames[0] if frame is None else frame, size)

    def show(
        self,
        technique: str = REFERENCE,
        frame: int | None = None,
        *,
        exposure: float = 0.0,
        zoom: int = 1,
        region: Region | None = None,
    ) -> Picture:
        """A frame, or a region (x, y, width, height, px) of it, in sRGB.

        exposure: stops. zoom: every pixel is drawn as zoom x zoom. Raises RunError as `frame` does.
        """
        return self.compare(
            [technique], None if frame is None else [frame], exposure=exposure, zoom=zoom, region=region
        )

    def compare(
        self,
        techniques: str | Sequence[str] | None = None,
        frames: Sequence[int] | None = None,
        *,
        exposure: float = 0.0,
        zoom: int = 1,
        region: Region | None = None,
    ) -> Picture:
        """Techniques by rows and frames by columns; of one frame, techniques side by side. Options as of `show`."""
        chosen, numbers = listed(techniques or self.techniques), list(frames or self.frames[:1])
        rows = [
            [
                (
                    f"{name}, frame {number}",
                    enlarge(srgb(2.0**exposure * self._cut(name, number, region)[..., :3]), zoom),
                )
                for number in numbers
            ]
            for name in chosen
        ]
        what = f"{', '.join(chosen)} on {self.sequence}, frame {', '.join(map(str, numbers))}"
        alt = what + _part(region) + (f", {exposure:+g} stops" if exposure else "") + _times(zoom)
        return Picture(sheet(rows if len(numbers) > 1 else _wrapped([row[0] for row in rows])), alt)

    def errors(
        self,
        techniques: str | Sequence[str] | None = None,
        frame: int | None = None,
        *,
        zoom: int = 1,
        region: Region | None = None,
    ) -> Picture:
        """Maps of technique - reference in linear radiance, mean of R, G and B, on a fixed scale, which is printed.

        Red is too bright, blue too dark, white right; grey is not measured. Raises RunError as `frame` does.
        """
        number = self.frames[0] if frame is None else frame
        chosen = listed(techniques or [name for name in self.techniques if name != REFERENCE])
        exact = self._cut(REFERENCE, number, region)
        maps = [(name, enlarge(error_colours(self._cut(name, number, region), exact), zoom)) for name in chosen]
        width = max(SCALE_BAR, min(maps[0][1].shape[1], 2 * SCALE_BAR))
        scale = [("error, linear radiance", scale_bar(width))]
        alt = (
            f"error of {', '.join(chosen)} on {self.sequence}, frame {number}{_part(region)}: from "
            f"-{ERROR_RANGE:g} (blue, too dark) to +{ERROR_RANGE:g} (red, too bright) of linear radiance{_times(zoom)}"
        )
        return Picture(_stacked(sheet(_wrapped(maps)), sheet([scale])), alt)

    def report(self, path: str | Path | None = None) -> Path:
        """Write the report, one HTML file that works offline; None: report.html in the run folder."""
        page = self.folder / "report.html" if path is None else Path(path)
        write_report([self.folder], self._content, page)
        return page

    def __repr__(self) -> str:
        return f"{self._title()}\n{self.scores!r}"

    def _repr_html_(self) -> str:
        return f"<p>{escape(self._title())}</p>{self.scores._repr_html_()}"

    def _title(self) -> str:
        width, height = self._record.sequence["size"]
        domain = self._content["provenance"]["domain"]
        count = f"{len(self.frames)} frame{'s' if len(self.frames) > 1 else ''}"
        unit = "rms radiance" if domain == "linear" else "rms of display codes"
        return f"{self.sequence}: {count}, {width}x{height} px, {unit}; in {self.folder}"

    def _cut(self, technique: str, frame: int, region: Region | None) -> Image:
        pixels = self.frame(technique, frame)
        if region is None:
            return pixels
        x, y, width, height = region
        if not (0 <= x < pixels.shape[1] and 0 <= y < pixels.shape[0] and width > 0 and height > 0):
            raise RunError(f"region {region}: lies outside of the frame, {pixels.shape[1]}x{pixels.shape[0]} px")
        return pixels[y : y + height, x : x + width]


def study(
    sequence: str | Path | sequences.Sequence,
    techniques: str | Sequence[str] | None = None,
    *,
    size: tuple[int, int] | None = None,
    frames: str | None = None,
    samples: int = 64,
    output: str | Path | None = None,
    domain: Domain = "linear",
    threads: int | None = None,
    force: bool = False,
) -> Study:
    """Render techniques of a sequence beside the reference, measure them, and return them as a study.

    sequence: a name from the library, a .toml file, or a sequences.Sequence; of a shot file, techniques are builds, and
    what is about rendering has no meaning. techniques: None: all. size: width and
    height in px. frames: as "0-7". samples: of the reference, a pixel, a square number. output: the run folder, which
    is resumed as by `swimlab render`; None: a temporary one, removed when Python ends. threads: None: one a core.
    force: render again, over what the folder holds. Raises SequenceError, RunError or MapError naming what is wrong.
    """
    check_threads(threads)
    if domain not in get_args(Domain):
        raise RunError(f"domain {domain!r}: choose one of {', '.join(get_args(Domain))}")
    if isinstance(sequence, str | Path) and is_shot(sequence):
        return _study_shot(Path(sequence), techniques, output, domain)
    names = None if techniques is None else [*listed(techniques), REFERENCE]
    plan = make_plan(sequence, names, size=size, frames=frames, samples=samples)
    folder = _temporary(plan.sequence.name) if output is None else Path(output)
    render_run(plan, folder, force=force, threads=threads, command="swimlab.study")
    measure_run(folder, domain=domain, command="swimlab.study")
    return Study(folder)


def _study_shot(path: Path, builds: str | Sequence[str] | None, output: str | Path | None, domain: Domain) -> Study:
    shot = load_shot(path)
    requests = shot.requests(path.parent, domain, builds=None if builds is None else listed(builds))
    folder = _temporary(shot.name) if output is None else Path(output)
    with in_words_of(path):
        measure_brought(requests, folder, sequence=shot.name, command="swimlab.study")
    return Study(folder)


def open_run(folder: str | Path) -> Study:
    """The study in a run folder that `swimlab study` or `swimlab render` and `measure` wrote.

    Raises RunError where there is none, where it has not been measured since it was rendered, and where there are
    several in folders of it.
    """
    found = run_folders(Path(folder))
    if len(found) > 1:
        raise RunError(f"{folder}: holds several runs; open one of {', '.join(map(str, found))}")
    return Study(found[0])


def listed(names: str | Sequence[str]) -> list[str]:
    """Names as a list; one alone need not be in a list."""
    return [names] if isinstance(names, str) else list(names)


def _temporary(name: str) -> Path:
    folder = Path(tempfile.mkdtemp(prefix=f"swimlab-{name}-"))
    atexit.register(shutil.rmtree, folder, ignore_errors=True)
    return folder


def _wrapped(panels: list[Panel]) -> list[list[Panel]]:
    """Panels in as few rows as fit a page, about as long as each other."""
    fit = max(1, PAGE // max(codes.shape[1] + GAP for _, codes in panels))
    rows = -(-len(panels) // fit)
    across = -(-len(panels) // rows)
    return [panels[first : first + across] for first in range(0, len(panels), across)]


def _stacked(above: Codes, below: Codes) -> Codes:
    """One picture over another, flush left, on paper."""
    width = max(above.shape[1], below.shape[1])
    return np.concatenate(
        [
            np.pad(each, ((0, 0), (0, width - each.shape[1]), (0, 0)), constant_values=int(above[0, -1, 0]))
            for each in (above, below)
        ]
    )


def _part(region: Region | None) -> str:
    return "" if region is None else " at x {} y {}, {}x{} px".format(*region)


def _times(zoom: int) -> str:
    return f", enlarged {zoom} times" if zoom > 1 else ""
