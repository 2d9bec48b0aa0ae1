"""Launches that are laid out again: as if each were laid out for the first time, and nothing is held for it."""

import random
import weakref
from concurrent.futures import ThreadPoolExecutor
from itertools import product

import numpy as np
import pytest
import warp as wp
from hypothesis import given, settings
from hypothesis import strategies as st

from metrics.kernels import spares
from metrics.kernels.launch import Launcher, Scratch
from metrics.kernels.spares import MOST_OF_ONE, Spare, Spares


@wp.struct
class Pair:
    """Two things that a kernel adds."""

    number: wp.int32
    values: wp.array(dtype=wp.int32)


@wp.kernel(enable_backward=False)
def add(first: wp.int32, number: wp.int32, values: wp.array(dtype=wp.int32), pair: Pair, out: wp.array(dtype=wp.int32)):
    k = first + wp.tid()
    out[k] += number + values[k] + pair.number + pair.values[k]


@wp.kernel(enable_backward=False)
def add_all(number: wp.int32, values: wp.array(dtype=wp.int32), pair: Pair, out: wp.array(dtype=wp.int32)):
    for k in range(out.shape[0]):
        out[k] += number + values[k] + pair.number + pair.values[k]


@wp.kernel(enable_backward=False)
def add_with_scratch(
    first: wp.int32, values: wp.array(dtype=wp.int32), out: wp.array(dtype=wp.int32), own: wp.array2d(dtype=wp.int32)
):
    k = first + wp.tid()
    own[0, 0] = values[k]
    out[k] += own[0, 0]


@pytest.fixture(scope="module", params=[1, 3])
def launcher(request):
    with Launcher(threads=request.param) as made:
        yield made


def run(launcher, over, inputs, rows):
    if over:
        launcher.over(rows, add, (), inputs)
    else:
        launcher.on_host(add_all, inputs)()


@settings(derandomize=True, max_examples=25)
@given(
    rows=st.integers(1, 40),
    over=st.booleans(),
    steps=st.lists(st.tuples(*[st.booleans()] * 5, st.integers(0, 99)), min_size=2, max_size=12),
)
def test_only_what_changes_is_set_anew_and_all_of_it(launcher, rows, over, steps):
    """Numbers, arrays of the host and of Warp, structures, and what is in structures that stay the same."""
    values, inner, out = (np.arange(rows, dtype=np.int32) for _ in range(3))
    pair, given_values = Pair(), values
    for new_values, of_warp, new_pair, new_inner, new_out, number in steps:
        if new_values:
            values = values + number
            given_values = wp.array(values, dtype=wp.int32, device="cpu") if of_warp else values
        if new_pair:
            pair = Pair()
        if new_inner:
            inner = inner + 2 * number
        if new_out:
            out = np.zeros(rows, np.int32)
        pair.number, pair.values = number, wp.array(inner, dtype=wp.int32, device="cpu")
        wanted = out + number + values + number + inner
        run(launcher, over, [number, given_values, pair, out], rows)
        assert np.array_equal(out, wanted)


@pytest.mark.parametrize("over", [False, True])
def test_arrays_are_held_while_it_runs_and_no_longer(launcher, over):
    """Another one in the place of one that has gone is not taken for it."""
    pair = Pair()
    pair.values = wp.zeros(100, dtype=wp.int32, device="cpu")
    for number in range(50):
        values, out = np.full(100, number, np.int32), wp.zeros(100, dtype=wp.int32, device="cpu")
        laid = launcher.laid_out(100, add, (), [0, values, pair, out]) if over else None
        gone = weakref.ref(values)
        if laid is None:
            run(launcher, over, [0, values, pair, out], 100)
            del values
        else:
            del values
            assert gone() is not None
            laid()
        assert gone() is None
        assert (out.numpy() == number).all()


def test_who_is_laid_out_before_another_has_run_has_inputs_of_its_own(launcher):
    """Also as threads that launch the same at the same time."""
    pair = Pair()
    pair.values = wp.zeros(64, dtype=wp.int32, device="cpu")
    one = wp.ones(64, dtype=wp.int32, device="cpu")

    def rounds(number):
        for _ in range(30):
            outs = [np.zeros(64, np.int32) for _ in range(3)]
            for k, each in enumerate([launcher.laid_out(64, add, (), [number, one, pair, out]) for out in outs]):
                assert (outs[k] == 0).all()
                each()
                assert (outs[k] == number + 1).all()
        return True

    with ThreadPoolExecutor(4) as threads:
        assert all(threads.map(rounds, range(8)))


def test_scratch_stays_each_threads_own(launcher):
    for rows in (50, 50, 70, 50, 50):
        values, out = np.arange(rows, dtype=np.int32), np.zeros(rows, np.int32)
        launcher.over(rows, add_with_scratch, (), [values, out], own=Scratch(1, wp.int32))
        assert np.array_equal(out, values)


@wp.kernel(enable_backward=False)
def touch(first: wp.int32, each: wp.int32, times: wp.array2d(dtype=wp.int32)):
    row, column = wp.tid()
    for k in range(each):
        if first + each * row + k < times.shape[0]:
            times[first + each * row + k, column] += 1


def test_a_kernel_may_be_cut_in_another_way_each_time(launcher):
    """Over as many rows, of another width, or in other strips: each way after each other one."""
    cuts = list(product((1, 2, 3), (1, 3), (1, 4, 64), (1, 2)))
    for cut in random.Random(0).choices(cuts, k=2 * len(cuts) ** 2):
        each, width, strip, n = cut
        times = np.zeros((24, width), np.int32)
        launcher.over(24, touch, (width,), [each, times], each=each, strip=strip, n=n)
        assert (times == 1).all()


def test_what_a_caller_makes_for_each_thread_is_not_held(launcher):
    made = []

    def own(count):
        scratch = wp.zeros((count, 1), dtype=wp.int32, device="cpu")
        made.append(weakref.ref(scratch))
        return [scratch]

    values, out = np.arange(50, dtype=np.int32), np.zeros(50, np.int32)
    launcher.over(50, add_with_scratch, (), [values, out], own=own)
    assert np.array_equal(out, values)
    assert made
    assert all(each() is None for each in made)


def test_little_scratch_is_held_however_many_sizes_there_are(launcher, monkeypatch):
    made, make = [], Launcher.empty

    def noted(self, shape, dtype):
        made.append((array := make(self, shape, dtype), weakref.ref(array))[1])
        return array

    monkeypatch.setattr(Launcher, "empty", noted)
    values, out = np.arange(50, dtype=np.int32), np.zeros(50, np.int32)
    for width in range(1, 50):
        launcher.over(50, add_with_scratch, (), [values, out], own=Scratch(width, wp.int32))
    assert len(made) == 49 * launcher.threads
    assert sum(each() is not None for each in made) <= 2 * launcher.threads


def test_a_launcher_that_was_closed_keeps_nothing():
    own = Scratch(3, wp.int32)
    closing = Launcher(threads=2)
    values, out = np.arange(50, dtype=np.int32), np.zeros(50, np.int32)
    closing.over(50, add_with_scratch, (), [values, out], own=own)
    late = closing.laid_out(50, add_with_scratch, (), [values, out], own=own)
    closing.close()
    late()
    assert np.array_equal(out, 2 * values)
    with pytest.raises(RuntimeError, match="closed"):
        closing.over(50, add_with_scratch, (), [values, out], own=own)


def test_one_of_another_kind_is_refused_and_spoils_none_after_it(launcher):
    pair = Pair()
    pair.values = wp.zeros(8, dtype=wp.int32, device="cpu")
    for _ in range(3):
        out = np.zeros(8, np.int32)
        run(launcher, True, [1, np.ones(8, np.int32), pair, out], 8)
        assert (out == 2).all()
        with pytest.raises(TypeError, match="int32 of 1 dimensions"):
            run(launcher, True, [1, np.ones(8, np.float32), pair, out], 8)


class Command:
    """A launch of which nothing is needed."""

    def __init__(self, kernel):
        self.kernel = kernel

    def let_go(self):
        pass

    def renew(self, inputs):
        pass


def test_few_are_kept_however_many_sizes_and_kernels_there_are(monkeypatch):
    kept = Spares()
    for size in range(2 * MOST_OF_ONE):
        kept.keep(Spare(Command("one"), size, ()))
    last = list(range(MOST_OF_ONE, 2 * MOST_OF_ONE))
    assert [kept.again("one", size, ()).of for size in last] == last
    assert kept.again("one", last[-1], ()) is None
    monkeypatch.setattr(spares, "MOST_KERNELS", 3)
    for kernel in range(20):
        kept.keep(Spare(Command(kernel), 0, ()))
    assert sum(kept.again(kernel, 0, ()) is not None for kernel in range(20)) <= 3
