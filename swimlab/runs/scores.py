"""The files of scores: finding, reading, joining and writing them."""

import csv
import io
import json
from pathlib import Path
from typing import Any

from swimlab.runs.files import check_writable, clear_leftovers, write_json, write_text
from swimlab.runs.provenance import provenance
from swimlab.runs.record import VERSION, Record, RunError


def run_folders(folder: Path) -> list[Path]:
    """The folder itself where it is a run, else the runs in it. Raises RunError where there is none."""
    if (folder / "run.json").is_file():
        return [folder]
    found = sorted(path.parent for path in folder.glob("*/run.json"))
    if not found:
        raise RunError(f"{folder}: holds no run.json, nor does a folder in it; make a run with 'swimlab study'")
    return found


def scores_path(run: Path) -> Path:
    """The file of scores of a run folder or a study's folder; the file itself where that is given."""
    return run if run.suffix == ".json" else run / "scores.json"


def read_scores(run: Path) -> dict[str, Any]:
    """The content of a scores.json file, or of that of a run's or a study's folder.

    Raises RunError where it is missing, damaged or of another version.
    """
    path = scores_path(run)
    try:
        scores = json.loads(path.read_text(encoding="utf-8-sig"))
    except FileNotFoundError:
        raise RunError(f"{path}: is missing; measure the run first: swimlab measure {path.parent}") from None
    except OSError as error:
        raise RunError(f"{path}: cannot be read ({error.strerror})") from None
    except ValueError as error:
        raise RunError(f"{path}: is not JSON ({error}); measure the run again") from None
    version = scores.get("version") if isinstance(scores, dict) else None
    if version != VERSION:
        raise RunError(f"{path}: has version {version!r}, this swimlab reads {VERSION}; measure again")
    return dict(scores)


def merge_scores(all_scores: list[dict[str, Any]]) -> dict[str, Any]:
    """One scores.json content over several runs, with the first one's provenance and every run's hash."""
    provenance = dict(all_scores[0]["provenance"])
    provenance.pop("rendering", None)
    provenance.pop("settings", None)
    provenance["hash"] = ", ".join(scores["provenance"]["hash"] for scores in all_scores)
    entries = [entry for scores in all_scores for entry in _with_settings(scores)]
    return {"version": VERSION, "provenance": provenance, "sequences": entries}


def _with_settings(scores: dict[str, Any]) -> list[dict[str, Any]]:
    """The entries of a file of scores, with the settings of brought frames, which are not those of other runs."""
    about = scores["provenance"]
    own = {key: about[key] for key in ("hash", "settings")} if "settings" in about else {}
    return [own | entry for entry in scores["sequences"]]


def write_scores(
    run: Path, record: Record, entries: list[dict[str, Any]], *, domain: str, command: str = ""
) -> dict[str, Any]:
    """Write scores.json and frames.csv into a run's folder; return the content of the former.

    Each entry says when the pictures were rendered that it is of.
    """
    scores = {
        "version": VERSION,
        "provenance": {**provenance(command), "domain": domain, "hash": record.hash, "rendering": record.provenance},
        "sequences": [{**entry, "rendered": record.rendered.get(entry["technique"])} for entry in entries],
    }
    write_content(run, scores)
    return scores


def write_brought(run: Path, record: Record, scores: dict[str, Any]) -> None:
    """Write the run folder of brought frames, of which there was nothing before they were measured."""
    (run / "scores.json").unlink(missing_ok=True)  # of other frames, if this is interrupted
    record.write(run)
    write_content(run, scores)


def refuse_other(run: Path, sequence: str) -> None:
    """Raise RunError where a folder holds a rendered run, one of another shot, or the scores of several runs."""
    refuse_rendered(run)
    held = ""
    if (run / "run.json").is_file():
        name = Record.read(run).sequence.get("name")
        held = "" if name == sequence else f"the run of {name}"
    elif (run / "scores.json").is_file():
        held = "the scores of several runs"
    if held:
        raise RunError(f"{run}: holds {held}; choose another folder with -o, or remove it")


def refuse_rendered(run: Path) -> None:
    """Raise RunError where frames cannot be measured into a folder: it is a file, or holds a rendered run."""
    _refuse_file(run)
    if (run / "run.json").is_file() and not Record.read(run).inputs:
        raise RunError(f"--output {run}: holds a rendered run; name another folder")


def check_output(output: Path) -> None:
    """Raise RunError where a folder, or a file of scores, cannot be written; nothing is left of the attempt."""
    folder = output.parent if scores_path(output) == output else output
    if folder == output:
        _refuse_file(output)
    elif output.is_dir():
        raise RunError(f"--output {output}: is a folder, though it ends in .json; name it otherwise")
    try:
        check_writable(folder)
    except OSError as error:
        raise RunError(f"--output {output}: cannot be written: {error.strerror}; name another place with -o") from error


def _refuse_file(run: Path) -> None:
    if run.is_file():
        raise RunError(f"--output {run}: is a file; name a folder, or a file that ends in .json")


def write_content(run: Path, scores: dict[str, Any]) -> None:
    """Write scores.json and frames.csv into a run's folder."""
    clear_leftovers(run)
    write_json(run / "scores.json", scores)
    write_text(run / "frames.csv", frames_table(scores["sequences"]))


def frames_table(entries: list[dict[str, Any]]) -> str:
    """The per-frame values of all entries as CSV: sequence, technique, frame and one column a value."""
    values = [key for entry in entries for row in entry["frames"] for key in row]
    columns = list(dict.fromkeys(["sequence", "technique", "frame", *values]))
    text = io.StringIO()
    table = csv.DictWriter(text, columns, lineterminator="\n")
    table.writeheader()
    for entry in entries:
        for row in entry["frames"]:
            table.writerow({"sequence": entry["sequence"], "technique": entry["technique"], **row})
    return text.getvalue()
