"""`swimlab bench stability`."""

from pathlib import Path
from typing import Annotated

from cyclopts import Parameter


def bench_stability(
    *,
    output: Annotated[Path, Parameter(name=["--output", "-o"])] = Path("reports"),
    threads: int | None = None,
    json: Annotated[bool, Parameter(negative="")] = False,
    quiet: Annotated[bool, Parameter(name=["--quiet", "-q"], negative="")] = False,
) -> int:
    """Write the report on hard cases: what single precision costs there, and the flicker it makes.

    It is OUTPUT/stability.md.

    Parameters
    ----------
    output:
        Folder to write to.
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

    from swimlab.cli.progress import progress
    from swimlab.studies.stability import CASES, NAME, write_stability_report

    command = shlex.join(["swimlab", *sys.argv[1:]])
    with progress("hard cases", len(CASES), quiet=quiet) as advance:
        found = write_stability_report(output, threads=threads, command=command, advance=advance)
    print(dumps(found, indent=1, allow_nan=False) if json else output / f"{NAME}.md")
    return 0
