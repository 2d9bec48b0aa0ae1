"""Small score, gate and baseline files for the tests of the gate."""

import json
from pathlib import Path
from typing import Any

HASH = "0123456789abcdef"


def entry(
    sequence: str = "road-shift", technique: str = "tsl", frames: list[dict[str, Any]] | None = None, **scores: Any
) -> dict[str, Any]:
    """An entry of scores.json; `budget_mse=1` is the score budget.mse."""
    return {
        "sequence": sequence,
        "technique": technique,
        "scores": {name.replace("_", ".", 1): value for name, value in scores.items()},
        "absent": {},
        "frames": [{"frame": 0, "mse": 1.0}, {"frame": 1, "mse": 2.0, "change": 3.0}] if frames is None else frames,
        "curves": {},
        "notes": [],
    }


def write_scores(folder: Path, *entries: dict[str, Any], digest: str | None = HASH, domain: str = "linear") -> Path:
    """Write folder/scores.json and return the folder."""
    folder.mkdir(parents=True, exist_ok=True)
    provenance = {"domain": domain} | ({} if digest is None else {"hash": digest})
    content = {"version": 1, "provenance": provenance, "sequences": list(entries)}
    # As a careless writer would, NaN and all.
    (folder / "scores.json").write_text(json.dumps(content), encoding="utf-8")
    return folder


def write_gate(path: Path, *rules: str, baseline: str = "") -> Path:
    """Write a gate file of rules, each the lines of one [[rule]] table; baseline: the lines of its table."""
    table = f"[baseline]\n{baseline}\n" if baseline else ""
    path.write_text("version = 1\n" + table + "".join(f"[[rule]]\n{rule}\n" for rule in rules), encoding="utf-8")
    return path
