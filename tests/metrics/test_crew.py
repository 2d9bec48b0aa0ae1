"""Helpers: all strips are taken once, whoever is there to take them, and helpers end with who asked for them."""

import gc
import threading
import weakref
from concurrent.futures import ThreadPoolExecutor

import numpy as np
import pytest
import warp as wp

from metrics.kernels import crew as crews
from metrics.kernels import host
from metrics.kernels.crew import Crew
from metrics.kernels.host import host_launch
from metrics.kernels.launch import Launcher
from metrics.kernels.making import MAKING
from metrics.kernels.strips import dismiss, serve

ROWS, HEIGHT = 1001, 4


@wp.kernel(enable_backward=False)
def count_slowly(first: wp.int32, rounds: wp.int32, times: wp.array(dtype=wp.int32), spun: wp.array(dtype=wp.float64)):
    row = first + wp.tid()
    for _ in range(rounds):
        spun[row] = wp.sqrt(spun[row] + wp.float64(1.0))
    times[row] += 1


def so_many(rows):
    return (rows,)


def laid_out(crew, helpers, rounds=1):
    """A launch, and how often it has been on each row."""
    times = wp.zeros(ROWS, dtype=wp.int32, device="cpu")
    spun = wp.zeros(ROWS, dtype=wp.float64, device="cpu")
    launch = host_launch(count_slowly, ROWS, [0, rounds, times, spun])
    return crew.together(launch, ROWS, HEIGHT, so_many, [()] * helpers), times


def is_once(times):
    return (times.numpy() == 1).all()


def helpers_of(started_by):
    before = set(threading.enumerate())
    started_by()
    return [thread for thread in threading.enumerate() if thread not in before and thread.name == "swimlab"]


@pytest.mark.parametrize("helpers", [0, 1, 3, 9])
def test_all_strips_are_taken_once(helpers):
    """Also where more helpers are asked for than there are."""
    crew = Crew(3)
    for _ in range(50):
        launch, times = laid_out(crew, helpers)
        launch.launch()
        assert is_once(times)
    crew.close()


@pytest.mark.parametrize("helpers", [0, 2])
@pytest.mark.parametrize("some", [range(1), range(5, 6), range(3, 11), range(4, 1001), range(1001), range(0)])
def test_only_some_rows_may_be_taken(helpers, some):
    crew = Crew(2)
    launch, times = laid_out(crew, helpers)
    launch.only(some, so_many)
    launch.launch()
    assert np.flatnonzero(times.numpy()).tolist() == list(some)
    crew.close()


@pytest.mark.parametrize("helpers", [0, 2])
def test_it_can_be_laid_out_again(helpers):
    """All threads then have the new inputs, and none of the old is held."""
    crew = Crew(2)
    launch, times = laid_out(crew, helpers)
    spun = wp.zeros(ROWS, dtype=wp.float64, device="cpu")
    for rounds in range(20):
        launch.launch()
        assert is_once(times)
        launch.let_go()
        gone = weakref.ref(times)
        del times
        assert gone() is None
        times = wp.zeros(ROWS, dtype=wp.int32, device="cpu")
        launch.renew([0, rounds, times, spun])
    crew.close()


AWAIT = """
    int* const all = (int*)here.data;
    __atomic_store_n(all + first, 1, __ATOMIC_SEQ_CST);
    for (long long k = 0; k < 20000000000; ++k)
        if (__atomic_load_n(all + 1 - first, __ATOMIC_SEQ_CST)) { ((int*)met.data)[first] = 1; return; }
"""


@wp.func_native(AWAIT)
def await_other(first: wp.int32, here: wp.array(dtype=wp.int32), met: wp.array(dtype=wp.int32)):
    """Wait for the other of two strips."""


@wp.kernel(enable_backward=False)
def meet(first: wp.int32, here: wp.array(dtype=wp.int32), met: wp.array(dtype=wp.int32)):
    await_other(first, here, met)


def test_strips_are_taken_side_by_side():
    """Each of two waits until the other is there."""
    crew = Crew(1)
    for _ in range(3):
        here, met = (wp.zeros(2, dtype=wp.int32, device="cpu") for _ in range(2))
        crew.together(host_launch(meet, 1, [0, here, met]), 2, 1, so_many, [()]).launch()
        assert met.numpy().tolist() == [1, 1]
    crew.close()


def test_no_more_helpers_start_than_are_asked_for():
    crew = Crew(5)
    assert len(helpers_of(lambda: laid_out(crew, 2)[0].launch())) == 2
    assert len(helpers_of(lambda: laid_out(crew, 2)[0].launch())) == 0
    assert len(helpers_of(lambda: laid_out(crew, 9)[0].launch())) == 3
    crew.close()


def test_who_does_not_wake_is_not_waited_for(monkeypatch):
    """As after a fork, which takes no threads along, or where all cores are busy."""
    monkeypatch.setattr(threading.Thread, "start", lambda _: None)
    crew = Crew(2)
    for _ in range(2):
        launch, times = laid_out(crew, 2)
        launch.launch()
        assert is_once(times)


def test_launches_at_the_same_time_share_the_helpers():
    crew = Crew(2)

    def run(_):
        launch, times = laid_out(crew, 2, rounds=20)
        launch.launch()
        return is_once(times)

    with ThreadPoolExecutor(4) as callers:
        assert all(callers.map(run, range(200)))
    crew.close()


@pytest.mark.parametrize("rounds", [1, 10, 100, 1000])
def test_who_helps_when_it_is_closed_ends_thereafter(rounds):
    crew, launches = Crew(3), []
    started = helpers_of(lambda: launches.append(laid_out(crew, 3, rounds)))
    assert len(started) == 3
    ((launch, times),) = launches
    running = threading.Thread(target=launch.launch)
    running.start()
    crew.close()
    for thread in (running, *started):
        thread.join(60)
        assert not thread.is_alive()
    assert is_once(times)


def test_who_starts_while_it_is_closed_ends_too(monkeypatch):
    crew, start, started = Crew(2), threading.Thread.start, []

    def close_and_start(thread):
        crew.close()
        start(thread)
        started.append(thread)

    monkeypatch.setattr(threading.Thread, "start", close_and_start)
    launch, times = laid_out(crew, 2)
    launch.launch()
    assert is_once(times)
    assert len(started) == 2
    for thread in started:
        thread.join(60)
        assert not thread.is_alive()


def test_who_was_cut_short_while_it_started_helps_and_ends(monkeypatch):
    """As by Ctrl-C."""
    crew, start, started = Crew(2), threading.Thread.start, []

    def interrupted(thread):
        start(thread)
        started.append(thread)
        if len(started) == 1:
            raise KeyboardInterrupt

    monkeypatch.setattr(threading.Thread, "start", interrupted)
    with pytest.raises(KeyboardInterrupt):
        laid_out(crew, 2)
    for _ in range(20):
        launch, times = laid_out(crew, 2)
        launch.launch()
        assert is_once(times)
    assert len(started) == 2
    crew.close()
    for thread in started:
        thread.join(60)
        assert not thread.is_alive()


def test_locks_are_given_back_with_the_last_helper(monkeypatch):
    freed = []
    monkeypatch.setattr(crews._C, "PyThread_free_lock", freed.append)

    def started_and_forgotten():
        crew = Crew(3)
        started = helpers_of(lambda: laid_out(crew, 3)[0].launch())
        return started, list(crew._locks)

    started, known = started_and_forgotten()
    assert len(known) == 6
    gc.collect()
    for thread in started:
        thread.join(60)
    gc.collect()
    # Helpers of other tests may end meanwhile.
    assert sorted(lock for lock in freed if lock in known) == sorted(known)


def test_who_holds_what_makes_kernels_waits_for_no_other_launch(monkeypatch):
    """While two threads are the first to have a launcher's helpers started, which loads kernels."""
    times, spun = wp.zeros(ROWS, dtype=wp.int32, device="cpu"), wp.zeros(ROWS, dtype=wp.float64, device="cpu")
    host_launch(count_slowly, ROWS, [0, 1, times, spun])
    for kernel in (serve, dismiss):
        monkeypatch.delitem(host._LOADED, kernel, raising=False)
    with Launcher(threads=2) as launcher:
        held = threading.Event()

        def launch():
            held.wait(60)
            launcher.over(ROWS, count_slowly, (), [1, times, spun])

        other = threading.Thread(target=launch, daemon=True)
        other.start()
        with MAKING:
            held.set()
            other.join(0.2)  # by then it needs what is held here
            launcher.over(ROWS, count_slowly, (), [1, times, spun])
        other.join(60)
        assert not other.is_alive()


def test_what_is_laid_out_runs_when_all_helpers_have_ended():
    crew = Crew(2)
    launch, times = laid_out(crew, 2)
    crew.close()
    launch.launch()
    assert is_once(times)
    with pytest.raises(RuntimeError, match="closed"):
        laid_out(crew, 2)


def test_helpers_that_could_not_start_are_tried_again(monkeypatch):
    crew, start = Crew(1), threading.Thread.start

    def fail(_):
        raise RuntimeError("can't start new thread")

    monkeypatch.setattr(threading.Thread, "start", fail)
    with pytest.raises(RuntimeError, match="can't start"):
        laid_out(crew, 1)
    monkeypatch.setattr(threading.Thread, "start", start)
    launch, times = laid_out(crew, 1)
    launch.launch()
    assert is_once(times)
    crew.close()
