"""A gallery rendered by Blender's Cycles under two builds, and how much each of them flickers.

python run.py -o FOLDER [--size 480x270] [--frames 6]
"""

import argparse
import shutil
import subprocess
import sys
from pathlib import Path

HERE = Path(__file__).parent


def render(folder: Path, size: tuple[int, int], frames: int) -> None:
    """Write multi-layer EXRs with colour, depth and vectors, and the shot file."""
    blender = shutil.which("blender")
    if blender is None:
        sys.exit("run.py: blender is not installed; on Debian: apt-get install blender")
    # Without --python-exit-code an error in the script ends Blender with 0.
    options = ["--background", "--factory-startup", "-noaudio", "--python-exit-code", "1"]
    words = ["--python", HERE / "gallery.py", "--", folder.absolute(), *size, frames]
    drawn = subprocess.run([blender, *options, *map(str, words)], capture_output=True, text=True, check=False)
    if drawn.returncode:
        sys.exit(f"run.py: blender ended with {drawn.returncode}:\n{drawn.stdout[-2000:]}{drawn.stderr[-2000:]}")
    shutil.copy(HERE / "shot.toml", folder)


def measure(folder: Path) -> None:
    """Scores and report of all builds, in FOLDER/run."""
    words = ["study", folder / "shot.toml", "-o", folder / "run"]
    subprocess.run([sys.executable, "-m", "swimlab", *map(str, words)], check=True)


def main(words: list[str] | None = None) -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("-o", "--output", type=Path, required=True, help="folder to write into")
    parser.add_argument("--size", default="480x270", help="width x height, pixels")
    parser.add_argument("--frames", type=int, default=6)
    given = parser.parse_args(words)
    width, height = map(int, given.size.split("x"))
    render(given.output, (width, height), given.frames)
    measure(given.output)


if __name__ == "__main__":
    main()
