"""`swimlab report`."""

from pathlib import Path
from typing import Annotated

from cyclopts import Parameter

from swimlab.cli.terminal import progress
from swimlab.report.page import PAGE, write_report, write_report_folder
from swimlab.runs.beside import read_current
from swimlab.runs.record import Record, RunError
from swimlab.runs.scores import merge_scores, read_scores, run_folders


def report_command(
    *runs: Path,
    output: Annotated[Path | None, Parameter(name=["--output", "-o"])] = None,
    folder: Annotated[bool, Parameter(negative="")] = False,
    quiet: Annotated[bool, Parameter(name=["--quiet", "-q"], negative="")] = False,
) -> int:
    """Write the report of run folders that have been measured.

    Parameters
    ----------
    runs:
        Run folders in the order of the page, or a folder of run folders as 'swimlab study' writes.
    output:
        The page to write (default: report.html in the first folder), or with --folder the folder (default: report).
    folder:
        Write a folder with every frame, to be opened at its index.html, in place of one page with some 20 MB of them.
    quiet:
        Show no progress.
    """
    if not runs:
        raise RunError("report: name at least one run folder")
    folders = [path for run in runs for path in _in_order(run)]
    scores = merge_scores([read_current(path) for path in folders])
    if folder:
        page = (output or runs[0] / "report") / PAGE
        with progress("report", len(folders), quiet=quiet) as advance:
            write_report_folder(folders, scores, page.parent, advance=advance)
    else:
        page = output or runs[0] / "report.html"
        write_report(folders, scores, page)
    print(page)
    return 0


def _in_order(run: Path) -> list[Path]:
    """The folder itself, or the runs in it in the order of its scores.json where it has one; others by name."""
    found = run_folders(run)
    if found == [run] or not (run / "scores.json").is_file():
        return found
    order = list(dict.fromkeys(entry["sequence"] for entry in read_scores(run)["sequences"]))
    names = {path: Record.read(path).sequence["name"] for path in found}
    return sorted(found, key=lambda path: order.index(names[path]) if names[path] in order else len(order))
