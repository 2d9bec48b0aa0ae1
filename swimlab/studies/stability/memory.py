"""Memory of large frames: what one picture of a technique takes, measured in a process of its own."""

import json
import subprocess
import sys
import time
from typing import NamedTuple

from metrics.kernels.launch import Launcher
from metrics.machine import free_memory, peak_memory
from sequences import load
from sequences.asphalt import make
from swimlab.render.catalogue import model_of, techniques
from swimlab.render.inputs import Maps
from swimlab.render.material import Material
from swimlab.render.shot import Shot

LARGE = (16384, 2048)
LARGEST = (16384, 16384)
"""Width and height of the frames, px."""
SMALLER = 1024
"""Rows of the frame that a large one is compared with: at that size, what does not grow is there already."""
TECHNIQUES = ("pixel-point", "pixel-aniso", "tsl", "reference")
SAMPLES = 4
SPARE = 3
"""The largest frame is rendered where so many times its memory is free."""


class Memory(NamedTuple):
    """Of a large frame: bytes for a pixel more, peak of the whole process in bytes, seconds."""

    per_pixel: float
    peak: int
    seconds: float


def large_frames(threads: int | None = None) -> dict[tuple[str, int, int], Memory]:
    """By technique, width and height, one after another; the largest by one technique only, if there is memory."""
    cases = [(name, *LARGE) for name in TECHNIQUES]
    found = {case: _measured(case, threads) for case in cases}
    need = found[cases[0]].per_pixel * LARGEST[0] * LARGEST[1]
    if need * SPARE < free_memory():
        largest = (TECHNIQUES[0], *LARGEST)
        found[largest] = _measured(largest, threads)
    return found


def _measured(case: tuple[str, int, int], threads: int | None) -> Memory:
    command = [sys.executable, "-m", __name__, *map(str, case), str(threads or 0)]
    result = subprocess.run(command, capture_output=True, text=True, check=True)
    return Memory(**json.loads(result.stdout))


def render_large(name: str, size: tuple[int, int], threads: int | None) -> Memory:
    """Render frames of SMALLER rows and of the full size, all of road, and compare this process's peaks of memory."""
    technique = techniques()[name]
    settings = technique.settings(**({"size": 256} if name == "tsl" else {}))
    with Launcher(threads=threads) as launcher:
        material = Material(launcher, Maps(*make(0, 64)))

        def render(size: tuple[int, int]) -> None:
            camera = {"pitch": -90.0, "height": 1.0, "fov": 40.0}
            sequence = load("road-shift").with_changes(size=size, camera=camera)
            technique.render(Shot(sequence, 0, material, model_of(sequence), SAMPLES, launcher), settings)

        render((size[0], SMALLER))
        before, started = _peak(), time.perf_counter()
        render(size)
        seconds = time.perf_counter() - started
    return Memory((_peak() - before) / (size[0] * (size[1] - SMALLER)), _peak(), seconds)


def _peak() -> int:
    return peak_memory()


if __name__ == "__main__":
    _, _name, _width, _height, _threads = sys.argv
    print(json.dumps(render_large(_name, (int(_width), int(_height)), int(_threads) or None)._asdict()))
