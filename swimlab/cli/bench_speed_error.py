"""`swimlab bench speed-error`."""

from pathlib import Path
from typing import Annotated

from cyclopts import Parameter


def bench_speed_error(
    *,
    output: Annotated[Path, Parameter(name=["--output", "-o"])] = Path("reports"),
    size: str = "640x360",
    frames: int = 8,
    samples: int = 256,
    rounds: int = 15,
    peers: Path | None = None,
    threads: int | None = None,
    json: Annotated[bool, Parameter(negative="")] = False,
    quiet: Annotated[bool, Parameter(name=["--quiet", "-q"], negative="")] = False,
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
        Samples a pixel of the truth, a square number above 64.
    rounds:
        Times that every setting is timed; points of growth a third as often.
    peers:
        JSON of a comparison with other renderers, as reports/peers/run.py writes it, to have a section on it.
    threads:
        Threads to render with (default: every core).
    json:
        Print the numbers of all tables as JSON.
    quiet:
        Show no progress.
    """
    import shlex
    import sys
    from json import dumps

    from swimlab.cli.options import parse_size
    from swimlab.cli.progress import progress
    from swimlab.render.plan import check_samples
    from swimlab.runs.record import RunError
    from swimlab.studies.speed import MOST_SAMPLES
    from swimlab.studies.speed_report import NAME, Effort, steps, write_report

    width, height = parse_size(size)
    if not 2 <= frames <= 32 or rounds < 1 or min(width, height) < 64:
        asked = f"--frames {frames} --rounds {rounds} --size {size}"
        raise RunError(f"{asked}: needs 2 to 32 frames of at least 64x64 px, timed once or more")
    if samples <= MOST_SAMPLES:
        raise RunError(
            f"--samples {samples}: the truth needs more than the {MOST_SAMPLES} that the reference is tried at"
        )
    effort = Effort((width, height), frames, check_samples(samples), rounds, -(-rounds // 3))
    command = shlex.join(["swimlab", *sys.argv[1:]])
    with progress(NAME, steps(), quiet=quiet) as advance:
        found = write_report(output, effort, peers=peers, threads=threads, command=command, advance=advance)
    print(dumps(found, indent=1, allow_nan=False) if json else output / f"{NAME}.md")
    return 0
