"""An opened build goes to another process as it is: nothing that was found of its frames is found again."""

import pickle
from dataclasses import replace
from importlib.util import find_spec

import numpy as np
import pytest
from small_shot import write_picture
from turning_shot import write_turning_shot

from swimlab.footage.request import ESTIMATE
from swimlab.footage.shot import load_shot
from swimlab.footage.subject import Subject

COUNT, SIDE = 5, 72


@pytest.fixture
def request_of(tmp_path):
    """request_of(key=value, ...) -> what to measure of the shot that turns, changed."""
    path = write_turning_shot(tmp_path, count=COUNT, cut=COUNT, side=SIDE)
    (asked,) = load_shot(path).requests(tmp_path, "linear").values()
    return lambda **changes: replace(asked, unverified=True, **changes)


def check_same(subject):
    """A subject and what another process gets of it: clips, and what is said of them."""
    carried = pickle.loads(pickle.dumps(subject))
    for mine, theirs in zip(subject.clips(), carried.clips(), strict=True):
        if mine is None:
            assert theirs is None
            continue
        assert (mine.count, mine.cuts, mine.fps) == (theirs.count, theirs.cuts, theirs.fps)
        for read in ("image", "moved", "share", "distance"):
            for t in range(mine.count):
                one, other = getattr(mine, read)(t), getattr(theirs, read)(t)
                assert (one is None and other is None) or np.array_equal(one, other)
    assert (carried.notes, carried.warnings) == (subject.notes, subject.warnings)
    assert carried.checked.entry(int) == subject.checked.entry(int)


@pytest.mark.parametrize("kind", ["vectors", "velocity", "estimated", "no reference", "mask", "jitter", "bad frame"])
def test_a_build_is_carried_as_it_is(request_of, tmp_path, kind):
    changes = {}
    if kind == "velocity":
        changes = {"motion": "1,0.5"}
    elif kind == "estimated":
        changes = {"motion": ESTIMATE}
    elif kind == "no reference":
        changes = {"reference": None}
    elif kind == "mask":
        write_picture(tmp_path / "mask.exr", np.eye(SIDE)[..., None] * np.ones(3))
        changes = {"mask": str(tmp_path / "mask.exr")}
    elif kind == "jitter":
        (tmp_path / "jitter.txt").write_text("".join(f"0.{t},-0.{t}\n" for t in range(COUNT)), encoding="utf-8")
        changes = {"motion_jitter": str(tmp_path / "jitter.txt")}
    elif kind == "bad frame":
        (tmp_path / "noisy" / "0002.exr").write_bytes(b"no picture")
        changes = {"skip_bad_frames": True}
    check_same(Subject(request_of(**changes), lambda _: None, lambda _: None))


@pytest.mark.skipif(find_spec("av") is None, reason="needs the extra `video` (PyAV)")
def test_a_video_is_carried_as_it_is(request_of, tmp_path):
    import av

    path = tmp_path / "noise.mkv"
    with av.open(str(path), "w") as container:
        stream = container.add_stream("ffv1", rate=30)
        stream.width, stream.height, stream.pix_fmt = SIDE, SIDE, "bgr0"
        for t in range(COUNT):
            pixels = np.random.default_rng(t).integers(0, 255, (SIDE, SIDE, 3), np.uint8)
            container.mux(stream.encode(av.VideoFrame.from_ndarray(pixels, format="rgb24")))
        container.mux(stream.encode())
    subject = Subject(request_of(test=str(path), reference=None), lambda _: None, lambda _: None)
    subject.test.picture(COUNT - 1)
    check_same(subject)


def test_what_is_carried_is_not_opened_again(request_of, monkeypatch):
    carried = pickle.dumps(Subject(request_of(), lambda _: None, lambda _: None))
    monkeypatch.setattr("swimlab.footage.subject.open_motion", None)
    monkeypatch.setattr("swimlab.footage.reader.read_header", None)
    test, _ = pickle.loads(carried).clips()
    assert test.moved(1).any()
