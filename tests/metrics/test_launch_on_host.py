"""Kernels on the CPU: loaded once, started on any inputs of the same kinds."""

from concurrent.futures import ThreadPoolExecutor

import numpy as np
import pytest
import warp as wp

from metrics.kernels.host import on_cpu
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


@made_once
def turning():
    @wp.kernel(module="unique", enable_backward=False)
    def kernel(by: wp.array(dtype=wp.mat33d), places: wp.array(dtype=wp.vec3d), out: wp.array(dtype=wp.vec3d)):
        out[wp.tid()] = by[wp.tid()] @ places[wp.tid()]

    return kernel


def test_the_hosts_arrays_have_an_axis_more_for_vectors_and_two_for_matrices(tolerance):
    random, found = np.random.default_rng(0), []
    by, places = random.random((5, 3, 3)), random.random((5, 3))
    for lend in (lambda values, dtype: values, lambda values, dtype: wp.array(values, dtype=dtype, device="cpu")):
        out = np.zeros((5, 3))
        on_cpu(turning(), 5, [lend(by, wp.mat33d), lend(places, wp.vec3d), out])
        found.append(out)
    assert np.array_equal(found[0], found[1])
    assert found[0] == pytest.approx(np.einsum("nij,nj->ni", by, places), rel=tolerance("closed form"))
    for wrong in (random.random((5, 4)), random.random(5), random.random((5, 3)).astype(np.float32)):
        with pytest.raises(TypeError, match="the kernel takes vec3d of 1 dimensions"):
            on_cpu(turning(), 5, [by, wrong, out])


@wp.struct
class Line:
    slope: wp.float32
    values: wp.array(dtype=wp.float32)


@made_once
def gathering():
    @wp.kernel(module="unique", enable_backward=False)
    def kernel(
        first: wp.int32,
        big: wp.uint64,
        wide: wp.float64,
        line: Line,
        direction: wp.vec3,
        turned: wp.bool,
        out: wp.array(dtype=wp.float64),
    ):
        k = first + wp.tid()
        value = wp.float64(line.slope * line.values[k] + direction[2]) + wide + wp.float64(big % wp.uint64(1000))
        out[k] = wp.where(turned, -value, value)

    return kernel


@pytest.mark.parametrize("dtype", [np.float32, np.float64])
def test_the_hosts_arrays_are_no_structures(dtype):
    @wp.kernel(module="unique", enable_backward=False)
    def kernel(lines: wp.array(dtype=Line)):
        lines[wp.tid()].slope = 1.0

    on_cpu(kernel, 3, [wp.zeros(3, dtype=Line)])
    with pytest.raises(TypeError, match="the kernel takes Line"):
        on_cpu(kernel, 3, [np.zeros(12, dtype)])


@pytest.mark.parametrize("number", [int, np.int64, np.int32])
def test_inputs_of_every_kind_arrive_as_they_are(number):
    """After a launch on inputs of other values, and of numpy's numbers as of Python's."""
    for slope, big, turned in ((2.0, 2**63 + 7, False), (3.0, 12, True)):
        line, out = Line(), wp.zeros(4, dtype=wp.float64)
        line.slope, line.values = slope, wp.array(np.arange(4), dtype=wp.float32)
        inputs = [number(1), big, np.float64(0.25), line, wp.vec3(0.0, 0.0, 0.5), turned, out]
        on_cpu(gathering(), 3, inputs)
        expected = slope * np.arange(1, 4) + 0.75 + big % 1000
        assert np.array_equal(out.numpy(), [0, *(-expected if turned else expected)])


def test_a_number_of_another_kind_is_refused():
    line, out = Line(), wp.zeros(4, dtype=wp.float64)
    line.values = wp.zeros(4, dtype=wp.float32)
    inputs = [0, 0, 0.0, line, wp.vec3(), False, out]
    on_cpu(gathering(), 4, inputs)
    for place, wrong in ((0, 1.5), (2, None), (3, wp.vec3()), (4, 1.0), (6, wp.zeros(4, dtype=wp.float32))):
        with pytest.raises(TypeError):
            on_cpu(gathering(), 4, [*inputs[:place], wrong, *inputs[place + 1 :]])


def test_a_first_launch_that_fails_sets_no_kinds():
    @wp.kernel(module="unique", enable_backward=False)
    def double(values: wp.array(dtype=wp.float32), out: wp.array(dtype=wp.float32)):
        out[wp.tid()] = 2.0 * values[wp.tid()]

    out = np.zeros(3, np.float32)
    with pytest.raises(TypeError):
        on_cpu(double, 3, [None, out])
    on_cpu(double, 3, [np.ones(3, np.float32), out])
    assert np.array_equal(out, np.full(3, 2.0))
