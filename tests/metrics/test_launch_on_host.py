"""Kernels on the host's own arrays: recorded once a thread, started on any arrays of the same kinds."""

from concurrent.futures import ThreadPoolExecutor

import numpy as np
import pytest
import warp as wp

from metrics.kernels.launch import on_cpu
from metrics.kernels.making import made_once


@made_once
def scaling():
    @wp.kernel(module="unique", enable_backward=False)
    def kernel(values: wp.array2d(dtype=wp.float32), factor: wp.float32, scaled: wp.array2d(dtype=wp.float32)):
        row = wp.tid()
        for column in range(values.shape[1]):
            scaled[row, column] = factor * values[row, column]

    return kernel


def scale(shape, factor):
    values = np.random.default_rng(shape[0]).random(shape, np.float32)
    scaled = np.zeros_like(values)
    on_cpu(scaling(), len(values), [values, factor, scaled])
    return np.array_equal(scaled, np.float32(factor) * values)


def test_each_start_has_its_own_arrays_and_numbers():
    shapes = [(1 + k % 7, 1 + k % 5) for k in range(60)]
    with ThreadPoolExecutor(4) as pool:
        assert all(pool.map(scale, shapes, [0.5 * k for k in range(60)]))


def test_no_rows_are_no_launch():
    assert scale((0, 3), 2.0)


@pytest.mark.parametrize(
    "values", [np.ones((3, 4)), np.ones((3, 4, 1), np.float32), np.ones((3, 8), np.float32)[:, ::2]]
)
def test_an_array_of_another_kind_is_refused(values):
    assert scale((3, 4), 2.0)
    with pytest.raises(TypeError, match="the kernel takes"):
        on_cpu(scaling(), 3, [values, 2.0, np.zeros((3, 4), np.float32)])
