"""What holds for every camera, sun, map and motion."""

import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from metrics.kernels.launch import Launcher
from sequences import load
from swimlab.render.catalogue import model_of, techniques
from swimlab.render.geometry import describe_geometry
from swimlab.render.shot import Shot

SIZE = (40, 24)
SETTINGS = {"tsl": {"size": 32}, "taa": {"preroll": 2, "period": 2}, "vertex": {"quads": (4, 4)}}
PIXELS = sorted(set(techniques()) - {"tsl", "taa", "vertex", "reference"})
"""Techniques that shade at places of the screen alone."""
SLIDING = [*PIXELS, "tsl", "vertex"]
"""Techniques whose picture goes with the grid; the reference's jitter is the pixel's own, and taa's the frame's."""

some = settings(derandomize=True, max_examples=25, suppress_health_check=list(HealthCheck))


def cameras_within(**ranges):
    return st.fixed_dictionaries({key: st.floats(low, high) for key, (low, high) in ranges.items()})


driving = cameras_within(
    height=(0.05, 3), lateral=(-2, 2), distance=(-1e7, 1e7), pitch=(-60, 0), yaw=(-30, 30), fov=(20, 90)
)
lost = cameras_within(
    height=(0.05, 50), lateral=(-10, 10), distance=(-1e7, 1e7), pitch=(-90, 90), yaw=(-180, 180), fov=(5, 120)
)
cameras = st.one_of(driving, driving, lost)
suns = st.fixed_dictionaries(
    {"azimuth": st.floats(-180, 180), "elevation": st.floats(-90, 90), "diffuse": st.floats(0, 4)}
)
motions = st.one_of(
    st.fixed_dictionaries(
        {"kind": st.just("shift"), "velocity": st.tuples(st.floats(-8, 8), st.floats(-8, 8)).map(list)}
    ),
    st.fixed_dictionaries({"kind": st.just("drive"), "speed": st.floats(-100, 100)}),
    st.fixed_dictionaries({"kind": st.just("turn"), "speed": st.floats(-90, 90)}),
)
roads = st.sampled_from(
    [
        {"profile": "flat"},
        {"profile": "hills", "amplitude": 1.0, "wavelength": 32.0},
        {"profile": "flat", "width": 0.5, "segment": 3.0, "length": 20.0},
    ]
)
seeds = st.integers(0, 1000)


def random_maps(seed, *, side=16):
    """Maps [side, side, 8] of independent texels: albedo to 2, normals to the horizon, Ks to 3, powers to 3..1e5."""
    random = np.random.default_rng(seed)
    normal = random.normal(size=(side, side, 3))
    normal[..., 2] = np.abs(normal[..., 2])
    normal /= np.linalg.norm(normal, axis=2, keepdims=True)
    ks, largest = random.uniform(0, 3, (side, side, 1)), random.choice([0.5, 2.0, 5.0])
    power = 10 ** random.uniform(-1, largest, (side, side, 1))
    return np.concatenate([random.uniform(0, 2, (side, side, 3)), normal, ks, power], axis=2).astype(np.float32)


def road(*, camera=None, sun=None, motion=None, profile=None, **changes):
    scene = {"road": profile or {"profile": "flat"}, "sun": sun or {}}
    given = {"camera": camera or {}, "motion": motion or {"kind": "shift"}, "scene": scene}
    return load("road-shift").with_changes(**({"size": SIZE} | given | changes))


@some
@given(camera=cameras, sun=suns, motion=motions, profile=roads, seed=seeds)
def test_radiance_is_finite_and_no_more_than_the_maps_can_give(
    shoot, render, pack_maps, tolerance, camera, sun, motion, profile, seed
):
    maps = random_maps(seed)
    shot = shoot(road(camera=camera, sun=sun, motion=motion, profile=profile), 3, pack_maps(maps))
    # Of means of texels, under any filter: sat(N.L) <= 1 and (N.H)^p <= 1. A widened lobe has less power, not more.
    most = maps[..., :3].max() * shot.sun.diffuse + maps[..., 6].max() * maps[..., 7].max()
    for name in techniques():
        picture = render(shot, name, **SETTINGS.get(name, {}))
        assert np.isfinite(picture.rgba).all(), name
        assert picture.rgba.min() >= 0, name
        assert picture.rgba[..., 3].max() <= 1, name
        assert picture.rgba[..., :3].max() <= most * (1 + tolerance("linear light")), name
        assert not picture.rgba[picture.rgba[..., 3] == 0].any(), name
        if picture.error is not None:
            assert np.isfinite(picture.error).all(), name


@some
@given(camera=cameras, sun=suns, profile=roads, seed=seeds)
def test_techniques_agree_on_what_they_cover(shoot, render, pack_maps, camera, sun, profile, seed):
    """Coverage is a matter of the road and the grid: pixels' centres, or the 16 samples of a pixel."""
    shot = shoot(road(camera=camera, sun=sun, profile=profile), 0, pack_maps(random_maps(seed)))
    single = [name for name in SLIDING if name != "supersample"]
    alphas = [render(shot, name, **SETTINGS.get(name, {})).rgba[..., 3] for name in single]
    # Vertex lighting cuts hills in its own quads.
    for name, alpha in zip(single, alphas, strict=True):
        if name != "vertex" or profile["profile"] == "flat":
            assert np.array_equal(alpha, alphas[0]), name
    assert set(np.unique(alphas[0]).tolist()) <= {0.0, 1.0}
    parts = render(shot, "reference").rgba[..., 3] * 16
    assert np.array_equal(parts, np.round(parts))
    geometry = describe_geometry(shot)
    assert (geometry.depth[alphas[0] == 1] > 0).all()
    assert not geometry.depth[alphas[0] == 0].any()


@some
@given(camera=cameras, cut=st.integers(1, 7), profile=roads)
def test_segments_partition_what_the_road_covers(shoot, camera, cut, profile):
    """Finer quads cover the same samples, each by one triangle: no hole, no overlap, wherever the cuts fall."""
    whole = road(camera=camera, profile=profile | {"tessellation": [1, 64]})
    parts = road(camera=camera, profile=profile | {"tessellation": [cut, 64]})
    one, other = (describe_geometry(shoot(sequence)) for sequence in (whole, parts))
    assert np.array_equal(one.coverage, other.coverage)
    assert np.array_equal(one.depth > 0, other.depth > 0)


@some
@given(sun=suns, seed=seeds, factor=st.floats(0.1, 10))
def test_texture_space_light_is_linear_in_albedo(shoot, render, pack_maps, tolerance, sun, seed, factor):
    one, two = random_maps(seed), random_maps(seed + 1)
    one[..., 6] = 0
    two[..., 3:] = one[..., 3:]
    both = one.copy()
    both[..., :3] = one[..., :3] + np.float32(factor) * two[..., :3]
    sequence = road(sun=sun)
    a, b, sum_of_both = (render(shoot(sequence, 0, pack_maps(m)), "tsl", size=32).rgba for m in (one, two, both))
    expected = a[..., :3] + np.float32(factor) * b[..., :3]
    assert np.abs(sum_of_both[..., :3] - expected).max() <= tolerance("linear light") * max(expected.max(), 1e-30)


@some
@given(camera=cameras, sun=suns, profile=roads, seed=seeds, step=st.tuples(st.integers(-3, 3), st.integers(-3, 3)))
def test_a_shift_by_whole_pixels_moves_every_bit(shoot, render, pack_maps, camera, sun, profile, seed, step):
    motion = {"kind": "shift", "velocity": [float(each) for each in step]}
    sequence, material = road(camera=camera, sun=sun, motion=motion, profile=profile), pack_maps(random_maps(seed))
    x, y = step
    (width, height), row, column = SIZE, max(0, y), max(0, x)
    now = np.s_[row : height + min(0, y), column : width + min(0, x)]
    before = np.s_[row - y : height + min(0, y) - y, column - x : width + min(0, x) - x]
    for name in SLIDING:
        first, second = (
            render(shoot(sequence, frame, material), name, **SETTINGS.get(name, {})).rgba for frame in (0, 1)
        )
        assert np.array_equal(second[now], first[before]), name


@pytest.fixture(scope="module")
def single():
    with Launcher(threads=1) as launcher:
        yield launcher


@pytest.mark.parametrize("name", techniques())
def test_threads_and_strips_change_no_bit(shoot, render, single, monkeypatch, name):
    sequence = load("road-hills").with_changes(size=(40, 70))
    shot = shoot(sequence, 2)
    settings = SETTINGS.get(name, {})
    picture = render(shot, name, **settings)
    for rows in (1, 7, 1000):
        monkeypatch.setattr("metrics.kernels.launch.STRIP_ROWS", rows)
        alone = Shot(sequence, 2, shot.material, model_of(sequence), shot.samples, single)
        for again in (render(alone, name, **settings), render(shot, name, **settings)):
            assert np.array_equal(again.rgba, picture.rgba)
            assert (again.error is None) == (picture.error is None)
            if again.error is not None:
                assert np.array_equal(again.error, picture.error)


COUNTS = np.array([4, 16, 36, 64])
VIEWS = {
    "rough": ({"height": 15.0, "pitch": -40.0}, 1024, -0.5),
    "smooth": ({"height": 1.0, "pitch": -90.0, "fov": 20.0}, 4, -1.0),
}
"""Cameras, sides of maps of independent texels, and the rate at which the error falls with the number of samples.

A sample anywhere in each of n equal cells: where a cell holds many texels samples are independent, and the error falls
with n^-1/2. Where light is smooth over a cell it varies within it by n^-1/2 itself, and the error falls with n^-1
(Mitchell 1996, Consequences of Stratified Sampling in Graphics).
"""


@pytest.mark.parametrize("name", VIEWS)
def test_the_references_error_falls_at_its_rate(shoot, render, pack_maps, tolerance, name):
    camera, side, rate = VIEWS[name]
    maps = random_maps(0, side=side)
    maps[..., 6] = 0
    material = pack_maps(maps)
    sequence = road(camera=camera, profile={"width": 40.0, "length": 80.0}, size=(64, 36))
    reference = render(shoot(sequence, 0, material, samples=4096), "reference").rgba
    covered = reference[..., 3] == 1
    assert covered.mean() > 0.2
    errors, stated = [], []
    for count in COUNTS:
        picture = render(shoot(sequence.with_changes(seed=7), 0, material, samples=int(count)), "reference")
        errors.append(np.sqrt(np.mean((picture.rgba - reference)[covered] ** 2)))
        stated.append(np.sqrt(np.mean(picture.error[covered] ** 2)))
    for found in (errors, stated):
        slope = np.polyfit(np.log(COUNTS), np.log(found), 1)[0]
        assert slope == pytest.approx(rate, abs=tolerance("rate of convergence"))
