import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from pydantic import ValidationError

from sequences import Material, Road, Scene, Sun, Wires


def test_a_flat_road_is_flat():
    y = np.linspace(-100, 100, 12).reshape(3, 4)
    for values in (Road().height_at(y), Road().slope_at(y)):
        assert values.shape == y.shape
        assert values.dtype == np.float64
        assert not values.any()


def test_hills_are_a_sine_of_y(tolerance):
    road = Road(profile="hills", amplitude=0.5, wavelength=20.0)
    y = np.array((0.0, 5.0, 10.0, 15.0, 20.0))
    assert road.height_at(y) == pytest.approx(np.array((0, 0.5, 0, -0.5, 0)), abs=tolerance("closed form"))
    top = 0.5 * math.tau / 20
    assert road.slope_at(y) == pytest.approx(np.array((top, 0, -top, 0, top)), abs=tolerance("closed form"))


@settings(derandomize=True)
@given(y=st.floats(-500, 500), amplitude=st.floats(0, 5), wavelength=st.floats(5, 100))
def test_slope_is_the_derivative_of_height(y, amplitude, wavelength, tolerance):
    road = Road(profile="hills", amplitude=amplitude, wavelength=wavelength)
    step = 1e-4
    difference = (road.height_at(y + step) - road.height_at(y - step)) / (2 * step)
    assert road.slope_at(y) == pytest.approx(difference, abs=tolerance("central difference of hills"))


@pytest.mark.parametrize("given", [{}, {"amplitude": 1.0}, {"wavelength": 1.0}])
def test_hills_need_both_lengths(given):
    with pytest.raises(ValidationError, match="hills"):
        Road(profile="hills", **given)


def test_a_flat_road_has_no_amplitude():
    with pytest.raises(ValidationError, match="flat road"):
        Road(amplitude=1.0)


@pytest.mark.parametrize(
    ("azimuth", "elevation", "direction"),
    [
        (0, 0, (0, 1, 0)),
        (90, 0, (1, 0, 0)),
        (180, 0, (0, -1, 0)),
        (-90, 0, (-1, 0, 0)),
        (33, 90, (0, 0, 1)),
        (0, 30, (0, math.sqrt(0.75), 0.5)),
    ],
)
def test_the_sun_goes_clockwise_from_straight_ahead(azimuth, elevation, direction, tolerance):
    sun = Sun(azimuth=azimuth, elevation=elevation)
    assert sun.direction == pytest.approx(np.array(direction, dtype=float), abs=tolerance("rotation"))


@settings(derandomize=True)
@given(azimuth=st.floats(-360, 360), elevation=st.floats(-90, 90))
def test_the_direction_to_the_sun_is_unit(azimuth, elevation, tolerance):
    direction = Sun(azimuth=azimuth, elevation=elevation).direction
    assert np.linalg.norm(direction) == pytest.approx(1, abs=tolerance("rotation"))


def test_an_unknown_made_map_is_an_error():
    with pytest.raises(ValidationError, match="made:asphalt"):
        Material(albedo="made:gravel")


def test_wires_are_evenly_spaced_across(tolerance):
    places = Wires(count=4).places(Road(width=8.0))
    assert places == pytest.approx(np.array((-3.0, -1.0, 1.0, 3.0)), abs=tolerance("closed form"))


def test_wires_that_overlap_are_an_error():
    road = Road(width=2.0)
    assert Scene(road=road, wires=Wires(count=20, width=0.1)).wires is not None
    with pytest.raises(ValidationError, match=r"21 wires of 0\.1 m overlap on a road of 2\.0 m"):
        Scene(road=road, wires=Wires(count=21, width=0.1))


@pytest.mark.parametrize("tessellation", [(0, 1), (1, 257), (1, 1, 1), (2.0, 1), 4])
def test_a_road_is_cut_into_whole_quads(tessellation):
    with pytest.raises(ValidationError, match="tessellation"):
        Road(tessellation=tessellation)
