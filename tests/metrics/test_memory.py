"""Memory of large arrays is used again, and never while somebody still looks at it."""

import numpy as np
import pytest
import warp as wp

from metrics import memory
from metrics.kernels.launch import Launcher
from metrics.memory import let_go, unset


@pytest.fixture(autouse=True)
def nothing_kept(monkeypatch):
    monkeypatch.setattr(memory, "LARGE", 4 * 64**2)
    let_go()
    yield
    let_go()


def place(array):
    return array.ctypes.data


def test_memory_of_an_array_that_went_is_used_again():
    first = unset((3, 64, 64), np.float32)
    where = place(first)
    view = first[1]
    del first
    other = unset((3, 64, 64), np.float32)
    assert place(other) != where  # somebody looks at a part of it
    view[...] = 1
    del view
    assert place(unset((64, 3, 64), np.int32)) == where


@pytest.mark.parametrize("shape", [(0, 64), (3,), (63, 64), (65, 64)])
def test_arrays_of_any_size_are_their_own(shape):
    kept = unset((64, 64), np.float64)
    del kept
    one, other = (unset(shape, np.float64) for _ in range(2))
    one[...], other[...] = 7, 3
    assert one.shape == shape
    assert (one == 7).all()


def test_an_array_of_warp_holds_its_memory_until_it_goes(monkeypatch):
    monkeypatch.setattr("metrics.kernels.launch.LARGE", 4 * 64**2)
    with Launcher(threads=1) as launcher:
        seen = launcher.filled((64, 64), wp.vec2, 2.0).numpy()
        others = [launcher.zeros((64, 64), wp.vec2) for _ in range(3)]
        assert (seen == 2).all()
        assert not any(other.numpy().any() for other in others)
        where = place(seen)
        del seen
        assert launcher.empty((64, 64), wp.vec2).ptr == where
