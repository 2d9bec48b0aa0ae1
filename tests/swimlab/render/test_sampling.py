"""Texture filters over packed mip chains."""

import numpy as np
import oracle
import pytest
import warp as wp
from hypothesis import given, settings
from hypothesis import strategies as st

from swimlab.render.kernels.sampling import anisotropic, bilinear, isotropic, point, trilinear
from swimlab.render.kernels.structs import Chain, Surface
from swimlab.render.texture import MipChain

FILTERS = ("point", "bilinear", "trilinear", "isotropic", "anisotropic")


@wp.kernel(enable_backward=False)
def read(
    which: wp.int32,
    texels: wp.array(dtype=wp.vec4),
    chain: Chain,
    uv: wp.array(dtype=wp.vec2d),
    dx: wp.array(dtype=wp.vec2d),
    dy: wp.array(dtype=wp.vec2d),
    lod: wp.array(dtype=wp.float32),
    most: wp.int32,
    out: wp.array(dtype=wp.vec4),
):
    i = wp.tid()
    surface = Surface()
    surface.uv = uv[i]
    surface.dx = dx[i]
    surface.dy = dy[i]
    if which == 0:
        out[i] = point(texels, chain, uv[i])
    elif which == 1:
        out[i] = bilinear(texels, chain, wp.int32(lod[i]), wp.vec2(uv[i]))
    elif which == 2:
        out[i] = trilinear(texels, chain, lod[i], wp.vec2(uv[i]))
    elif which == 3:
        out[i] = isotropic(texels, chain, surface)
    else:
        out[i] = anisotropic(texels, chain, surface, most)


@pytest.fixture(scope="module")
def chain_of(launcher):
    """A chain of an image [h, w, 4] or [h, w]."""

    def chain_of(image, clamps=False):
        image = np.asarray(image, np.float32)
        if image.ndim == 2:
            image = np.repeat(image[..., None], 4, axis=2)
        height, width = image.shape[:2]
        chain = MipChain.allocate(launcher, width=width, height=height, dtype=wp.vec4, clamps=clamps)
        chain.texels[: width * height].assign(image.reshape(-1, 4))
        chain.reduce(launcher)
        return chain

    return chain_of


@pytest.fixture(scope="module")
def sample(launcher):
    def sample(name, chain, uv, *, dx=(0.0, 0.0), dy=(0.0, 0.0), lod=0.0, most=16):
        uv = np.atleast_2d(uv)
        dx, dy = (np.ascontiguousarray(np.broadcast_to(each, uv.shape)) for each in (dx, dy))
        lods = np.ascontiguousarray(np.broadcast_to(np.float32(lod), len(uv)))
        out = launcher.empty(len(uv), wp.vec4)
        arrays = [launcher.array(each, wp.vec2d) for each in (uv, dx, dy)]
        inputs = [FILTERS.index(name), chain.texels, chain.shape, *arrays, launcher.array(lods, wp.float32), most, out]
        launcher.launch(read, len(uv), inputs)
        return out.numpy()

    return sample


def noise(height, width, seed=0):
    return np.random.default_rng(seed).random((height, width, 4)).astype(np.float32)


def level_of(chain, level):
    """A level of a chain as [h, w, 4]."""
    height, width = (max(side >> level, 1) for side in (chain.shape.height, chain.shape.width))
    first = chain.shape.offsets.numpy()[level]
    return chain.texels.numpy()[first : first + height * width].reshape(height, width, 4)


@pytest.mark.parametrize(("height", "width"), [(1, 1), (1, 16), (16, 1), (2, 8), (32, 32), (64, 4)])
def test_levels_are_means_of_four(chain_of, tolerance, height, width):
    image = noise(height, width)
    chain = chain_of(image)
    expected = oracle.mip_levels(image)
    assert chain.shape.levels == len(expected)
    assert len(chain.texels) == sum(level[..., 0].size for level in expected)
    for level, exact in enumerate(expected):
        assert level_of(chain, level) == pytest.approx(exact, abs=tolerance("mip in float32"))


def test_a_ramp_is_reproduced(chain_of, sample, tolerance):
    n = 32
    v, u = np.mgrid[:n, :n] / n + 0.5 / n
    chain = chain_of(np.stack([u, v, u + v, u - v], axis=-1), clamps=True)
    at = np.random.default_rng(1).uniform(0.5 / n, 1 - 0.5 / n, (200, 2))
    exact = np.stack([at[:, 0], at[:, 1], at.sum(axis=1), at[:, 0] - at[:, 1]], axis=-1)
    for name in ("bilinear", "trilinear"):
        assert sample(name, chain, at) == pytest.approx(exact, abs=tolerance("weights in float32"))


def test_texel_centres_are_exact(chain_of, sample):
    image = noise(16, 64)
    j, i = np.mgrid[:16, :64]
    centres = np.stack([(i + 0.5) / 64, (j + 0.5) / 16], axis=-1).reshape(-1, 2)
    for name in FILTERS:
        assert np.array_equal(sample(name, chain_of(image), centres), image.reshape(-1, 4))


@pytest.mark.parametrize("clamps", [False, True])
def test_a_whole_level_is_that_level(chain_of, sample, clamps):
    chain = chain_of(noise(16, 32), clamps)
    at = np.random.default_rng(2).uniform(-1, 2, (100, 2))
    for level in range(chain.shape.levels):
        plain = sample("bilinear", chain, at, lod=level)
        assert np.array_equal(sample("trilinear", chain, at, lod=level), plain)
        alone = chain_of(level_of(chain, level), clamps)
        assert np.array_equal(sample("bilinear", alone, at), plain)


def test_levels_beyond_the_chain_are_its_ends(chain_of, sample, tolerance):
    chain = chain_of(noise(8, 8))
    at = np.random.default_rng(3).random((20, 2))
    assert np.array_equal(sample("trilinear", chain, at, lod=-3.5), sample("bilinear", chain, at, lod=0))
    mean = np.broadcast_to(level_of(chain, 3)[0, 0], (20, 4))
    assert sample("trilinear", chain, at, lod=99) == pytest.approx(mean, abs=tolerance("weights in float32"))
    wide = {"dx": (1e6, 0.0), "dy": (0.0, 1e7)}
    for name in ("isotropic", "anisotropic"):
        assert sample(name, chain, at, **wide) == pytest.approx(mean, abs=tolerance("weights in float32"))
        assert np.array_equal(sample(name, chain, at), sample("bilinear", chain, at))


derivatives = st.tuples(st.floats(-2, 2), st.floats(-2, 2))


@settings(derandomize=True)
@given(
    name=st.sampled_from(FILTERS),
    uv=st.tuples(st.floats(-100, 100), st.floats(-100, 100)),
    dx=derivatives,
    dy=derivatives,
    clamps=st.booleans(),
)
def test_a_constant_stays_constant(chain_of, sample, tolerance, name, uv, dx, dy, clamps):
    found = sample(name, chain_of(np.full((8, 16), 0.7), clamps), uv, dx=dx, dy=dy, lod=1)
    assert found == pytest.approx(np.float32(0.7), rel=tolerance("weights in float32"))


@settings(derandomize=True)
@given(size=st.floats(-3, 5), turn=st.floats(0, 2 * np.pi))
def test_a_round_footprint_needs_one_probe(chain_of, sample, tolerance, size, turn):
    chain = chain_of(noise(32, 32))
    side = 2.0**size / 32
    at = np.random.default_rng(4).random((20, 2))
    dx, dy = side * np.array([np.cos(turn), np.sin(turn)]), side * np.array([-np.sin(turn), np.cos(turn)])
    found = sample("anisotropic", chain, at, dx=dx, dy=dy)
    assert found == pytest.approx(sample("trilinear", chain, at, lod=size), abs=tolerance("filter in float32"))
    assert found == pytest.approx(sample("isotropic", chain, at, dx=dx, dy=dy), abs=tolerance("filter in float32"))


def test_borders_repeat_or_clamp(chain_of, sample, tolerance):
    image = noise(8, 8)
    top = image[0, 3]
    across = [(3.5 / 8, 0.0), (3.5 / 8, 1.0)]
    between = (top + image[-1, 3]) / 2
    repeated = sample("bilinear", chain_of(image), across)
    assert repeated == pytest.approx(np.stack([between, between]), abs=tolerance("weights in float32"))
    clamped = sample("bilinear", chain_of(image, clamps=True), [*across, (3.5 / 8, -7.0), (3.5 / 8, 9.0)])
    assert np.array_equal(clamped, np.stack([top, image[-1, 3], top, image[-1, 3]]))


@settings(derandomize=True)
@given(
    texel=st.tuples(st.integers(-300, 300), st.integers(-300, 300)),
    within=st.tuples(st.floats(0, 0.999), st.floats(0, 0.999)),
)
def test_point_takes_the_texel_that_holds_the_place(chain_of, sample, texel, within):
    image = noise(8, 16)
    uv = (np.array(texel) + within) / (16, 8)
    assert np.array_equal(sample("point", chain_of(image), uv)[0], image[texel[1] % 8, texel[0] % 16])


@pytest.mark.parametrize("clamps", [False, True])
@pytest.mark.parametrize("most", [1, 4, 16])
def test_filters_follow_their_written_formulas(chain_of, sample, tolerance, clamps, most):
    image = noise(64, 32)
    chain, levels = chain_of(image, clamps), oracle.mip_levels(image)
    random = np.random.default_rng(5)
    count = 400
    uv = random.uniform(-1, 2, (count, 2))
    direction = random.uniform(0, 2 * np.pi, (count, 2))
    length = 2.0 ** random.uniform(-9, 0, (count, 2))
    dx, dy = (
        length[:, k, None] * np.stack([np.cos(direction[:, k]), np.sin(direction[:, k])], axis=-1) for k in (0, 1)
    )
    found = sample("anisotropic", chain, uv, dx=dx, dy=dy, most=most)
    exact = oracle.anisotropic(levels, uv, dx, dy, most, clamps)
    assert found == pytest.approx(exact, abs=tolerance("filter in float32"))
    longest = np.maximum(*(np.linalg.norm(each * (32, 64), axis=1) for each in (dx, dy)))
    found = sample("isotropic", chain, uv, dx=dx, dy=dy)
    assert found == pytest.approx(
        oracle.trilinear(levels, uv, np.log2(longest), clamps), abs=tolerance("filter in float32")
    )
