"""The scores of runs as files: finding, reading and joining them."""

import json
from pathlib import Path
from typing import Any

from swimlab.runs.record import VERSION, RunError


def run_folders(folder: Path) -> list[Path]:
    """The folder itself where it is a run, else the runs in it. Raises RunError where there is none."""
    if (folder / "run.json").is_file():
        return [folder]
    found = sorted(path.parent for path in folder.glob("*/run.json"))
    if not found:
        raise RunError(f"{folder}: holds no run.json, nor does a folder in it; make a run with 'swimlab study'")
    return found


def read_scores(run: Path) -> dict[str, Any]:
    """The content of a run's scores.json. Raises RunError where it is missing or damaged."""
    path = run / "scores.json"
    try:
        scores: dict[str, Any] = json.loads(path.read_text(encoding="utf-8"))
    except FileNotFoundError as error:
        raise RunError(f"{path}: is missing; measure the run first: swimlab measure {run}") from error
    except ValueError as error:
        raise RunError(f"{path}: is not JSON ({error}); measure the run again") from error
    if scores.get("version") != VERSION:
        raise RunError(f"{path}: has version {scores.get('version')!r}, this swimlab reads {VERSION}; measure again")
    return scores


def merge_scores(all_scores: list[dict[str, Any]]) -> dict[str, Any]:
    """One scores.json content over several runs, with the first one's provenance and every run's hash."""
    provenance = dict(all_scores[0]["provenance"])
    provenance.pop("rendering", None)
    provenance["hash"] = ", ".join(scores["provenance"]["hash"] for scores in all_scores)
    entries = [entry for scores in all_scores for entry in scores["sequences"]]
    return {"version": VERSION, "provenance": provenance, "sequences": entries}
