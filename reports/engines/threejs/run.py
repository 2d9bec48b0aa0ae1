"""A gallery drawn by three.js in a headless Chromium under three builds, and how much each of them flickers.

python run.py -o FOLDER [--size 480x270] [--frames 16]
"""

import argparse
import base64
import shutil
import subprocess
import sys
from contextlib import contextmanager
from pathlib import Path
from typing import Any
from urllib.parse import urlsplit

import numpy as np
from playwright.sync_api import sync_playwright

from swimlab.runs.frames import write_channels

HERE = Path(__file__).parent
ADDRESS = "http://gallery.invalid/"
"""Where the page believes to be: module scripts need an address, and no request leaves this process."""
CHROMIUM = ["--no-sandbox", "--use-angle=swiftshader", "--enable-unsafe-swiftshader"]
"""Drawn by the CPU; a graphics card needs none of the last two."""
BUILDS = ("aliased", "filtered", "supersampled", "reference")


@contextmanager
def open_page() -> Any:
    """The page, with three.js loaded. Ends with an error of the page's own."""
    chromium = shutil.which("chromium")
    if chromium is None:
        sys.exit("run.py: chromium is not installed; on Debian: apt-get install chromium")
    if not (HERE / "node_modules" / "three").is_dir():
        sys.exit(f"run.py: three.js is not installed; run: npm install --prefix {HERE}")
    with sync_playwright() as playwright:
        browser = playwright.chromium.launch(executable_path=chromium, args=CHROMIUM)
        page = browser.new_page()
        page.route(f"{ADDRESS}**", lambda route: route.fulfill(path=HERE / urlsplit(route.request.url).path[1:]))
        page.on("console", lambda said: print(f"page: {said.text}", file=sys.stderr))
        page.on("pageerror", lambda error: print(f"page: {error}", file=sys.stderr))
        page.goto(f"{ADDRESS}page.html")
        page.wait_for_function("window.start")
        yield page
        browser.close()


def render(folder: Path, size: tuple[int, int], frames: int) -> str:
    """Write the frames of every build, the reference, motion and depth, and the shot file; return what drew them."""
    width, height = size
    with open_page() as page:
        version: str = page.evaluate("([width, height]) => start(width, height)", size)

        def pixels(call: str, *words: object) -> np.ndarray:
            """[H, W, 4], the top row first."""
            data = base64.b64decode(page.evaluate(f"(words) => {call}(...words)", words))
            return np.frombuffer(data, np.float32).reshape(height, width, 4)[::-1]

        def write(name: str, frame: int, image: np.ndarray, channels: tuple[str, ...]) -> None:
            write_channels(
                folder / name / f"{frame:04d}.exr", image, channels, half=False, metadata={"Software": version}
            )

        for frame in range(frames):
            for build in BUILDS:
                write(build, frame, pixels("draw", build, frame)[..., :3], ("R", "G", "B"))
            geometry = pixels("drawGeometry", frame)
            write("motion", frame, geometry[..., :2], ("R", "G"))
            write("depth", frame, geometry[..., 2:3], ("Z",))
            print(f"frame {frame + 1} of {frames}", file=sys.stderr)
    shutil.copy(HERE / "shot.toml", folder)
    return version


def measure(folder: Path) -> None:
    """Scores and report of all builds, in FOLDER/run."""
    words = ["study", folder / "shot.toml", "-o", folder / "run"]
    subprocess.run([sys.executable, "-m", "swimlab", *map(str, words)], check=True)


def main(words: list[str] | None = None) -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("-o", "--output", type=Path, required=True, help="folder to write into")
    parser.add_argument("--size", default="480x270", help="width x height, pixels")
    parser.add_argument("--frames", type=int, default=16)
    given = parser.parse_args(words)
    width, height = map(int, given.size.split("x"))
    print(render(given.output, (width, height), given.frames))
    measure(given.output)


if __name__ == "__main__":
    main()
