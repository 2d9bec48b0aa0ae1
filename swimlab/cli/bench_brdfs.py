"""`swimlab bench brdfs`."""

from pathlib import Path
from typing import Annotated

from cyclopts import Parameter


def bench_brdfs(
    *,
    output: Annotated[Path, Parameter(name=["--output", "-o"])] = Path("reports/brdfs.md"),
    threads: int | None = None,
    json: Annotated[bool, Parameter(negative="")] = False,
    quiet: Annotated[bool, Parameter(name=["--quiet", "-q"], negative="")] = False,
) -> int:
    """Write the report on reflectance models: what each costs and loses, and its error and flicker.

    Parameters
    ----------
    output:
        Markdown file to write.
    threads:
        Threads to render with (default: every core); evaluations are timed on one.
    json:
        Print the numbers of all tables as JSON.
    quiet:
        Show no progress.
    """
    import shlex
    import sys
    from json import dumps

    from swimlab.cli.progress import progress
    from swimlab.studies.brdf_report import STEPS, write_brdf_report

    command = shlex.join(["swimlab", *sys.argv[1:]])
    with progress("brdfs", STEPS, quiet=quiet) as advance:
        found = write_brdf_report(output, threads=threads, command=command, advance=advance)
    print(dumps(found, indent=1, allow_nan=False) if json else output)
    return 0
