"""The launcher: threads never change a bit, and the kernel cache falls back."""

import gc
import os
import subprocess
import sys
import tempfile
import threading
import time
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

import numpy as np
import pytest
import warp as wp
from hypothesis import given, settings
from hypothesis import strategies as st

from metrics.kernels.launch import Launcher, Scratch
from sequences import load
from swimlab.render.catalogue import techniques
from swimlab.render.geometry import describe_geometry
from swimlab.render.shot import Shot

TALL = load("road-shift").with_changes(size=(40, 104))


@pytest.fixture(scope="module")
def launchers():
    opened = [Launcher(threads=threads) for threads in (1, 2, 3)]
    yield opened
    for launcher in opened:
        launcher.close()


def rendered(shoot, launchers, name, frame=1):
    """Every array of a technique's picture (or of the geometry), once for each launcher."""
    base = shoot(TALL, frame)
    for launcher in launchers:
        shot = Shot(base.sequence, frame, base.material, base.model, base.samples, launcher)
        if name == "geometry":
            geometry = describe_geometry(shot)
            yield [geometry.coverage, geometry.motion, geometry.depth]
            continue
        technique = techniques()[name]
        given = {"size": 64} if name == "tsl" else {}
        picture = technique.render(shot, technique.settings(**given))
        yield [np.asarray(each) for each in picture if each is not None]


@pytest.mark.parametrize("name", [*techniques(), "geometry"])
def test_threads_do_not_change_a_bit(shoot, launchers, name):
    one, *others = rendered(shoot, launchers, name)
    assert one[0].any()
    for other in others:
        assert [each.tobytes() for each in other] == [each.tobytes() for each in one]


@settings(derandomize=True)
@given(rows=st.integers(1, 2000))
def test_strips_partition_the_rows(launcher, rows):
    strips = launcher.strips(rows)
    covered = [row for strip in strips for row in range(strip.first, strip.first + strip.rows)]
    assert covered == list(range(rows))


@wp.kernel(enable_backward=False)
def count_up(first_row: wp.int32, times: wp.array2d(dtype=wp.int32), scratch: wp.array2d(dtype=wp.int32)):
    row = wp.tid() % scratch.shape[0]
    for i in range(times.shape[1]):
        scratch[row, i] = times[first_row + wp.tid(), i]
    for i in range(times.shape[1]):
        times[first_row + wp.tid(), i] = scratch[row, i] + 1


@settings(derandomize=True, max_examples=30)
@given(rows=st.integers(1, 700), n=st.sampled_from([1, 2, 8, 64]))
def test_a_kernel_runs_over_every_row_once(launchers, rows, n):
    """However few the threads, each with scratch of its own."""
    for launcher in launchers:
        times = launcher.zeros((rows, 3), wp.int32)
        launcher.over(rows, count_up, (), [times], n=n, own=lambda count, by=launcher: [by.empty((count, 3), wp.int32)])
        assert (times.numpy() == 1).all()


def test_scratch_is_of_one_launch_at_a_time_and_is_used_again(launchers, monkeypatch):
    made, make = [], Launcher.empty
    monkeypatch.setattr(Launcher, "empty", lambda self, shape, dtype: made.append(shape) or make(self, shape, dtype))
    for launcher in launchers:
        times, own = launcher.zeros((300, 5), wp.int32), Scratch(5, wp.int32)
        for launch in [launcher.laid_out(300, count_up, (), [times], own=own) for _ in range(2)]:
            launch()
        assert made.count((1, 5)) == 2 * launcher.threads
        launcher.over(300, count_up, (), [times], own=Scratch(5, wp.int32))
        assert (times.numpy() == 3).all()
        assert made.count((1, 5)) == 2 * launcher.threads
        launcher.over(300, count_up, (), [launcher.zeros((300, 6), wp.int32)], own=Scratch(6, wp.int32))
        assert made.count((1, 6)) == launcher.threads
        made.clear()


def test_a_launcher_that_is_forgotten_ends_its_threads_at_once():
    """Nothing that it holds holds it."""
    gc.disable()
    try:
        known = threading.enumerate()
        launcher = Launcher(threads=3)
        launcher.over(300, count_up, (), [launcher.zeros((300, 5), wp.int32)], own=Scratch(5, wp.int32))
        started = [thread for thread in threading.enumerate() if thread not in known]
        assert started
        del launcher
        for thread in started:
            thread.join(60)
        assert not any(thread.is_alive() for thread in started)
    finally:
        gc.enable()


def test_a_launcher_that_is_closed_says_so():
    launcher = Launcher(threads=2)
    launcher.close()
    with pytest.raises(RuntimeError, match="closed"):
        launcher.each(range(2), lambda _: None)


def test_one_dim_has_one_place_in_memory(launcher, monkeypatch):
    """Several threads that ask for it first are given the same bounds: their address may be noted."""
    loaded = launcher.record(count_up, (1, 1), [0, *(launcher.zeros((1, 1), wp.int32) for _ in range(2))]).of
    set_dim, ready = loaded._command.set_dim, threading.Barrier(4)

    def slowly(dim):
        time.sleep(0.01)
        set_dim(dim)

    def ask(_):
        ready.wait()
        return loaded.bounds((5000,))

    monkeypatch.setattr(loaded._command, "set_dim", slowly)
    with ThreadPoolExecutor(4) as callers:
        assert len(set(map(id, list(callers.map(ask, range(4)))))) == 1


def test_strips_may_be_the_first_that_a_thread_starts_while_it_makes_kernels():
    """Other threads wait for nothing that it holds."""
    script = """
import warp as wp
from metrics.kernels.launch import Launcher
from metrics.kernels.making import MAKING
from tests_launch_kernel import count
launcher = Launcher(threads=2)
times = launcher.zeros(1 << 20, wp.int32)
with MAKING:
    launcher.over(1 << 20, count, (), [times])
assert (times.numpy() == 1).all()
"""
    kernel = """
import warp as wp
@wp.kernel(enable_backward=False)
def count(first: wp.int32, times: wp.array(dtype=wp.int32)):
    times[first + wp.tid()] += 1
"""
    with tempfile.TemporaryDirectory() as folder:
        (Path(folder) / "tests_launch_kernel.py").write_text(kernel)
        path = os.pathsep.join([folder, *filter(None, sys.path)])
        subprocess.run([sys.executable, "-c", script], env=os.environ | {"PYTHONPATH": path}, check=True, timeout=120)


GROUP = 24


@wp.kernel(enable_backward=False)
def count_groups(first_row: wp.int32, times: wp.array2d(dtype=wp.int32)):
    start = first_row + wp.static(GROUP) * wp.tid()
    for row in range(start, wp.min(start + wp.static(GROUP), times.shape[0])):
        times[row, 0] += start


@settings(derandomize=True, max_examples=30)
@given(rows=st.integers(1, 700))
def test_rows_that_a_kernel_takes_together_stay_together(launchers, rows):
    """However many strips, each group of rows begins where it would in one."""
    for launcher in launchers:
        times = launcher.zeros((rows, 1), wp.int32)
        launcher.over(rows, count_groups, (), [times], each=GROUP)
        assert np.array_equal(times.numpy()[:, 0], np.arange(rows) // GROUP * GROUP)


def test_every_item_is_worked_on_once(launcher):
    done, lock = [], threading.Lock()

    def body(item):
        with lock:
            done.append(item)

    launcher.each(range(50), body)
    assert sorted(done) == list(range(50))


def test_an_error_in_a_thread_is_raised(launcher):
    def body(item):
        if item == 3:
            raise RuntimeError("item 3")

    with pytest.raises(RuntimeError, match="item 3"):
        launcher.each(range(8), body)


def test_an_error_is_raised_while_all_threads_are_busy():
    busy = threading.Barrier(4)

    def fail(_):
        raise RuntimeError("within")

    def body(_):
        busy.wait()
        launcher.each(range(3), fail)

    with Launcher(threads=2) as launcher, ThreadPoolExecutor(2) as callers:
        for caller in [callers.submit(launcher.each, range(2), body) for _ in range(2)]:
            with pytest.raises(RuntimeError, match="within"):
                caller.result()


def test_an_unknown_device_is_refused_by_name():
    with pytest.raises(ValueError, match=r"cuda:99: not on this machine; it has .*cpu"):
        Launcher(device="cuda:99")


@pytest.mark.parametrize("variable", ["HOME", "XDG_CACHE_HOME", "WARP_CACHE_PATH"])
def test_an_unwritable_cache_falls_back_with_a_warning(tmp_path, variable):
    """A path under a regular file cannot be made by anyone, root included."""
    file = tmp_path / "file"
    file.write_text("")
    kept = {key: value for key, value in os.environ.items() if key not in ("WARP_CACHE_PATH", "XDG_CACHE_HOME")}
    spare = tmp_path / "spare"
    spare.mkdir()
    result = subprocess.run(
        [sys.executable, "-c", "from metrics.kernels.starting import start_warp; print(start_warp())"],
        env=kept | {variable: str(file / "cache"), "TMPDIR": str(spare)},
        capture_output=True,
        text=True,
        check=True,
    )
    folder = Path(result.stdout.strip())
    assert folder.parent == spare
    assert folder.is_dir()
    assert f"kernel cache {file}" in result.stderr
    assert f"cannot be written; using {folder}" in result.stderr


def test_the_result_of_one_thread_is_not_all_zero(shoot, launchers):
    (rgba, *_), *_ = rendered(shoot, launchers[:1], "pixel-point")
    assert np.isfinite(rgba).all()
    assert rgba[..., :3].max() > 0
