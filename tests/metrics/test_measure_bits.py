"""The same bits for any number of threads of the library that multiplies matrices."""

import os
import subprocess
import sys

SOURCE = """
import numpy as np
from metrics import Clip, measure
from metrics.orders import separate
from metrics.ratios import Ratios

random = np.random.default_rng(0)
velocity = (23 / 32, 19 / 32)
noise = random.random((32, 96, 160, 3), dtype=np.float32)
clip = Clip(lambda t: noise[t], len(noise), fps=60.0, motion=velocity)
found = measure(clip, names=["plane"])
ratios = Ratios()
tiles = random.random((2, 30000))
ratios.add(16, tiles[0], {"part": tiles[1]})
gram = separate(velocity).gram(600)
print(found.scores, found.errors, found.curves, ratios.error("part"), gram.tobytes().hex())
"""


def test_products_are_the_same_bits_for_any_number_of_blas_threads() -> None:
    """Where there is one core only, both are one thread."""
    one, two = (
        subprocess.run(
            [sys.executable, "-c", SOURCE],
            env=os.environ | {"OPENBLAS_NUM_THREADS": threads, "OMP_NUM_THREADS": threads, "MKL_NUM_THREADS": threads},
            check=True,
            capture_output=True,
            text=True,
        ).stdout
        for threads in ("1", "2")
    )
    assert "plane.order1" in one
    assert one == two
