"""Every reflectance model against its formula in double precision, and at the ends of its inputs."""

import numpy as np
import pytest
import reflectance
from evaluation import evaluated
from hypothesis import example, given, settings
from hypothesis import strategies as st
from oracle import unit

from swimlab.render.catalogue import brdfs

OFF_SPECULAR = [{"x": -0.9, "y": -0.7, "z": 0.8, "exponent": 0.5}, {"x": 0.5, "y": 0.5, "z": 1.0, "exponent": 0.1}]
FORMS = [
    ("blinn-phong", {}),
    ("blinn-phong", {"normalisation": "ndf"}),
    ("blinn-phong", {"normalisation": "energy"}),
    ("banks", {}),
    ("banks", {"normalisation": "energy", "exponent": 0.25}),
    ("ashikhmin-shirley", {}),
    ("ashikhmin-shirley", {"anisotropy": 4.0}),
    ("lafortune", {}),
    ("lafortune", {"lobes": OFF_SPECULAR, "normalisation": "energy"}),
    ("cook-torrance", {}),
]
FACTORED = [
    ("blinn-phong", {"normalisation": "ndf"}),
    ("blinn-phong", {"normalisation": "energy"}),
    ("banks", {}),
    ("ashikhmin-shirley", {}),
    ("ashikhmin-shirley", {"anisotropy": 4.0}),
]
RECIPROCAL = [form for form in FORMS if form[0] in {"ashikhmin-shirley", "lafortune", "cook-torrance"}]
POWERS = [0.0, 0.5, 1.0, 10.0, 100.0, 1e3, 1e4, 1e5]


def exact(name, parameters, *args):
    if "lobes" in parameters:
        parameters = parameters | {
            "lobes": [(lobe["x"], lobe["y"], lobe["z"], lobe["exponent"]) for lobe in parameters["lobes"]]
        }
    return getattr(reflectance, name.replace("-", "_"))(*args, **parameters)


def about_highlights(power, count=4000, *, seed=0, lowest=0.05):
    """Directions to light and eye, rounded to float32, whose half vectors lie as a lobe of the power spreads them."""
    rng = np.random.default_rng(seed)
    light = unit(rng.normal(size=(4 * count, 3)) * [1, 1, 0.7])
    half = unit(np.concatenate([rng.normal(size=(4 * count, 2)) / np.sqrt(power + 1), np.ones((4 * count, 1))], axis=1))
    view = 2 * (half * light).sum(axis=1, keepdims=True) * half - light
    above = (light[:, 2] > lowest) & (view[:, 2] > lowest)
    return tuple(each[above][:count].astype(np.float32) for each in (light, view))


def across_strands(power, count=4000, *, seed=0):
    """As above for Banks, whose highlight is where L.T = -V.T."""
    rng = np.random.default_rng(seed)
    light, view = (unit(rng.normal(size=(count, 3)) * [1, 1, 0.7] + [0, 0, 0.5]) for _ in range(2))
    along = np.clip(-light[:, 0] + rng.normal(size=count) / np.sqrt(power + 1), -1, 1)
    view[:, 1:] *= (np.sqrt(1 - along**2) / np.linalg.norm(view[:, 1:], axis=1))[:, None]
    view[:, 0] = along
    return light.astype(np.float32), view.astype(np.float32)


def test_every_model_has_its_formula_here():
    assert {name for name, _ in FORMS} | {f"{name}-factored" for name, _ in FACTORED} == set(brdfs())


@pytest.mark.parametrize("power", POWERS)
@pytest.mark.parametrize(("name", "parameters"), FORMS)
def test_float32_is_the_formula_in_double(launcher, tolerance, name, parameters, power):
    light, view = across_strands(power) if name == "banks" else about_highlights(power)
    assert len(light) > 1000
    found = evaluated(launcher, name, light, view, power=power, ks=0.3, albedo=0.2, diffuse=0.6, **parameters)
    doubles = (unit(light.astype(np.float64)), unit(view.astype(np.float64)))
    expected = exact(name, parameters, 0.2, 0.3, power, *doubles, 0.6)
    # An error in proportion to the peak, or to the value where that is far above, as where light and eye both graze.
    scale = np.maximum(expected, np.median(expected))
    assert (np.abs(found - expected) / scale).max() <= tolerance("reflectance in float32")


@pytest.mark.parametrize("power", POWERS)
@pytest.mark.parametrize(("name", "parameters"), FACTORED)
def test_tables_are_close(launcher, tolerance, name, parameters, power):
    light, view = across_strands(power) if name == "banks" else about_highlights(power)
    given = {"power": power, "ks": 0.3, **parameters}
    direct, factored = (evaluated(launcher, each, light, view, **given) for each in (name, f"{name}-factored"))
    difference = factored - direct
    rms = np.sqrt(np.mean(difference**2) / np.mean(direct**2))
    largest = (np.abs(difference) / np.maximum(direct, np.median(direct))).max()
    if power < parameters.get("anisotropy", 1):
        assert rms <= tolerance("table of a root")
    else:
        assert rms <= tolerance("table, rms")
        assert largest <= tolerance("table, largest")
    assert difference.any() or power == 0, "the table is not used"


@pytest.mark.parametrize("power", [0.0, 10.0, 1e3, 1e5])
@pytest.mark.parametrize(("name", "parameters"), RECIPROCAL)
def test_light_and_eye_may_change_places(launcher, tolerance, name, parameters, power):
    light, view = about_highlights(power, lowest=0.01)
    there, back = (
        evaluated(launcher, name, a, b, power=power, ks=0.3, **parameters) / (np.pi * a[:, 2])
        for a, b in ((light, view), (view, light))
    )
    assert there.any()
    assert there == pytest.approx(back, rel=tolerance("reciprocity"), abs=tolerance("reciprocity"))


@pytest.mark.parametrize(("name", "parameters"), FORMS)
def test_only_anisotropic_models_see_the_frame_turn(launcher, tolerance, name, parameters):
    brdf = brdfs()[name]
    light, view = about_highlights(50.0)
    angle = np.random.default_rng(1).uniform(0, 2 * np.pi, len(light))
    cosine, sine = np.cos(angle), np.sin(angle)
    turned = [
        np.stack([cosine * d[:, 0] - sine * d[:, 1], sine * d[:, 0] + cosine * d[:, 1], d[:, 2]], axis=1)
        for d in (light, view)
    ]
    still, moved = (evaluated(launcher, name, *pair, power=50, **parameters) for pair in ((light, view), turned))
    change = np.abs(moved - still).max() / still.max()
    if brdf.model(brdf.settings(**parameters)).anisotropic:
        assert change > 0.01
    else:
        assert change <= tolerance("reflectance in float32")


directions = st.one_of(
    st.sampled_from([(0, 0, 1), (1, 0, 0), (-1, 0, 0), (0, 1, 0), (0, 0, -1), (0.6, 0, 0.8), (-0.6, 0, 0.8)]),
    st.tuples(*[st.floats(-1, 1)] * 3).filter(lambda d: sum(c * c for c in d) > 1e-6),
)


@pytest.mark.parametrize("name", brdfs())
@settings(derandomize=True, max_examples=150)
@given(
    light=directions,
    view=directions,
    power=st.one_of(st.sampled_from([0.0, 1e-4, 1.0, 1e5]), st.floats(0, 1e5)),
    ks=st.floats(0, 1),
    mirrored=st.sampled_from([0, 1, -1]),
)
@example(light=(0.0, 1.0, 1e-40), view=(0, 0, 1), power=0.0, ks=0.0, mirrored=1)  # both in the horizon
def test_radiance_is_finite_and_never_negative(launcher, name, light, view, power, ks, mirrored):
    light = unit(np.array(light, float))
    # The mirror's direction has H = N exactly; the opposite one has no half vector.
    views = {0: unit(np.array(view, float)), 1: light * [-1, -1, 1], -1: -light}
    found = evaluated(launcher, name, light, views[mirrored], power=power, ks=ks, albedo=0.5)
    assert np.isfinite(found).all()
    assert (found >= 0).all()


MIRROR = {
    "blinn-phong": lambda p, nl: p,
    "banks": lambda p, nl: nl,
    "ashikhmin-shirley": lambda p, nl: (p + 1) / (8 * nl),
    "lafortune": lambda p, nl: np.pi * nl,
    "cook-torrance": lambda p, nl: (p + 2) / (8 * nl),
}


@pytest.mark.parametrize("power", [0.0, 1.0, 1e5])
@pytest.mark.parametrize("name", brdfs())
def test_where_the_half_vector_is_the_normal(launcher, tolerance, name, power):
    """Ks 1, so that F is 1; the strands run across the plane of light and eye, and H.V = N.L."""
    elevation = np.array([np.pi / 2, 1.0, 0.5, 0.02])
    light = np.stack([0 * elevation, np.cos(elevation), np.sin(elevation)], axis=1)
    found = evaluated(launcher, name, light, light * [1, -1, 1], power=power)
    expected = MIRROR[name.removesuffix("-factored")](power, np.sin(elevation))
    assert found == pytest.approx(expected, rel=tolerance("peak of a lobe"))


@pytest.mark.parametrize("power", [0.0, 1.0, 100.0, 1e5])
@pytest.mark.parametrize("name", brdfs())
def test_light_at_the_horizon_leaves_only_the_decks_highlight(launcher, name, power):
    light = unit(np.array([[0.0, 1.0, 0.0], [0.6, 0.8, -0.1], [-1.0, 0.0, -1e-7]]))
    found = evaluated(launcher, name, light, unit(np.array([0.1, -0.5, 0.6])), power=power, albedo=0.5)
    assert (found == 0).all() or name.startswith("blinn-phong")


def test_the_anisotropic_highlight_is_longer_along_the_tangent(launcher):
    tilt = np.linspace(-0.5, 0.5, 11)
    along = unit(np.stack([tilt, 0 * tilt, 1 + 0 * tilt], axis=1))
    across = along[:, [1, 0, 2]]
    for name in ("ashikhmin-shirley", "ashikhmin-shirley-factored"):
        wide, narrow = (evaluated(launcher, name, d, d, power=100, anisotropy=4.0) for d in (along, across))
        assert (wide[tilt != 0] > 2 * narrow[tilt != 0]).all()
