"""Measure each build that a shot file names: python measure.py FOLDER, which holds shot.toml."""

import sys
import tomllib
from pathlib import Path

import swimlab
from swimlab.runs.files import write_json
from swimlab.runs.frames import FrameError


def measure(folder: Path) -> None:
    """Write FOLDER/scores/BUILD/scores.json for every build, and print it. Raises FrameError."""
    shot = tomllib.loads((folder / "shot.toml").read_text(encoding="utf-8"))
    for build, given in shot["builds"].items():
        measured = swimlab.measure_frames(
            folder / given["frames"],
            reference=folder / shot["reference"]["frames"],
            motion=folder / shot["motion"]["frames"],
            convention=shot["motion"]["convention"],
            fps=shot["fps"],
        )
        write_json(folder / "scores" / build / "scores.json", measured.content)
        print(f"\n{build}\n{measured}")


if __name__ == "__main__":
    try:
        measure(Path(sys.argv[1]))
    except FrameError as error:
        sys.exit(f"measure.py: {error}")
