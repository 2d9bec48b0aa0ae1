"""All techniques against an independent double-precision renderer."""

import json
from functools import cache

import numpy as np
import OpenImageIO as oiio  # noqa: N813
import pytest
from oracle import MOMENTS, Oracle

from sequences import load
from swimlab.render.plan import Plan, load_sequence
from swimlab.render.run import render_run
from swimlab.runs.frames import frame_path, read_channels, read_frame

SIZE = (96, 54)
SHIFT = load("road-shift").with_changes(size=SIZE)
VIEWS = {
    "shift": (SHIFT, 3),
    "scale": (load("road-scale").with_changes(size=SIZE), 3),
    "drive": (load("road-drive").with_changes(size=SIZE), 5),
    "turned": (SHIFT.with_changes(camera={"yaw": 25.0, "pitch": -15.0, "lateral": 1.0, "distance": 13.7}), 2),
    "short": (SHIFT.with_changes(scene={"road": {"width": 6.0, "segment": 5.0, "length": 23.3}}), 0),
}
SETTINGS = {
    "pixel-point": [{}],
    "pixel-bilinear": [{}],
    "pixel-trilinear": [{}],
    "pixel-aniso": [{}, {"anisotropy": 3}],
    "lod-hack": [{}, {"start": 1.5, "end": 2.5, "anisotropy": 4}],
    "tsl": [{"size": 64}, {"size": 32, "anisotropy": 5}, *({"size": 32, "inputs": each} for each in MOMENTS)],
    "toksvig": [{}, {"anisotropy": 2}],
    "vmf": [{}],
    "clean": [{}],
    "lean": [{}, {"anisotropy": 2}],
    "specular-aa": [{}, {"variance": 0.4, "threshold": 0.1}],
    "supersample": [{}, {"samples": 9, "anisotropy": 4}],
}
CASES = [(view, name, given) for view in VIEWS for name, choices in SETTINGS.items() for given in choices]


def compare(hit, exact, rgba, name, tolerance, *, half=False):
    """Assert that a picture is the oracle's as closely as its technique allows."""
    assert np.array_equal(hit, rgba[..., 3] == 1)
    assert not rgba[rgba[..., 3] == 0].any()
    assert hit.any()
    error, exact = rgba[hit][:, :3] - exact[hit], exact[hit]
    limit = tolerance("half float" if half else "agreement with the oracle")
    if name == "pixel-point":
        least = tolerance("smallest half") if half else 0.0
        equal = np.abs(error) <= tolerance("equal to a pixel") * np.abs(exact) + least
        assert equal.all(axis=1).mean() >= tolerance("equal pixels")
    else:
        assert np.sqrt(np.mean(error**2) / np.mean(exact**2)) <= limit


@pytest.fixture(scope="module")
def oracle_of(maps):
    return cache(lambda view: Oracle(VIEWS[view][0], maps, VIEWS[view][1]))


@pytest.mark.parametrize(("view", "name", "given"), CASES)
def test_techniques_agree_with_the_oracle(shoot, render, oracle_of, tolerance, view, name, given):
    rgba = render(shoot(*VIEWS[view]), name, **given).rgba
    compare(*oracle_of(view).picture(name, **given), rgba, name, tolerance)


def test_the_views_tell_techniques_apart(oracle_of):
    """The comparison means something: no two techniques have the same picture."""
    pictures = [oracle_of("shift").picture(name, **choices[0])[1] for name, choices in SETTINGS.items()]
    for k, one in enumerate(pictures):
        for other in pictures[:k]:
            assert np.sqrt(np.mean((one - other) ** 2) / np.mean(one**2)) > 0.01


@pytest.mark.parametrize("view", ["shift", "drive"])
def test_the_reference_is_right_within_its_stated_error(shoot, render, oracle_of, tolerance, view):
    sequence, frame = VIEWS[view]
    picture = render(shoot(sequence, frame, samples=64), "reference")
    reference, reference_error = oracle_of(view).reference(16, seed=7)
    covered = picture.rgba[..., 3] == 1
    error = (picture.rgba[..., :3] - reference)[covered]
    stated = np.sqrt(np.mean(picture.error[covered][:, :3] ** 2))
    ratio = np.sqrt(np.mean(error**2)) / stated
    assert 1 / tolerance("reference against its stated error") < ratio < tolerance("reference against its stated error")
    variance = picture.error[covered][:, :3] ** 2 + reference_error[covered] ** 2
    # R, G and B share the highlight: their sum counts as one number a pixel.
    deviation = error.sum() / np.sqrt(3 * variance.sum())
    assert abs(deviation) < tolerance("mean of a picture")


def test_more_samples_halve_the_stated_error(shoot, render):
    def stated(samples):
        picture = render(shoot(*VIEWS["shift"], samples=samples), "reference")
        covered = picture.rgba[..., 3] == 1
        return np.sqrt(np.mean(picture.error[covered][:, :3] ** 2))

    # Sixteen times the samples: four times less by chance alone, still less where strata help.
    assert stated(16) / stated(256) > 3


@pytest.mark.parametrize("samples", [4, 9, 16, 25])
def test_uniform_light_has_no_stated_error(shoot, render, pack_maps, tolerance, samples):
    """Two halves of a pixel's samples have the same mean then, be their number even or odd."""
    flat = np.broadcast_to([0.2, 0.3, 0.4, 0.0, 0.0, 1.0, 0.0, 0.0], (16, 16, 8)).astype(np.float32)
    picture = render(shoot(SHIFT, 0, pack_maps(flat), samples=samples), "reference")
    covered = picture.rgba[..., 3] == 1
    assert covered.sum() > 1000
    assert np.abs(picture.error[covered]).max() <= tolerance("constant light")


def write_exr(path, pixels):
    output = oiio.ImageOutput.create("exr")
    assert output.open(str(path), oiio.ImageSpec(*pixels.shape[1::-1], pixels.shape[2], oiio.FLOAT))
    assert output.write_image(np.ascontiguousarray(pixels, np.float32))
    assert output.close()


@pytest.mark.parametrize("half", [False, True])
def test_frames_from_files_agree_with_the_oracle(tmp_path, maps, tolerance, half):
    for key, pixels in {"albedo": maps[..., :3], "normal": maps[..., 3:6], "gloss": maps[..., 6:]}.items():
        write_exr(tmp_path / f"{key}.exr", pixels)
    (tmp_path / "own.toml").write_text(
        f"""
        version = 1
        name = "own"
        frames = 3
        size = {json.dumps(SIZE)}
        [scene.material]
        albedo = "albedo.exr"
        normal = "normal.exr"
        gloss = "gloss.exr"
        [scene.sun]
        azimuth = -7.0
        elevation = 21.0
        diffuse = 0.9
        [camera]
        height = 1.7
        lateral = -0.6
        distance = 31.4
        yaw = 3.0
        [motion]
        kind = "drive"
        speed = 20.0
        [techniques.tsl]
        size = 64
        [techniques.lod-hack]
        end = 3.0
        """,
        encoding="utf-8",
    )
    sequence = load_sequence(str(tmp_path / "own.toml"))
    plan = Plan(sequence=sequence, techniques=(*SETTINGS, "reference"), frames=(2,), half=half)
    run = tmp_path / "run"
    record = render_run(plan, run, threads=2)
    oracle = Oracle(sequence, maps, 2)
    for name in SETTINGS:
        given = {"tsl": {"size": 64}, "lod-hack": {"end": 3.0}}.get(name, {})
        compare(*oracle.picture(name, **given), read_frame(frame_path(run, name, 2)), name, tolerance, half=half)
    reference, _ = oracle.reference(16, seed=3)
    rgba = read_frame(frame_path(run, "reference", 2))
    error = read_channels(frame_path(run, "error", 2), ("R", "G", "B", "A"))
    covered = rgba[..., 3] == 1
    stated = record.reference_rms_error["2"]
    assert stated == pytest.approx(np.sqrt(np.mean(error[covered][:, :3] ** 2)), rel=tolerance("half float"))
    ratio = np.sqrt(np.mean((rgba[..., :3] - reference)[covered] ** 2)) / stated
    assert ratio < tolerance("reference against its stated error")
