"""Measure each build that a shot file names: python measure.py FOLDER, which holds shot.toml."""

import subprocess
import sys
import tomllib
from pathlib import Path


def measure(folder: Path) -> None:
    """Write FOLDER/scores/BUILD for every build. Raises CalledProcessError where one cannot be measured."""
    shot = tomllib.loads((folder / "shot.toml").read_text(encoding="utf-8"))
    for build, given in shot["builds"].items():
        words = [
            *("--test", folder / given["frames"], "--reference", folder / shot["reference"]["frames"]),
            *("--motion", folder / shot["motion"]["frames"], "--motion-convention", shot["motion"]["convention"]),
            *("--fps", shot["fps"], "-o", folder / "scores" / build),
        ]
        subprocess.run([sys.executable, "-m", "swimlab", "measure", *map(str, words)], check=True)


if __name__ == "__main__":
    measure(Path(sys.argv[1]))
