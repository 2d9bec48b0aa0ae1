"""Threads that help: each task is done once or called off, and threads end with who asked for them."""

import gc
import threading
import time
from threading import Barrier, Event

import pytest

from metrics.kernels.workers import Workers


@pytest.fixture
def workers():
    made = Workers(2)
    yield made
    made.close()


def test_tasks_run_side_by_side_in_threads_of_their_own(workers):
    met, seen = Barrier(3), []

    def work():
        met.wait(60)
        seen.append(threading.get_ident())

    tasks = [workers.start(work) for _ in range(2)]
    met.wait(60)
    assert [task.end() for task in tasks] == [None, None]
    assert len({*seen, threading.get_ident()}) == 3


def test_what_nobody_has_begun_is_called_off(workers):
    busy, go, done = Barrier(3), Event(), []

    def wait():
        busy.wait(60)
        go.wait(60)

    waiting = [workers.start(wait) for _ in range(2)]
    busy.wait(60)
    late = workers.start(lambda: done.append(True))
    assert late.end() is None
    go.set()
    assert [task.end() for task in waiting] == [None, None]
    after = workers.start(go.wait)
    assert after.end() is None
    assert not done


def test_an_error_is_handed_over_each_time_it_is_asked_for(workers):
    begun = Event()

    def fail():
        begun.set()
        raise KeyError("this one")

    task = workers.start(fail)
    assert begun.wait(60)
    assert task.end() is task.end()
    assert isinstance(task.end(), KeyError)


def threads_after(make):
    """Threads that are left of those that `make` has started, once it is done and the last of them had time to end."""
    before = set(threading.enumerate())
    started = make()
    gc.collect()
    for thread in started:
        thread.join(60)
    return set(threading.enumerate()) - before


def ours():
    return [thread for thread in threading.enumerate() if thread.name == "swimlab"]


@pytest.mark.parametrize("closes", [True, False])
def test_threads_end_when_they_are_closed_or_forgotten(closes):
    def make():
        before = ours()
        workers = Workers(3)
        assert ours() == before  # none before there is work
        met = Barrier(4)
        tasks = [workers.start(met.wait) for _ in range(3)]
        met.wait(60)
        assert [task.end() for task in tasks] == [None] * 3
        started = [thread for thread in ours() if thread not in before]
        assert len(started) == 3
        if closes:
            workers.close()
        return started

    assert threads_after(make) == set()


def test_no_more_threads_start_than_are_needed(workers):
    before, done = ours(), Event()
    for _ in range(20):
        done.clear()
        task = workers.start(done.set)
        assert done.wait(60)
        task.end()
        while not workers._idle:
            time.sleep(0.001)
    assert len([thread for thread in ours() if thread not in before]) == 1


def test_after_closing_nobody_can_be_asked():
    workers = Workers(1)
    workers.close()
    with pytest.raises(RuntimeError, match="closed"):
        workers.start(lambda: None)


def test_threads_that_could_not_start_are_tried_again(monkeypatch):
    workers, start = Workers(1), threading.Thread.start

    def fail(_):
        raise RuntimeError("can't start new thread")

    monkeypatch.setattr(threading.Thread, "start", fail)
    with pytest.raises(RuntimeError, match="can't start"):
        workers.start(lambda: None)
    monkeypatch.setattr(threading.Thread, "start", start)
    begun = Event()
    task = workers.start(begun.set)
    assert begun.wait(60)
    assert task.end() is None
    workers.close()


def test_calling_off_may_be_cut_short_and_done_again(workers):
    """As by Ctrl-C between two of its steps: the second time it ends too."""
    task = workers.start(Event().set)
    task._begun.acquire(blocking=False)
    assert task.end() is None
