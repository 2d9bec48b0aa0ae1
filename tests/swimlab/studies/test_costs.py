"""What `bench costs` holds: sums, units and shares; never how fast anything was."""

import json
from concurrent.futures import ThreadPoolExecutor
from itertools import count

import numpy as np
import pytest
import warp as wp
from hypothesis import given
from hypothesis import strategies as st

from sequences import load
from swimlab.render.catalogue import techniques
from swimlab.studies.costs import study, watched
from swimlab.studies.costs.parallel import WholeLauncher, parallel_tasks
from swimlab.studies.costs.serial import Rounds, Serial, own_share, serial_share, serial_study
from swimlab.studies.costs.watched import WatchedLauncher, watched_frames
from swimlab.studies.costs.work import READS, Rates, Sight
from swimlab.studies.trials import Variant
from swimlab.studies.turns import Time

SMALL = load("road-shift").with_changes(size=(96, 64))
WANTED = ("pixel-point", "pixel-bilinear", "pixel-aniso", "supersample", "vertex")
NOTHING_SERIAL = Serial("measuring", (8, 8), 2.0, 1.0, [0.0], [0.0], 2.0, 0.1, 2.0)


@pytest.fixture(scope="module")
def costs():
    return study.cost_study(
        SMALL, rounds=2, only=lambda variant: variant.label in WANTED, serial=lambda *_, **__: [NOTHING_SERIAL]
    )


def test_times_add_up_and_have_their_units(costs, tolerance):
    assert [row.label for row in costs.rows] == sorted(WANTED)
    for row in costs.rows:
        assert row.cpu_ms > 0
        assert row.wall_ms > 0
        assert row.quartiles[0] <= row.quartiles[1]
        assert sum(row.kernels.values()) > 0
        assert 0 < row.outside_ms < row.cpu_ms + row.quartiles[1]
        assert row.bytes == 32 * row.reads
        least = 1e-6 * (row.reads * costs.rates.read_ns + row.shaded * costs.rates.shade_ns)
        assert row.least_ms == pytest.approx(least, abs=tolerance("rounding"))
    named = {row.label: row for row in costs.rows}
    assert named["pixel-aniso"].ratio == 1
    assert named["pixel-point"].ratio == named["pixel-point"].cpu_ms / named["pixel-aniso"].cpu_ms


def test_work_is_counted(costs):
    named = {row.label: row for row in costs.rows}
    pixels = named["pixel-aniso"].shaded
    assert 0 < pixels < 96 * 64
    assert named["pixel-point"].reads == pixels
    assert named["pixel-bilinear"].reads == 4 * pixels
    assert 4 * pixels < named["pixel-aniso"].reads <= 16 * 8 * pixels
    assert named["supersample"].reads > named["pixel-aniso"].reads


def test_probes_are_counted_as_the_filter_takes_them(shoot):
    sight = Sight(shoot(SMALL, 0))
    assert sight.anisotropic(1) <= sight.anisotropic(2) <= sight.anisotropic(16) <= 16 * sight.anisotropic(1)
    assert sight.anisotropic(16) > sight.anisotropic(1)
    assert sight.anisotropic(16, 2) > sight.anisotropic(16)


def test_every_technique_and_setting_is_tried_once():
    labels = [variant.label for variant, _ in study.candidates()]
    assert len(labels) == len(set(labels))
    assert set(techniques()) <= set(labels)
    assert "tsl needed vmf" in labels
    assert "aniso 16" not in labels  # the default of pixel-aniso
    assert set(READS) == set(techniques())


def test_kernels_are_noted_by_name_and_forgotten():
    with WatchedLauncher(threads=2) as launcher:
        stage = study.Stage(SMALL, [0], samples=4, launcher=launcher)
        stage.pictures(Variant("pixel-aniso", "pixel-aniso"))
        noted = launcher.take()
        assert "draw_samples" in noted
        assert all(ms > 0 for ms in noted.values())
        assert not launcher.take()


@pytest.mark.parametrize("name", ["pixel-aniso", "taa"])
def test_a_timed_frame_follows_one_of_its_own(monkeypatch, name):
    """Frames are rendered in order, every second one is timed, and only what that one takes is noted."""
    with WatchedLauncher(threads=2) as launcher:
        stage = study.Stage(SMALL, [3], samples=4, launcher=launcher)
        rendered, shot = [], stage.shot
        monkeypatch.setattr(stage, "shot", lambda frame: rendered.append(frame) or shot(frame))
        task, noted = watched_frames(stage, Variant(name, name), launcher)
        for turn in range(3):
            run = task(turn)
            assert (rendered, len(noted)) == (list(range(3, 4 + 2 * turn)), turn)
            assert not launcher.take()
            run()
            assert rendered == list(range(3, 5 + 2 * turn))
        alone = [Variant(name, name).begin()(shot(frame)).shaded for frame in (4, 6, 8)]
        assert [frame.shaded for frame in noted] == alone
        kernels = {"taa": {"sample_with", "resolve_with"}, "pixel-aniso": {"draw_samples"}}[name]
        assert all(kernels <= set(frame.kernels) for frame in noted)


@given(share=st.floats(0, 1), one=st.floats(0.1, 1e3))
def test_amdahls_law_is_inverted(share, one, tolerance):
    two = one * (share + (1 - share) / 2)
    assert serial_share(one, two) == pytest.approx(share, abs=tolerance("rounding"))


@given(share=st.floats(0, 1), others=st.floats(0, 10))
def test_what_others_take_is_not_the_programs_share(share, others, tolerance):
    """Serial for S, and for P on two cores, while each thread waits for a core for a time besides."""
    work = 10.0
    wall = work * (share + (1 - share) / 2) + others
    assert own_share(Time(wall, work, 2 * others)) == pytest.approx(share, abs=tolerance("rounding"))


def test_shares_of_rounds_have_their_spread():
    one, two = [Time(10.0, 9.0)] * 3, [Time(5.0, 10.0), Time(6.0, 9.0), Time(10.0, 10.0, 5.0)]
    found = Rounds(one, two, [8.1, 8.1, 9.0], [Time(20.0, 20.0)] * 3, [Time(10.0, 20.0)] * 3).serial("x", (4, 2))
    assert found.shares == pytest.approx([0.0, 0.2, 1.0])
    assert found.share == pytest.approx(0.2)
    assert found.quartiles[0] <= found.share <= found.quartiles[1]
    assert found.own == pytest.approx([0.0, 1 / 3, 0.5])
    assert found.own_quartiles[0] <= found.own_share <= found.own_quartiles[1]
    assert (found.one_ms, found.two_ms, found.busy, found.gain) == (10.0, 6.0, 1.5, 2.0)
    assert found.outside == pytest.approx(0.1)
    at_most = Rounds(one, two).serial("x", (4, 2))
    assert at_most.own == pytest.approx([0.0, 1 / 3, 1.0])
    assert at_most.outside is at_most.gain is None


def test_kernels_alone_draw_both_pictures_whole():
    """Each of the two frames again, in its own picture, whichever way it is timed."""
    with WholeLauncher() as launcher, ThreadPoolExecutor(1) as pool:
        stage = study.Stage(SMALL, [0], samples=4, launcher=launcher)
        variant = Variant("pixel-aniso", "pixel-aniso")
        exact = stage.pictures(variant)[0].rgba
        for task in parallel_tasks(stage, variant, launcher, pool):
            picture = next(value for value in launcher.held[0].inputs if getattr(value, "shape", ()) == (64, 96, 4))
            picture.fill(0)
            task(0)()
            assert np.array_equal(picture, exact)


@wp.kernel(enable_backward=False)
def count_rows(first: wp.int32, times: wp.array(dtype=wp.int32)):
    times[first + wp.tid()] += 1


def test_time_of_helpers_is_that_of_their_kernel(monkeypatch):
    """Where a crew helps, the process's; of a thread that starts a launch alone its own."""
    whole, own = count(0.0, 0.5), count(0.0, 0.25)
    monkeypatch.setattr(watched.time, "process_time", lambda: next(whole))
    monkeypatch.setattr(watched.time, "thread_time", lambda: next(own))
    for threads, milliseconds in ((1, 250.0), (2, 500.0)):
        with WatchedLauncher(threads=threads) as launcher:
            launcher.over(64, count_rows, (), [launcher.zeros(64, wp.int32)])
            assert launcher.take() == {"count_rows": milliseconds}


def test_rates_are_nanoseconds():
    assert Rates(read_ns=2.0, shade_ns=5.0).least_ms(1_000_000, 2_000_000) == 12.0


def test_rendering_and_measuring_are_timed_on_one_thread_and_two():
    found = serial_study(SMALL, rounds=1, render_size=(64, 64), measure_size=(96, 80))
    assert [each.what for each in found] == ["pixel-point", "pixel-trilinear", "pixel-aniso", "vmf", "measuring"]
    assert all(each.one_ms > 0 and each.two_ms > 0 and each.busy > 0 for each in found)
    assert all(0 < each.outside < 1 and each.gain > 0 for each in found[:-1])
    assert all(len(each.own) == 1 for each in found)
    assert found[-1].outside is found[-1].gain is None


def test_costs_are_printed(swimlab, monkeypatch, costs):
    monkeypatch.setattr(study, "cost_study", lambda *_, **__: costs)
    code, out, err = swimlab("bench", "costs", "-q")
    assert (code, err) == (0, "")
    for label in WANTED:
        assert any(line.strip().startswith(label) for line in out.splitlines())
    assert "ns a texel read" in " ".join(out.split())
    code, out, _ = swimlab("bench", "costs", "--json", "-q")
    found = json.loads(out)
    assert code == 0
    assert (found["sequence"], found["size"]) == ("road-shift", [96, 64])
    contract = {"label", "technique", "settings", "cpu_ms", "wall_ms", "outside_ms", "ratio", "shaded"}
    assert all(contract <= set(row) for row in found["rows"])
    assert {"share", "quartiles", "own_share", "own_quartiles", "gain", "outside", "one_ms", "two_ms"} <= set(
        found["serial"][0]
    )


def test_a_bad_number_of_rounds_is_refused(swimlab):
    code, _, err = swimlab("bench", "costs", "--rounds", "0", "-q")
    assert code == 2
    assert "--rounds 0" in err
