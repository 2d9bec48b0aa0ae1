"""Memory that arrays give back: used again, and never while something still refers to it."""

import gc

import numpy as np
import warp as wp

from metrics.kernels.memory import LEAST, MOST, Memory

SHAPE = (64, 64)


def test_memory_is_used_again_after_the_last_reference_is_gone():
    memory = Memory()
    first = memory.array(SHAPE, wp.vec4)
    place, view = first.ptr, first.numpy()
    assert view.nbytes >= LEAST
    view[:] = 3.0
    del first
    gc.collect()
    second = memory.array(SHAPE, wp.vec4)  # the view still needs the first one's
    second.fill_(5.0)
    assert second.ptr != place
    assert (view == 3.0).all()
    del view
    gc.collect()
    assert memory.array(SHAPE, wp.vec4).ptr == place


def test_only_the_same_size_is_used_again():
    memory = Memory()
    place = memory.array(SHAPE, wp.vec4).ptr
    gc.collect()
    assert memory.array((64, 128), wp.vec4).ptr != place
    assert memory.array((64, 256), wp.float32).ptr == place


def test_what_is_kept_is_bounded():
    memory = Memory()
    size = MOST // 4 // 4
    arrays = [memory.array(size, wp.float32) for _ in range(6)]
    del arrays
    gc.collect()
    assert sum(4 * size * len(blocks) for blocks in memory._waiting.values()) == MOST


def test_small_arrays_are_any_others():
    memory = Memory()
    for shape in (0, (0, 0), 7, (3, 5)):
        array = memory.array(shape, wp.float32)
        assert array.numpy().shape == np.empty(shape).shape
    gc.collect()
    assert not memory._waiting
