"""Reports that are kept: a page is written again only where the runs, or the code that makes it, have changed.

A page that was made of scores with keys ends in a key of its own, the hash of all that decides it.
"""

from collections.abc import Mapping, Sequence
from importlib.metadata import version
from pathlib import Path
from typing import Any

from swimlab.report.page import write_report
from swimlab.runs.files import clear_leftovers, replacing
from swimlab.runs.hashes import hash_of
from swimlab.runs.record import Record
from swimlab.scoring.kept import hash_of_code

_ENDING = "<!-- made of {} -->\n"


def key_of_report(runs: Sequence[Path], scores: Mapping[str, Any]) -> str | None:
    """Hash of what a report shows: of scores, whose keys are of the pictures, of records and of code.

    None where an entry has no key. The scores must just have been measured, so that their keys are right.
    """
    if not all("key" in entry for entry in scores["sequences"]):
        return None
    records = [vars(Record.read(run)) for run in runs]
    return hash_of([hash_of_code("report"), version("jinja2"), scores, records])


def is_made_of(page: Path, key: str | None) -> bool:
    """Whether a page is there that was made of the same, by the same code."""
    if key is None or not page.is_file():
        return False
    ending = _ENDING.format(key).encode()
    with page.open("rb") as file:
        file.seek(max(0, page.stat().st_size - len(ending)))
        return file.read() == ending


def write_kept_report(runs: Sequence[Path], scores: Mapping[str, Any], page: Path, key: str | None) -> None:
    """Write a page as `write_report` does, with its key."""
    clear_leftovers(page.parent, page.name)
    with replacing(page) as temporary:
        write_report(runs, scores, temporary)
        if key is not None:
            with temporary.open("a", encoding="utf-8", newline="\n") as file:
                file.write(_ENDING.format(key))
