"""Small run folders and scores to make reports of."""

import json
from pathlib import Path
from typing import Any

import numpy as np

from swimlab.runs.frames import frame_path, write_frame

SIZE = (160, 96)
FRAMES = 6
TECHNIQUES = ("pixel-point", "tsl", "reference")
WORST = 3
REASON = "the motion is not uniform"


def make_run(folder: Path, *, sequence: str = "road-shift", techniques: tuple[str, ...] = TECHNIQUES) -> Path:
    """A run folder of noise; every technique differs most from the others around pixel (110, 60)."""
    random = np.random.default_rng(7)
    for place, name in enumerate(techniques):
        for frame in range(FRAMES):
            rgba = random.uniform(0, 0.2, (SIZE[1], SIZE[0], 4)).astype(np.float32)
            rgba[40:80, 90:130, :3] += 0.3 * place
            rgba[..., 3] = 1
            write_frame(frame_path(folder, name, frame), rgba, half=False, metadata={})
    run = {
        "version": 1,
        "hash": "5e771465",
        "settings": {},
        "uniform_velocity": [0.0, 0.0],
        "resizes": False,
        "sequence": {"name": sequence, "fps": 30, "size": SIZE, "motion": {"kind": "shift"}},
        "techniques": list(techniques),
        "frames": list(range(FRAMES)),
        "provenance": {"hash": "5e771465"},
        "times": {name: {"ms_per_frame": 12.5, "frames": 4} for name in techniques},
    }
    (folder / "run.json").write_text(json.dumps(run), encoding="utf-8")
    return folder


def make_scores(
    *, sequence: str = "road-shift", techniques: tuple[str, ...] = TECHNIQUES, bias: float = 0.01
) -> dict[str, Any]:
    """Scores of every technique but the reference."""
    entries = [
        {
            "sequence": sequence,
            "technique": name,
            "scores": {"budget.mse": bias + 0.03, "budget.bias": bias, "budget.detail": 0.01, "budget.flicker": 0.02},
            "absent": {"plane.on": REASON},
            "frames": [{"frame": t, "mse": 0.04, "change": None if t == 0 else 0.01 * t} for t in range(FRAMES)],
            "curves": {"moire.radial": {"frequency": [0.1, 0.2], "test": [2, 1], "reference": [2, 2], "error": [1, 1]}},
        }
        for name in techniques
        if name != "reference"
    ]
    return {"version": 1, "provenance": {"version": "0.1.0"}, "sequences": entries}
