"""What a display makes of radiance: closed forms, bounds, and that measures see what is shown."""

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays

from metrics import Bloom, Clip, Display, measure, measure_scales
from metrics.display import encode, to_domain
from metrics.ocio import view_names

blooms = st.builds(Bloom, strength=st.floats(0, 1), threshold=st.floats(0, 10), radius=st.floats(1e-3, 1))
displays = st.builds(
    Display,
    exposure=st.floats(-20, 20),
    bloom=blooms,
    tone_map=st.sampled_from(["none", "reinhard", "aces"]),
    gamma=st.sampled_from(["srgb", "sqrt"]),
    bits=st.sampled_from([1, 8, 16]),
    dither=st.booleans(),
    seed=st.integers(0, 2**32 - 1),
) | st.builds(Display, exposure=st.floats(-20, 20), bloom=blooms, tone_map=st.sampled_from(["none", "aces"]))
radiances = arrays(
    np.float64,
    st.tuples(st.just(3), st.integers(1, 9), st.integers(1, 9)),
    elements=st.floats(0, 1.7e308) | st.sampled_from([0.0, 1.0, 7.25, 1e30]),
)


@pytest.fixture(scope="module")
def bright():
    """A frame [3, 24, 40] of radiance from 0 to 8, most of it dark."""
    return 8 * np.random.default_rng(0).random((3, 24, 40)) ** 4


def test_as_it_stands_a_display_shows_srgb_codes(bright):
    assert np.array_equal(Display().show(bright), encode(bright))
    assert np.array_equal(to_domain(bright, "display"), encode(bright))
    assert to_domain(bright, "linear", Display(gamma="sqrt")) is bright


def test_a_stop_doubles_radiance(bright):
    assert np.array_equal(Display(exposure=1).show(bright), Display().show(2 * bright))


def test_tone_maps_and_gamma_have_their_closed_forms(tolerance):
    x = np.array([0.0, 0.18, 1.0, 3.0, 7.0])
    shown = {name: Display(tone_map=name, gamma="sqrt").curve(x) ** 2 for name in ("none", "reinhard", "aces")}
    assert shown["none"] == pytest.approx(np.minimum(x, 1), abs=tolerance("closed form"))
    assert shown["reinhard"] == pytest.approx(x / (1 + x), abs=tolerance("closed form"))
    fit = x * (2.51 * x + 0.03) / (x * (2.43 * x + 0.59) + 0.14)
    assert shown["aces"] == pytest.approx(fit, abs=tolerance("closed form"))
    assert shown["aces"][2] == pytest.approx(2.54 / 3.16, abs=tolerance("closed form"))
    assert Display(tone_map="reinhard").curve(x) == pytest.approx(encode(x / (1 + x)), abs=tolerance("closed form"))


@settings(derandomize=True, max_examples=60)
@given(display=displays, radiance=radiances, frame=st.integers(0, 10**6))
def test_codes_of_any_radiance_lie_in_0_to_1(display, radiance, frame):
    for codes in (display.show(radiance, frame), display.curve(radiance)):
        assert np.all((codes >= 0) & (codes <= 1))
    assert np.array_equal(display.show(radiance, frame), display.show(radiance, frame))


@settings(derandomize=True, max_examples=60)
@given(display=displays, radiance=arrays(np.float64, 20, elements=st.floats(0, 1e30)))
def test_more_light_never_gives_a_lower_code(display, radiance):
    codes = display.curve(np.sort(radiance))
    # The two pieces of sRGB's curve, as the standard rounds them, miss each other by 1e-8.
    assert np.all(np.diff(codes) >= -1e-7)


@settings(derandomize=True, max_examples=60)
@given(bloom=blooms, level=st.floats(0, 1e3), height=st.integers(1, 40), width=st.integers(1, 40))
def test_a_constant_picture_stays_constant_under_bloom(bloom, level, height, width, tolerance):
    light = np.full((3, height, width), level)
    assert bloom.spread(light) == pytest.approx(light, rel=tolerance("closed form"), abs=tolerance("closed form"))


@pytest.mark.parametrize("place", [(60, 63), (61, 64)])
def test_bloom_loses_no_light_inside_the_picture_and_has_the_width_of_its_levels(place, tolerance):
    light = np.zeros((1, 121, 131))
    light[0, *place] = 50.0
    levels = 3
    bloom = Bloom(strength=1.0, threshold=0.0, radius=np.sqrt(2 / 3) * 2**levels / light.shape[1])
    found = bloom.spread(light)[0]
    assert found.sum() == pytest.approx(50.0, rel=tolerance("closed form"))
    columns = np.arange(found.shape[1]) - place[1]
    assert (found * columns).sum() == pytest.approx(0, abs=tolerance("rounding"))
    # Level n of a pyramid with the weights 1 4 6 4 1 has the variance 2/3 (4^n - 1); the glow is their mean.
    variance = np.mean([2 / 3 * (4**n - 1) for n in range(levels + 1)])
    assert (found * columns**2).sum() / 50 == pytest.approx(variance, rel=tolerance("closed form"))


def test_half_of_the_light_above_the_threshold_is_spread(tolerance):
    light = np.zeros((1, 64, 64))
    light[0, 32, 32] = 5.0
    whole, half = (Bloom(strength=s, threshold=1.0, radius=0.1).spread(light) for s in (1.0, 0.5))
    assert half == pytest.approx((light + whole) / 2, abs=tolerance("closed form"))
    assert whole.sum() == pytest.approx(5.0, rel=tolerance("closed form"))
    dark = light / 5
    assert np.array_equal(Bloom(strength=1.0, threshold=1.0).spread(dark), dark)


def test_bloom_does_not_jump_where_the_radius_passes_an_octave(bright, tolerance):
    octave = np.sqrt(2 / 3) * 4 / bright.shape[1]
    below, above = (Bloom(1.0, 0.0, octave * (1 + side * 1e-9)).spread(bright) for side in (-1, 1))
    assert below == pytest.approx(above, abs=tolerance("bloom at an octave"))


def test_a_picture_of_twice_the_size_blooms_alike(tolerance):
    y, x = np.mgrid[:192, :192] / 192
    blob = 4 * np.exp(-((x - 0.5) ** 2 + (y - 0.4) ** 2) / 0.01)[None]
    bloom = Bloom(strength=1.0, threshold=1.0, radius=0.06)
    large = bloom.spread(blob)[0].reshape(96, 2, 96, 2).mean(axis=(1, 3))
    small = bloom.spread(blob.reshape(1, 96, 2, 96, 2).mean(axis=(2, 4)))[0]
    assert np.abs(small - large).max() < tolerance("bloom at another size") * blob.max()


@settings(derandomize=True, max_examples=30)
@given(light=arrays(np.float64, (3, 4, 5), elements=st.floats(0, 1)), bits=st.integers(1, 16))
def test_quantisation_is_off_by_half_a_step_at_most_and_dither_by_one(light, bits, tolerance):
    exact, steps = Display().show(light), 2**bits - 1
    for dither, bound in ((False, 0.5), (True, 1.0)):
        codes = Display(bits=bits, dither=dither).show(light) * steps
        assert codes == pytest.approx(np.rint(codes), abs=tolerance("rounding"))
        assert np.all(np.abs(codes - exact * steps) <= bound + tolerance("rounding"))


def test_dither_is_right_on_the_mean_and_leaves_black_and_white_alone(tolerance):
    radiance = np.broadcast_to(np.linspace(0, 1, 64), (3, 16, 64))
    display = Display(gamma="sqrt", bits=4, dither=True, seed=7)
    frames, steps = 200, 15
    mean = np.mean([display.show(radiance, t) for t in range(frames)], axis=0)
    errors = (mean - np.sqrt(radiance)) * steps
    # A code that is dithered has a variance of 1/4 step^2 at most.
    assert np.abs(errors.mean(axis=(0, 1))).max() < tolerance("mean of dither") * 0.5 / np.sqrt(3 * 16 * frames)
    assert np.abs(errors.mean(axis=0)).max() > 0
    assert np.all(mean[..., 0] == 0)
    assert np.all(mean[..., -1] == 1)
    plain = replace(display, dither=False).show(radiance)
    assert np.abs((plain - np.sqrt(radiance)).mean(axis=(0, 1))).max() * steps > 0.4


def test_dither_differs_by_channel_frame_and_seed_only():
    grey = np.full((3, 8, 8), 0.4)
    display = Display(bits=2, dither=True)
    first = display.show(grey, 0)
    assert not np.array_equal(first[0], first[1])
    assert not np.array_equal(first, display.show(grey, 1))
    assert not np.array_equal(first, replace(display, seed=1).show(grey, 0))
    assert np.array_equal(first, Display(bits=2, dither=True).show(grey, 0))


SRGB_SCREEN = "sRGB - Display/"


def test_a_view_that_maps_no_tones_is_the_curve_of_its_display(tolerance):
    light = np.random.default_rng(0).random((3, 8, 10)) * 1.5
    shown = Display(view=SRGB_SCREEN + "Un-tone-mapped").show(light)
    assert np.abs(shown - encode(light)).max() < tolerance("code of a view")
    raw = Display(view=SRGB_SCREEN + "Raw", exposure=-1)
    assert np.abs(raw.show(light) - light / 2).max() < tolerance("code of a view")


def test_aces_shows_mid_grey_as_a_tenth_of_white(tolerance):
    """ACES 2.0: .18 becomes 10 of 100 cd/m^2; grey stays grey, more light never gets darker, all of it fits."""
    display = Display(view=SRGB_SCREEN + "ACES 2.0 - SDR 100 nits (Rec.709)")
    assert display.curve(np.full((1, 3), 0.18)) == pytest.approx(float(encode(np.array(0.1))), abs=tolerance("ACES"))
    stops = 2.0 ** np.arange(-10, 30, 0.5)[:, None]
    codes = display.curve(stops)
    assert codes.shape == (80, 3)
    assert np.abs(np.diff(codes, axis=1)).max() < tolerance("ACES")
    assert (np.diff(codes[:, 0]) > -tolerance("ACES")).all()
    assert (codes >= 0).all()
    assert (codes <= 1).all()


def test_a_view_of_every_display_shows_all_radiance_as_codes():
    random = np.random.default_rng(2)
    light = 10.0 ** random.uniform(-8, 30, (3, 16, 16)) * random.choice([-1, 0, 1], (3, 16, 16), p=[0.1, 0.1, 0.8])
    of_each = {name.partition("/")[0]: name for name in reversed(view_names())}
    for name in of_each.values():
        shown = Display(view=name).show(light)
        assert ((shown >= 0) & (shown <= 1)).all()
        assert np.array_equal(np.moveaxis(Display(view=name).curve(np.moveaxis(light, 0, -1)), -1, 0), shown)


def test_exposure_bloom_and_quantisation_stand_around_a_view():
    light = 4 * np.random.default_rng(3).random((3, 16, 16))
    view = SRGB_SCREEN + "Un-tone-mapped"
    bloom = Bloom(strength=0.5, threshold=0.5)
    before = Display(view=SRGB_SCREEN + "Raw", bloom=bloom, exposure=-4).show(light)
    assert np.array_equal(
        np.round(Display(view=view, bloom=bloom, exposure=-4, bits=4).show(light) * 15),
        np.round(np.floor(Display(view=view).show(before) * 15 + 0.5)),
    )


@pytest.mark.parametrize(
    ("given", "message"),
    [
        ({"view": "sRGB/none"}, "no DISPLAY/VIEW 'sRGB/none'; "),
        ({"view": SRGB_SCREEN + "Raw", "tone_map": "aces"}, "leave out tone_map and gamma"),
        ({"view": SRGB_SCREEN + "Raw", "gamma": "sqrt"}, "leave out tone_map and gamma"),
        ({"tone_map": "filmic"}, "none, reinhard, aces"),
        ({"gamma": "2.2"}, "srgb, sqrt"),
        ({"exposure": float("nan")}, "stops"),
        ({"bits": 0}, "1 to 16"),
        ({"dither": True}, "give bits"),
    ],
)
def test_a_display_that_cannot_be_is_refused(given, message):
    with pytest.raises(ValueError, match=message):
        Display(**given)


@pytest.mark.parametrize("given", [{"strength": 1.1}, {"threshold": -1.0}, {"radius": 0.0}, {"radius": float("nan")}])
def test_a_bloom_that_cannot_be_is_refused(given):
    with pytest.raises(ValueError, match="strength lies in"):
        Bloom(**given)


DISPLAY = Display(exposure=0.5, bloom=Bloom(0.7, 0.5, 0.1), tone_map="reinhard", gamma="sqrt", bits=6, dither=True)


@pytest.fixture(scope="module")
def clips():
    """Test, reference and half-difference of 6 frames [32, 40, 3] of radiance from 0 to 4."""
    random = np.random.default_rng(1)
    reference = 4 * random.random((6, 32, 40, 3)) ** 2
    return reference + 0.1 * random.standard_normal(reference.shape), reference, 0.05 * random.random(reference.shape)


def shown(frames):
    """Frames [T, H, W, 3] as DISPLAY shows them."""
    return np.array([np.moveaxis(DISPLAY.show(np.moveaxis(f, 2, 0), t), 0, 2) for t, f in enumerate(frames)])


def test_measures_see_what_is_shown(clips, tolerance):
    test, reference, half = clips
    halves = (shown(reference + half) - shown(reference - half)) / 2

    def scores(frames, exact, error, **options):
        options |= {"reference_error": error.__getitem__, "names": ["budget", "residual"]}
        return measure(Clip(frames.__getitem__, 6), Clip(exact.__getitem__, 6), **options).scores

    expected = scores(shown(test), shown(reference), halves)
    found = scores(test, reference, half, domain="display", display=DISPLAY)
    assert found == pytest.approx(expected, rel=tolerance("closed form"))
    assert scores(test, reference, half, display=DISPLAY) == scores(test, reference, half)


def test_scales_are_compared_as_shown(clips, tolerance):
    pictures = [clips[0][0], clips[0][1][::2, ::2]]
    seen = [np.moveaxis(DISPLAY.show(np.moveaxis(p, 2, 0), t), 0, 2) for t, p in enumerate(pictures)]

    def scores(pictures, **options):
        clips = [Clip(lambda _, p=p: p, 1) for p in pictures]
        return measure_scales(clips, None, [1, 0.5], **options).scores

    assert scores(pictures, domain="display", display=DISPLAY) == pytest.approx(
        scores(seen), rel=tolerance("closed form")
    )
