import importlib
import pkgutil

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import sequences.motions
from sequences import MOTIONS, Sequence
from sequences.motions import by_kind
from sequences.motions.drive import Drive
from sequences.motions.scale import Scale
from sequences.motions.shift import Shift


def sequence(motion, **keys):
    return Sequence.model_validate({"version": 1, "name": "a", "motion": motion, **keys})


@pytest.mark.parametrize("kind", MOTIONS)
@pytest.mark.parametrize("frames", [1, 2, 9])
def test_every_motion_has_a_view_at_any_frame(kind, frames):
    still = sequence({"kind": kind}, frames=frames)
    for t in (-1, 0, 1, frames, 10 * frames):
        view = still.view(t)
        assert view.width >= 1
        assert view.height >= 1
        assert min(view.pitch) > 0
    assert still.motion.resizes == (still.view(0).width != still.view(8 * frames).width)


@pytest.mark.parametrize("kind", MOTIONS)
def test_every_motion_describes_itself(kind):
    model = MOTIONS[kind]
    assert model.__doc__
    assert all(field.description for field in model.model_fields.values())
    assert sequence({"kind": kind}).motion == model(kind=kind)


def test_a_file_of_motions_is_all_it_takes():
    files = {found.name for found in pkgutil.iter_modules(sequences.motions.__path__)}
    found = {importlib.import_module(motion.__module__).__name__.split(".")[-1] for motion in MOTIONS.values()}
    assert found == files == {"shift", "scale", "drive", "turn", "sun"}


def test_two_motions_of_one_kind_are_refused():
    with pytest.raises(ValueError, match="two motions are called 'shift'"):
        by_kind([Shift, Drive, Shift])


@settings(derandomize=True)
@given(t=st.integers(-5, 1000), vx=st.floats(-50, 50), vy=st.floats(-50, 50))
def test_shift_samples_the_base_image_a_velocity_behind(t, vx, vy):
    shifted = sequence({"kind": "shift", "velocity": [vx, vy]}, size=[64, 36])
    view = shifted.view(t)
    assert view.origin == (-t * vx, -t * vy)
    assert (view.width, view.height, view.pitch) == (64, 36, (1.0, 1.0))
    assert view.camera == shifted.camera
    assert shifted.motion.uniform_velocity == (vx, vy)


def test_scale_goes_in_equal_ratios():
    scaled = sequence({"kind": "scale"}, size=[640, 360], frames=9)
    sizes = [(scaled.view(t).width, scaled.view(t).height) for t in range(9)]
    assert sizes == [
        (640, 360),
        (453, 255),
        (320, 180),
        (226, 127),
        (160, 90),
        (113, 64),
        (80, 45),
        (57, 32),
        (40, 23),
    ]
    assert (scaled.view(-1).width, scaled.view(-1).height) == (905, 509)
    assert scaled.motion.uniform_velocity is None


@settings(derandomize=True)
@given(t=st.integers(-2, 20), start=st.floats(0.01, 16), end=st.floats(0.01, 16), width=st.integers(8, 2000))
def test_scale_keeps_the_field_of_view(t, start, end, width, tolerance):
    scaled = sequence({"kind": "scale", "from": start, "to": end}, size=[width, 36], frames=11)
    view = scaled.view(t)
    assert view.origin == (0.0, 0.0)
    spans = (view.width * view.pitch[0], view.height * view.pitch[1])
    assert spans == pytest.approx((width, 36), rel=tolerance("closed form"))
    ratio = scaled.motion.factor(11, t + 1) / scaled.motion.factor(11, t)
    assert ratio**10 == pytest.approx(end / start, rel=tolerance("closed form"))
    assert abs(view.width - width * scaled.motion.factor(11, t)) <= 0.5 or view.width == 1


def test_halves_are_rounded_up_and_nothing_vanishes():
    assert Scale(**{"from": 0.5, "to": 0.5}).view(sequence({"kind": "scale"}, size=[9, 11]), 0).width == 5
    tiny = sequence({"kind": "scale", "to": 1e-6}, size=[8, 8])
    assert (tiny.view(31).width, tiny.view(31).height) == (1, 1)


def test_one_frame_of_scale_has_the_first_size():
    assert sequence({"kind": "scale", "from": 0.5}, size=[64, 36], frames=1).view(0).width == 32


def test_drive_moves_the_camera_alone(tolerance):
    driven = sequence({"kind": "drive", "speed": 15.0}, fps=60, camera={"distance": 100.0, "yaw": 30.0})
    for t in (-1, 0, 1, 31):
        view = driven.view(t)
        assert view.camera.distance == pytest.approx(100 + t / 4, rel=tolerance("closed form"))
        assert view.camera.model_copy(update={"distance": 100.0}) == driven.camera
        assert (view.origin, view.pitch, view.width, view.height) == ((0.0, 0.0), (1.0, 1.0), 640, 360)
    assert driven.motion.uniform_velocity is None


@settings(derandomize=True)
@given(t=st.integers(-5, 1000), speed=st.floats(-90, 90), yaw=st.floats(-360, 360))
def test_turn_turns_the_camera_alone(t, speed, yaw, tolerance):
    turned = sequence({"kind": "turn", "speed": speed}, fps=50, camera={"distance": 7.0, "yaw": yaw})
    view = turned.view(t)
    assert view.camera.yaw == pytest.approx(yaw + speed * t / 50, rel=tolerance("closed form"))
    assert view.camera.model_copy(update={"yaw": yaw}) == turned.camera
    assert (view.origin, view.pitch, view.width, view.height) == ((0.0, 0.0), (1.0, 1.0), 640, 360)
    assert turned.motion.uniform_velocity is None


@settings(derandomize=True)
@given(t=st.integers(-5, 1000), around=st.floats(-90, 90), up=st.floats(-90, 90))
def test_the_sun_sweeps_over_a_picture_that_stands_still(t, around, up, tolerance):
    motion = {"kind": "sun", "azimuth_speed": around, "elevation_speed": up}
    swept = sequence(motion, fps=50, scene={"sun": {"azimuth": 10.0, "elevation": 20.0, "diffuse": 0.3}})
    sun = swept.sun(t)
    assert sun.azimuth == pytest.approx(10 + around * t / 50, rel=tolerance("closed form"))
    assert sun.elevation == pytest.approx(20 + up * t / 50, rel=tolerance("closed form"))
    assert sun.diffuse == 0.3
    assert swept.view(t) == swept.view(0)
    assert swept.motion.uniform_velocity == (0.0, 0.0)


@pytest.mark.parametrize("kind", sorted(set(MOTIONS) - {"sun"}))
def test_the_sun_stands_still_under_any_other_motion(kind):
    lit = sequence({"kind": kind}, scene={"sun": {"azimuth": 10.0}})
    assert all(lit.sun(t) == lit.scene.sun for t in (-1, 0, 31))
