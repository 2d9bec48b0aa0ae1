"""Reflectance models in a scene: their parameters, and the map of twist that turns their tangent."""

import numpy as np
import OpenImageIO as oiio  # noqa: N813
import pytest

from sequences import SequenceError, brushed, library, load
from swimlab.render.catalogue import brdf_settings, technique_settings
from swimlab.render.material import MapError, read_maps
from swimlab.render.plan import Plan

SMALL = load("road-shift").with_changes(size=(48, 27))


def of(brdf, **parameters):
    """A small road of a reflectance model."""
    return SMALL.with_changes(scene={"material": {"brdf": brdf, "parameters": parameters}})


FLAT = {"albedo": [0.2] * 3, "normal": [0.0, 0.0, 1.0], "gloss": [0.1, 30.0]}
SIZE = (16, 16)


def save(path, pixels, kind=oiio.FLOAT):
    spec = oiio.ImageSpec(pixels.shape[1], pixels.shape[0], pixels.shape[2], kind)
    output = oiio.ImageOutput.create(str(path))
    assert output.open(str(path), spec), output.geterror()
    assert output.write_image(np.ascontiguousarray(pixels))
    assert output.close()


@pytest.fixture
def twisted_by(tmp_path):
    """A sequence of flat maps and a file of twist."""

    def twisted_by(pixels, kind=oiio.FLOAT):
        for key, values in FLAT.items():
            save(tmp_path / f"{key}.tif", np.broadcast_to(np.float32(values), (*SIZE, len(values))))
        save(tmp_path / "twist.tif", pixels, kind)
        names = "".join(f'{key} = "{key}.tif"\n' for key in (*FLAT, "twist"))
        (tmp_path / "own.toml").write_text(f'version = 1\nname = "own"\n[scene.material]\n{names}')
        return load(tmp_path / "own.toml")

    return twisted_by


@pytest.mark.parametrize("technique", ["pixel-aniso", "toksvig", "reference"])
@pytest.mark.parametrize("brdf", ["ashikhmin-shirley", "ashikhmin-shirley-factored"])
def test_a_quarter_turn_changes_the_axes_of_the_highlight(shoot, render, pack_maps, maps, tolerance, brdf, technique):
    # About tilted normals a turn of the twist is not a turn of the frame: tangents are upright projections.
    flat = np.concatenate(
        [maps[..., :3], np.broadcast_to(np.float32([0, 0, 1]), maps[..., :3].shape), maps[..., 6:]], 2
    )
    twist = np.broadcast_to(np.float32([0, 1]), (*maps.shape[:2], 2))
    long, short = (of(brdf, anisotropy=a) for a in (4.0, 0.25))
    turned = render(shoot(long, chain=pack_maps(np.concatenate([flat, twist], axis=2))), technique).rgba
    swapped, other = (render(shoot(sequence, chain=pack_maps(flat)), technique).rgba for sequence in (short, long))
    brightest = swapped.max()
    assert np.abs(turned - swapped).max() <= tolerance("turned tangent") * brightest
    assert np.abs(turned - other).max() > 0.05 * brightest


def test_a_twist_is_the_tangent_itself(twisted_by, tolerance):
    angle = np.random.default_rng(0).uniform(-4, 4, (*SIZE, 1)).astype(np.float32)
    vectors = np.concatenate([np.cos(angle), np.sin(angle)], axis=2)
    for pixels in (angle, vectors, np.concatenate([vectors, vectors], axis=2)):
        found = read_maps(twisted_by(pixels)).twist
        assert found.dtype == np.float32
        assert found == pytest.approx(vectors, abs=tolerance("weights in float32"))


def test_integer_twists_are_decoded(twisted_by, tolerance):
    quarter = np.full((*SIZE, 1), 64, np.uint8)
    angle = 2 * np.pi * 64 / 255
    found = read_maps(twisted_by(quarter, oiio.UINT8)).twist
    assert found[0, 0] == pytest.approx([np.cos(angle), np.sin(angle)], abs=tolerance("decoded 8 bit"))
    left = np.broadcast_to(np.uint8([0, 255]), (*SIZE, 2))
    assert read_maps(twisted_by(left, oiio.UINT8)).twist[0, 0] == pytest.approx([-1, 1], abs=tolerance("decoded 8 bit"))


def test_tangents_without_direction_are_refused(twisted_by):
    with pytest.raises(MapError, match=r"scene\.material\.twist: .*twist\.tif: has tangents of zero length"):
        read_maps(twisted_by(np.zeros((*SIZE, 2), np.float32)))


def test_a_twist_of_another_size_is_refused(twisted_by):
    with pytest.raises(MapError, match=r"differ in size \(.*twist 8x8\)"):
        read_maps(twisted_by(np.zeros((8, 8, 1), np.float32)))


def test_a_model_without_tangents_reads_no_twist(twisted_by):
    sequence = twisted_by(np.zeros((16, 16, 2), np.float32))
    assert read_maps(sequence, twisted=False).twist is None


def test_the_twists_bytes_are_in_the_settings_hash(twisted_by):
    one, other = (
        Plan(twisted_by(np.full((16, 16, 1), value, np.float32)), ("pixel-aniso",), (0,)).digest() for value in (0, 1)
    )
    assert one != other


def test_brushed_metal_tiles_and_never_turns_far_between_neighbours(tolerance):
    angle = brushed.make(3, 256)
    assert angle.shape == (256, 256)
    assert (angle == brushed.make(3, 256)).all()
    assert (angle != brushed.make(4, 256)).any()
    assert np.abs(angle - angle.mean(axis=1, keepdims=True)).max() > brushed.SWING / 2
    for axis in (0, 1):
        steps = np.abs(np.roll(angle, -1, axis) - angle)
        assert steps.max() < np.pi / 2
        assert steps.take(-1, axis).max() <= steps.max()
    made = read_maps(SMALL.with_changes(scene={"material": {"twist": "made:brushed"}})).twist
    turned = np.arctan2(made[..., 1], made[..., 0]) - brushed.make(SMALL.seed)
    assert np.abs(turned).max() <= tolerance("weights in float32")


@pytest.mark.parametrize(
    ("text", "key", "says"),
    [
        ('brdf = "ashikhmin-shirley"\nparameters = {anisotropy = 99}', "parameters.anisotropy", "16"),
        ('brdf = "ashikhmin-shirley"\nparameters = {anisotropi = 2}', "parameters.anisotropi", "'anisotropy'"),
        ('brdf = "lafortune"\nparameters = {lobes = []}', "parameters.lobes", "1 to 8"),
        ('brdf = "lafortune"\nparameters = {lobes = [{z = 2}]}', "parameters.lobes.0.z", "along the normal"),
        ('brdf = "lafortune"\nparameters = {lobes = [{zz = 1}]}', "parameters.lobes.0.zz", "did you mean 'z'"),
        ('parameters = {normalisation = "none"}', "parameters.normalisation", "'ndf'"),
        ('brdf = "cook-torrance"\nparameters = {m = 0.3}', "parameters.m", "unknown key"),
        ('brdf = "phong"', "brdf", "blinn-phong"),
        ('twist = "made:asphalt"', "twist", "made:brushed"),
    ],
)
def test_bad_parameters_are_named(tmp_path, text, key, says):
    path = tmp_path / "own.toml"
    path.write_text(f'version = 1\nname = "own"\n[scene.material]\n{text}\n')
    with pytest.raises(SequenceError) as error:
        load(path, brdfs=brdf_settings(), technique_settings=technique_settings())
    (problem,) = error.value.problems
    assert f"scene.material.{key}: " in problem
    assert says in problem


def test_the_librarys_models_are_known():
    for name in library():
        load(name, brdfs=brdf_settings())
