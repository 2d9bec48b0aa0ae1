"""The worst frames and regions: planted errors and flicker are found, on surfaces that move too."""

import json
import re
from dataclasses import replace
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
from report_runs import FRAMES, SIZE, make_run

from swimlab.report.clips import Clip
from swimlab.report.following import same_surface, warped
from swimlab.report.places import SIDE, worst_frames, worst_region
from swimlab.report.recorded import Run, open_run
from swimlab.report.worst import SHOWN, worst
from swimlab.runs.frames import frame_path, write_frame

VELOCITY = (2, -1)
BAD, SPOT = 3, (120, 70)
"""The frame that is wrong, and where: 8 x 8 px."""


@pytest.fixture(scope="module")
def run(tmp_path_factory: pytest.TempPathFactory) -> Run:
    """Noise that moves by VELOCITY; build `tsl` is wrong in one place of one frame."""
    folder = make_run(tmp_path_factory.mktemp("run"), techniques=("tsl", "reference"))
    width, height = SIZE
    wide = np.random.default_rng(3).uniform(0, 0.6, (height + FRAMES, width + 2 * FRAMES, 4)).astype(np.float32)
    wide[..., 3] = 1
    for t in range(FRAMES):
        picture = wide[t : t + height, 2 * (FRAMES - t) :][:, :width].copy()
        write_frame(frame_path(folder, "reference", t), picture, half=False, metadata={})
        if t == BAD:
            picture[SPOT[1] : SPOT[1] + 8, SPOT[0] : SPOT[0] + 8, :3] += 0.25
        write_frame(frame_path(folder, "tsl", t), picture, half=False, metadata={})
    path = folder / "run.json"
    record = json.loads(path.read_text(encoding="utf-8"))
    path.write_text(json.dumps({**record, "uniform_velocity": VELOCITY}), encoding="utf-8")
    return open_run(folder)


def an_entry(**rows: list[float | None]) -> dict[str, Any]:
    frames = [{"frame": t, **{key: values[t] for key, values in rows.items()}} for t in range(FRAMES)]
    return {"sequence": "road-shift", "technique": "tsl", "scores": {}, "frames": frames}


ENTRY = an_entry(mse=[0.0, 0.0, 0.0, 0.04, 0.01, 0.0], change=[None, 0.0, 0.0, 0.02, 0.02, 0.0])


def holds_spot(region: tuple[int, int, int, int]) -> bool:
    x, y, width, height = region
    return x <= SPOT[0] and SPOT[0] + 8 <= x + width and y <= SPOT[1] and SPOT[1] + 8 <= y + height


def place_of(svg: str) -> tuple[int, int, int, int]:
    x, y = map(int, re.findall(r"at \((\d+), (\d+)\)", svg)[0])
    return x, y, SIDE, SIDE


def test_frames_come_worst_first_under_the_first_key_that_is_known() -> None:
    rows = [{"frame": 7, "a": None, "b": 1.0}, {"frame": 8, "b": 3.0}, {"frame": 9, "b": 2.0}]
    assert worst_frames(rows, "a", "b") == [(8, 3.0), (9, 2.0), (7, 1.0)]
    assert worst_frames(rows, "c") == []


def test_a_planted_fault_is_found_framed_and_linked(run: Run) -> None:
    clips = [Clip(run, (0, 0, 96, 64), sizes={BAD: (96, 64)}), Clip(run, sizes={BAD: SIZE})]
    errors, flicker = worst(run, [ENTRY], clips)
    assert re.search(rf"tsl: frame {BAD} at \(\d+, \d+\), rms 0.2, then 4, 0", errors.svg)
    assert f">frame {BAD - 1}<" in flicker.svg
    for figure in (errors, flicker):
        assert holds_spot(place_of(figure.svg))
        assert figure.svg.count("<image") == 3
        assert f'href="#clip=1&amp;a=tsl&amp;b=reference&amp;frame={BAD}' in figure.svg
    assert 'href="#' not in worst(run, [ENTRY], clips[:1])[0].svg


def test_motion_from_frames_that_are_left_out_is_of_all_of_them(run: Run) -> None:
    moved = run.pictures.motion((0, 1, 4))
    assert moved(1)[3, 5].tolist() == list(VELOCITY)
    assert moved(4)[3, 5].tolist() == [3 * v for v in VELOCITY]


def test_the_bad_frame_of_a_flicker_is_named_though_the_change_out_of_it_is_larger(run: Run) -> None:
    entry = an_entry(mse=[0.0, 0.0, 0.0, 0.04, 0.01, 0.0], change=[None, 0.0, 0.0, 0.02, 0.03, 0.0])
    assert f"tsl: frame {BAD} at" in worst(run, [entry], [])[1].svg


def test_without_a_reference_what_moves_as_it_should_is_no_flicker(run: Run) -> None:
    """The noise itself changes at every pixel of the screen far more than the fault does."""
    alone = replace(run, techniques=("tsl",))
    (flicker,) = worst(alone, [ENTRY], [])
    assert holds_spot(place_of(flicker.svg))
    assert "what of the picture changes on the surface" in flicker.sentence


def test_of_many_the_worst_are_shown(run: Run) -> None:
    names = [f"build-{n}" for n in range(SHOWN + 2)]
    many = replace(run, techniques=(*names, "reference"), pictures=SimpleNamespace(**vars_of(run)))
    entries = [
        {**an_entry(mse=[0.0] * 3 + [0.01 * (1 + n)] + [0.0] * 2), "technique": name} for n, name in enumerate(names)
    ]
    (errors,) = worst(many, entries, [])
    assert re.findall(r"(build-\d): frame", errors.svg) == names[2:]
    assert f"the {SHOWN} worst of {SHOWN + 2}" in errors.sentence


def vars_of(run: Run) -> dict[str, Any]:
    """The pictures of a run, tsl's under every name."""
    read = run.pictures.read
    return {"called": "build", "read": lambda name, frame: read("reference" if name == "reference" else "tsl", frame)}


def test_runs_without_frames_of_one_size_or_rows_have_no_worst(run: Run) -> None:
    assert worst(replace(run, resizes=True), [ENTRY], []) == []
    assert worst(run, [an_entry()], []) == []


def test_a_region_counts_what_is_known_alone() -> None:
    difference = np.zeros((200, 300, 3), np.float32)
    difference[10, 20], difference[150, 250] = 9.0, 1.0
    known = np.ones((200, 300), np.bool_)
    assert worst_region(difference, known)[:2] < (21, 11)
    known[10, 20] = False
    x, y, width, height = worst_region(difference, known)
    assert x <= 250 < x + width
    assert y <= 150 < y + height
    assert worst_region(difference[:30, :20], known[:30, :20]) == (0, 0, 20, 30)


def test_what_comes_into_view_is_of_another_surface() -> None:
    """A column of pixels at rest, left of one that moves right by 3 px a frame."""
    now, before = np.zeros((2, 8, 40, 2), np.float32)
    before[:, 20:24, 0] = now[:, 23:27, 0] = 3.0
    same = same_surface(now, before)[2]
    assert same[:20].all()
    assert same[24:26].all()
    assert not same[20:23].any()
    picture = np.arange(40, dtype=np.float32)[None, :, None].repeat(8, axis=0)
    assert warped(picture, now)[2, 24:26, 0].tolist() == [21.0, 22.0]
