"""`swimlab bench`: what techniques, reflectance models and measures cost, and how far they can be trusted."""

import json
import shlex
import sys
from collections.abc import Callable
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from typing import Annotated, Any

from cyclopts import App, Parameter

bench_command = App(name="bench", help="Time techniques and measures, and compare their cost with their error.")
Folder = Annotated[Path, Parameter(name=["--output", "-o"])]


@Parameter(name="*")
@dataclass(frozen=True, kw_only=True)
class Running:
    """How a study runs.

    Parameters
    ----------
    threads:
        Threads to work with (default: every core).
    json_output:
        Print the numbers of all tables as JSON.
    quiet:
        Show no progress.
    """

    threads: int | None = None
    json_output: Annotated[bool, Parameter(name="--json", negative="")] = False
    quiet: Annotated[bool, Parameter(name=["--quiet", "-q"], negative="")] = False

    def write(self, title: str, steps: int, path: Path, write: Callable[..., Any]) -> int:
        """Write a report by `write(threads=, command=, advance=)`; print its numbers or where it is."""
        from swimlab.cli.terminal import progress  # rich is heavy

        command = shlex.join(["swimlab", *sys.argv[1:]])
        with progress(title, steps, quiet=self.quiet) as advance:
            found = write(threads=self.threads, command=command, advance=advance)
        print(json.dumps(found, indent=1, allow_nan=False) if self.json_output else path)
        return 0


_STANDARD = Running()


# Studies render and measure, so their modules are heavy: each is imported by its own command.


@bench_command.command(name="brdfs")
def bench_brdfs(*, output: Folder = Path("reports/brdfs.md"), running: Running = _STANDARD) -> int:
    """Write the report on reflectance models: what each costs and loses, and its error and flicker.

    Evaluations are timed on one thread.

    Parameters
    ----------
    output:
        Markdown file to write.
    """
    from swimlab.studies.brdfs.report import STEPS, write_brdf_report

    return running.write("brdfs", STEPS, output, partial(write_brdf_report, output))


@bench_command.command(name="costs")
def bench_costs(
    sequence: str = "road-shift",
    *,
    size: str = "640x360",
    rounds: int = 15,
    device: str = "cpu",
    running: Running = _STANDARD,
) -> int:
    """Time every technique and setting in turns: in kernels, beside them, and the least that the work could cost.

    A frame is timed that follows one of the same technique, as where a sequence is rendered. Then rendering and
    measuring on one thread and on two, for the share of them that is serial, and what of it is the program's.

    Parameters
    ----------
    sequence:
        Sequence to render.
    size:
        Size of the pictures in pixels, WIDTHxHEIGHT; the serial share is of 1280x720 and, measuring, 1920x1080.
    rounds:
        Times that every setting is timed.
    device:
        Device to render techniques on, as Warp names it.
    """
    from swimlab.cli.costs_table import print_costs
    from swimlab.cli.terminal import progress
    from swimlab.render.plan import load_sequence
    from swimlab.studies.costs.study import STEPS, cost_study

    _check_rounds(rounds)
    sized = load_sequence(sequence).with_changes(size=_clip(1, size, range(1, 2)))
    with progress("costs", STEPS, quiet=running.quiet) as advance:
        costs = cost_study(sized, rounds=rounds, threads=running.threads, device=device, advance=advance)
    if running.json_output:
        print(json.dumps(costs.as_json(shlex.join(["swimlab", *sys.argv[1:]])), indent=1, allow_nan=False))
    else:
        print_costs(costs)
    return 0


@bench_command.command(name="measures")
def bench_measures(*, size: str = "1920x1080", frames: int = 16, rounds: int = 3, running: Running = _STANDARD) -> int:
    """Time the measures, in frames a second: frames in memory, and read from files that it writes.

    Parameters
    ----------
    size:
        Size of the frames in pixels, WIDTHxHEIGHT.
    frames:
        Frames of the clip.
    rounds:
        Times that everything is timed, in turns; medians are printed.
    """
    from swimlab.cli.measures_table import print_timings
    from swimlab.cli.terminal import progress
    from swimlab.studies.bench import NAMES, time_measures

    _check_rounds(rounds)
    width, height = _clip(frames, size, range(2, sys.maxsize))
    with progress("timing measures", rounds * len(NAMES), quiet=running.quiet) as advance:
        timings = time_measures(width, height, frames, rounds=rounds, threads=running.threads, advance=advance)
    if running.json_output:
        clip = {"size": [width, height], "frames": frames, "rounds": rounds}
        print(json.dumps(clip | {"rows": [vars(row) for row in timings]}, indent=1))
    else:
        print_timings(timings, f"{frames} frames of {size}, medians of {rounds} rounds")
    return 0


@bench_command.command(name="stability")
def bench_stability(*, output: Folder = Path("reports"), running: Running = _STANDARD) -> int:
    """Write the report on hard cases: what single precision costs there, and the flicker it makes.

    It is OUTPUT/stability.md.

    Parameters
    ----------
    output:
        Folder to write to.
    """
    from swimlab.studies.stability.report import CASES, NAME, write_stability_report

    return running.write("hard cases", len(CASES), output / f"{NAME}.md", partial(write_stability_report, output))


@bench_command.command(name="beyond-the-deck")
def bench_beyond_the_deck(
    *,
    output: Folder = Path("reports"),
    size: str = "640x360",
    frames: int = 16,
    samples: int = 256,
    running: Running = _STANDARD,
) -> int:
    """Write the report on what lies beyond the deck: which technique at which cost.

    It is OUTPUT/beyond-the-deck.md, with pictures in a folder of the same name beside it.

    Parameters
    ----------
    output:
        Folder to write to.
    size:
        Size of the pictures in pixels, WIDTHxHEIGHT.
    frames:
        Frames of the comparison of techniques; other studies take up to 8.
    samples:
        Samples a pixel of the reference, a square number.
    """
    from swimlab.render.plan import check_samples
    from swimlab.studies.beyond.report import NAME, STEPS, Effort, write_report

    effort = Effort(_clip(frames, size, range(4, 33)), frames, check_samples(samples))
    return running.write(NAME, len(STEPS), output / f"{NAME}.md", partial(write_report, output, effort))


@bench_command.command(name="speed-error")
def bench_speed_error(
    *,
    output: Folder = Path("reports"),
    size: str = "640x360",
    frames: int = 8,
    samples: int = 256,
    rounds: int = 15,
    peers: Path | None = None,
    running: Running = _STANDARD,
) -> int:
    """Write the report on speed against error: every technique at several settings, and how cost grows.

    It is OUTPUT/speed-against-error.md, with charts in a folder of the same name beside it.

    Parameters
    ----------
    output:
        Folder to write to.
    size:
        Size of the pictures in pixels, WIDTHxHEIGHT.
    frames:
        Frames that errors are measured over.
    samples:
        Samples a pixel of the reference that errors are measured against, a square number above 64.
    rounds:
        Times that every setting is timed; points of growth a third as often.
    peers:
        JSON of a comparison with other renderers, as reports/peers/run.py writes it, to have a section on it.
    """
    from swimlab.render.plan import check_samples
    from swimlab.runs.record import RunError
    from swimlab.studies.speed.report import NAME, Effort, steps, write_report
    from swimlab.studies.speed.settings import MOST_SAMPLES

    pixels = _clip(frames, size, range(2, 33))
    _check_rounds(rounds)
    if samples <= MOST_SAMPLES:
        raise RunError(f"--samples {samples}: must be above {MOST_SAMPLES}, the most that techniques are tried at")
    effort = Effort(pixels, frames, check_samples(samples), rounds, -(-rounds // 3))
    return running.write(NAME, steps(), output / f"{NAME}.md", partial(write_report, output, effort, peers=peers))


@bench_command.command(name="metrics")
def bench_metrics(
    *, output: Folder = Path("reports"), size: str = "256x144", frames: int = 8, running: Running = _STANDARD
) -> int:
    """Write the report on other metrics: which of them tell an error that flickers from one that does not.

    It is OUTPUT/other-metrics.md. Metrics of extras that are not installed are left out, which the report says.

    Parameters
    ----------
    output:
        Folder to write to.
    size:
        Size of the road's pictures in pixels, WIDTHxHEIGHT.
    frames:
        Frames of the road.
    """
    from swimlab.studies.other_metrics.report import NAME, steps, write_report

    pixels = _clip(frames, size, range(4, 33))
    return running.write(NAME, steps(), output / f"{NAME}.md", partial(write_report, output, pixels, frames))


def _check_rounds(rounds: int) -> None:
    from swimlab.runs.record import RunError

    if rounds < 1:
        raise RunError(f"--rounds {rounds}: must be at least 1")


def _clip(frames: int, size: str, allowed: range) -> tuple[int, int]:
    """Width and height of a clip's frames. Raises RunError for a size below 64 px and too few or too many frames."""
    from swimlab.cli.options import parse_size
    from swimlab.runs.record import RunError

    width, height = parse_size(size)
    if frames not in allowed or min(width, height) < 64:
        most = "" if allowed.stop == sys.maxsize else f" to {allowed.stop - 1}"
        raise RunError(f"--frames {frames} --size {size}: needs {allowed.start}{most} frames of at least 64x64 px")
    return width, height
