"""`swimlab bench beyond-the-deck`."""

from pathlib import Path
from typing import Annotated

from cyclopts import Parameter


def bench_beyond_the_deck(
    *,
    output: Annotated[Path, Parameter(name=["--output", "-o"])] = Path("reports"),
    size: str = "640x360",
    frames: int = 16,
    samples: int = 256,
    threads: int | None = None,
    json: Annotated[bool, Parameter(negative="")] = False,
    quiet: Annotated[bool, Parameter(name=["--quiet", "-q"], negative="")] = False,
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
    from swimlab.studies.beyond import NAME, STEPS, Effort, write_report

    width, height = parse_size(size)
    if not 4 <= frames <= 32 or min(width, height) < 64:
        raise RunError(f"--frames {frames} --size {size}: needs 4 to 32 frames of at least 64x64 px")
    effort = Effort((width, height), frames, check_samples(samples))
    command = shlex.join(["swimlab", *sys.argv[1:]])
    with progress(NAME, len(STEPS), quiet=quiet) as advance:
        found = write_report(output, effort, threads=threads, command=command, advance=advance)
    print(dumps(found, indent=1, allow_nan=False) if json else output / f"{NAME}.md")
    return 0
