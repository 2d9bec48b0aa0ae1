"""Windows, lattices and the surface-locked transform."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from metrics.clip import Clip
from metrics.kernels.launch import Launcher
from metrics.parts import pieces
from metrics.spans import align
from metrics.spectra import Batch, Course, Pictures, transforms
from metrics.tiles import SIZES, lay, split, window
from metrics.transform import TileTransform, energy


def batches(span, t, pictures):
    """All tiles of frame t, piece by piece."""
    course, transform = Course(span, has_reference=pictures.error is not None), transforms(span, t)
    for number, piece in enumerate(pieces(span)):
        yield Batch(t, piece.level, number, piece.tiles, pictures, transform[piece.level], course)


@pytest.mark.parametrize("size", [size for size in SIZES if size >= 32])
@given(shift=st.floats(-0.5, 0.5))
def test_squared_windows_at_half_overlap_sum_to_one(size, shift, tolerance):
    squared = window(size, shift) ** 2
    # The half-pixel shift leaves one more pixel to the neighbour: extend the lattice by evaluating it shifted.
    neighbours = sum(window(size, shift + step * size // 2) ** 2 for step in (-1, 1))
    assert squared + neighbours == pytest.approx(np.ones(size), abs=tolerance("rounding"))


@given(st.floats(-100, 100), st.floats(-100, 100))
def test_an_offset_splits_in_whole_pixels_and_at_most_half_a_pixel(y, x):
    whole, rest = split((y, x))
    assert (whole[0] + rest[0], whole[1] + rest[1]) == pytest.approx((y, x))
    assert max(map(abs, rest)) <= 0.5


def test_tiles_stay_inside_and_covered_in_every_frame():
    offsets = [(0.6 * t, -0.9 * t) for t in range(20)]
    random = np.random.default_rng(4)
    masks = [np.ones((120, 200), dtype=bool) for _ in offsets]
    for mask in masks:
        mask[: random.integers(5, 15)] = False
        mask[60:70, 20:30] = False
    levels, weight = lay((120, 200), offsets, masks.__getitem__)
    assert [level.size for level in levels] == list(SIZES)
    for offset, mask in zip(offsets, masks, strict=True):
        down, right = split(offset)[0]
        for level in levels:
            for y, x in level.origin + np.array([down, right]):
                assert min(y, x) >= 0
                assert mask[y : y + level.size, x : x + level.size].sum() == level.size**2
    assert weight.max() <= 2
    summed = np.zeros_like(weight)
    for level in levels:
        profile = window(level.size, 0.0) ** 2
        for y, x in level.origin:
            summed[y : y + level.size, x : x + level.size] += np.outer(profile, profile)
    assert np.array_equal(weight, summed)


def test_the_mean_of_tiles_is_that_of_their_pixels_under_the_window(tolerance):
    levels, _ = lay((90, 140), [(0.0, 0.0)], lambda _: None)
    planes = np.random.default_rng(5).random((2, 90, 140), np.float32)
    for level in levels:
        square = np.outer(*[window(level.size, 0.0) ** 2] * 2)
        with Launcher(threads=2) as launcher:
            found = TileTransform(level, (0.0, 0.0)).power_mean(planes, launcher)
        for (y, x), mean in zip(level.origin, found, strict=True):
            block = planes[:, y : y + level.size, x : x + level.size]
            assert mean == pytest.approx((block * square).sum(axis=(1, 2)) / square.sum(), rel=tolerance("single sums"))


def test_small_tiles_are_laid_only_where_no_larger_one_could_stand():
    levels, _ = lay((100, 150), [(0.0, 0.0)], lambda _: None)
    assert [level.size for level in levels] == [64]
    levels, _ = lay((40, 150), [(0.0, 0.0)], lambda _: None)
    assert [level.size for level in levels] == [32]
    levels, weight = lay((15, 150), [(0.0, 0.0)], lambda _: None)
    assert levels == []
    assert not weight.any()


@settings(max_examples=20)
@given(seed=st.integers(0, 2**32 - 1), dx=st.floats(-3, 3), dy=st.floats(-3, 3))
def test_spectra_keep_the_energy_of_the_windowed_pixels(seed, dx, dy, tolerance):
    random = np.random.default_rng(seed)
    pictures = random.standard_normal((3, 3, 80, 90), dtype=np.float32)
    clip = Clip(lambda t: np.moveaxis(pictures[t], 0, 2), 3, motion=(dx, dy))
    (span,) = align(clip).spans
    for t in range(3):
        for batch in batches(span, t, Pictures(pictures[t], pictures[t])):
            blocks = batch.transform.blocks(pictures[t], batch.tiles).astype(np.float64)
            assert energy(batch.error) == pytest.approx(
                np.square(blocks).sum(axis=(1, 2, 3)), rel=tolerance("parseval")
            )


def test_a_glued_pattern_has_the_same_spectrum_in_every_frame(texture, centres, tolerance):
    pattern, (x, y) = texture(7), centres(100, 100)
    frames = [np.moveaxis(pattern.at(x - 0.37 * t, y - 0.61 * t), 2, 0).copy() for t in range(2)]
    frames = [frame.astype(np.float32) for frame in frames]
    (span,) = align(Clip(lambda t: np.moveaxis(frames[t], 0, 2), 2, motion=(0.37, 0.61))).spans
    first, second = (next(batches(span, t, Pictures(frames[t]))).test for t in range(2))
    assert energy(second - first).sum() < tolerance("glued") * energy(first).sum()
