import subprocess
import sys

import numpy as np
import pytest

from sequences.asphalt import make

SIZE = 512


@pytest.fixture(scope="module")
def maps():
    return make(0, SIZE)


def test_maps_have_their_shapes_and_ranges(maps, tolerance):
    assert [each.shape for each in maps] == [(SIZE, SIZE, 3), (SIZE, SIZE, 3), (SIZE, SIZE, 2)]
    assert {each.dtype for each in maps} == {np.dtype(np.float32)}
    assert all(np.isfinite(each).all() for each in maps)
    assert np.linalg.norm(maps.normal, axis=-1) == pytest.approx(1, abs=tolerance("unit in float32"))
    assert maps.normal[..., 2].min() > 0
    assert maps.albedo.min() > 0
    assert maps.albedo.max() < 0.7
    strength, power = maps.gloss[..., 0], maps.gloss[..., 1]
    assert strength.min() > 0
    assert 20 <= power.min() < 30
    assert 120 < power.max() <= 200


def test_the_seed_decides(maps):
    again = make(0, SIZE)
    assert all(np.array_equal(a, b) for a, b in zip(maps, again, strict=True))
    assert not np.array_equal(maps.normal, make(1, SIZE).normal)


@pytest.mark.parametrize("axis", [0, 1])
@pytest.mark.parametrize("name", ["albedo", "normal", "gloss"])
def test_maps_tile(maps, name, axis, tolerance):
    """The step over the edge is like the steps inside; in a map cut short it is not."""
    plane = getattr(maps, name).astype(np.float64)
    steps = ((plane - np.roll(plane, 1, axis)) ** 2).mean(axis=(1 - axis, 2))
    low, middle, high = np.quantile(steps[1:], (0.01, 0.5, 0.99))
    assert low / 2 < steps[0] < high * tolerance("step over a map's edge")
    cut = np.delete(plane, np.s_[: SIZE // 3], axis)
    assert ((np.take(cut, 0, axis) - np.take(cut, -1, axis)) ** 2).mean() > 1.5 * middle


def test_relief_is_steep_where_dry_and_calm_where_wet(maps):
    slope = maps.normal[..., :2] / maps.normal[..., 2:]
    wet = maps.gloss[..., 1] > 100
    assert 0.02 < wet.mean() < 0.3
    assert 0.15 < slope[~wet].std() < 0.3
    assert slope[wet].std() < 0.5 * slope[~wet].std()
    assert maps.gloss[wet, 0].mean() > maps.gloss[~wet, 0].mean()
    assert np.abs(slope.mean(axis=(0, 1))).max() < 0.02


def test_paint_and_asphalt_are_as_bright_as_measured_ones(maps):
    grey = maps.albedo.mean(axis=-1)
    assert 0.04 < np.median(grey) < 0.12
    paint = grey > 0.4
    assert 0.01 < paint.mean() < 0.06
    column = np.flatnonzero(paint.mean(axis=0) > 0.2) / SIZE
    assert {round(place, 1) for place in column} == {0.1, 0.5, 0.9}


def test_stones_are_three_to_twenty_texels_wide(maps):
    """Slopes lose their correlation within a stone."""
    slope = (maps.normal[..., 0] / maps.normal[..., 2]).astype(np.float64)
    slope -= slope.mean()
    power = np.abs(np.fft.rfft2(slope)) ** 2
    along = np.fft.irfft2(power, s=slope.shape)[0] / power.size
    assert along[1] > 0.6 * along[0]
    assert abs(along[20:40]).max() < 0.05 * along[0]


def test_filtering_before_shading_makes_a_false_streak(maps):
    """In the mirror direction the shaded mean normal is far brighter than the mean of the shaded normals."""
    dry = maps.gloss[..., 1] < 60
    normal, power = maps.normal[dry].astype(np.float64), maps.gloss[dry, 1].astype(np.float64)
    truth = (power * normal[:, 2].clip(0, 1) ** power).mean()
    mean = normal.mean(axis=0)
    false = power.mean() * (mean[2] / np.linalg.norm(mean)) ** power.mean()
    assert false > 2 * truth


def test_a_small_map_holds_together_and_a_tiny_one_is_refused():
    assert all(np.isfinite(each).all() for each in make(3, 64))
    with pytest.raises(ValueError, match="at least 64"):
        make(0, 32)


def test_the_package_stays_light():
    code = "import sys, sequences; print({'scipy', 'cv2', 'warp'} & set(sys.modules))"
    result = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert result.stdout.strip() == "set()"
