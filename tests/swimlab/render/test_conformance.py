"""What every technique and every reflectance model has to keep to, and how they are found."""

import sys
from pathlib import Path

import numpy as np
import pytest
from pydantic import ValidationError

from metrics.plugins import discover
from sequences import load
from swimlab import render
from swimlab.render.catalogue import brdfs, technique_settings, techniques

FIRST = {"pixel-point", "pixel-bilinear", "pixel-trilinear", "pixel-aniso", "lod-hack", "tsl", "reference"}
LATER = {"vertex", "toksvig", "lean", "clean", "vmf", "specular-aa", "supersample", "taa"}
VIEWS = {
    "shift": (load("road-shift").with_changes(size=(48, 27)), 3),
    "scale": (load("road-scale").with_changes(size=(48, 27)), 6),
    "drive": (load("road-drive").with_changes(size=(48, 27), camera={"distance": 1e6, "yaw": -40.0}), 7),
    "down": (load("road-shift").with_changes(size=(48, 27), camera={"pitch": -90.0, "height": 0.05}), 0),
}


@pytest.mark.parametrize("view", VIEWS)
@pytest.mark.parametrize("name", techniques())
def test_pictures_are_sound(shoot, render, name, view):
    check_soundness(shoot(*VIEWS[view]), render, name)


@pytest.mark.parametrize("name", ["pixel-aniso", "toksvig"])
@pytest.mark.parametrize("brdf", brdfs())
def test_models_give_sound_pictures(shoot, render, name, brdf):
    sequence, frame = VIEWS["drive"]
    scene = sequence.scene.model_dump() | {"material": {"brdf": brdf}}
    check_soundness(shoot(sequence.with_changes(scene=scene), frame), render, name)


def check_soundness(shot, render, name):
    given = {"size": 64} if name == "tsl" else {}
    picture, again = (render(shot, name, **given) for _ in range(2))
    rgba = picture.rgba
    assert rgba.shape == (shot.view.height, shot.view.width, 4)
    assert rgba.dtype == np.float32
    assert np.isfinite(rgba).all()
    assert rgba.min() >= 0
    assert rgba[..., 3].max() == 1
    assert not rgba[rgba[..., 3] == 0].any()
    assert rgba[..., :3].max() > 0
    assert rgba.tobytes() == again.rgba.tobytes()
    if picture.error is not None:
        assert picture.error.shape == rgba.shape
        assert np.isfinite(picture.error).all()


@pytest.mark.parametrize("name", techniques())
def test_techniques_describe_themselves(name):
    technique = techniques()[name]
    assert technique.name == name
    assert technique.summary
    assert technique.source
    fields = technique.settings.model_fields
    assert all(field.description and not field.is_required() for field in fields.values())
    assert technique_settings()[name] is technique.settings


@pytest.mark.parametrize("name", techniques())
def test_unknown_settings_are_refused(name):
    with pytest.raises(ValidationError, match="nonsense"):
        techniques()[name].settings(nonsense=1)


def test_names_are_the_contracts():
    assert FIRST <= set(techniques()) <= FIRST | LATER
    assert "blinn-phong" in brdfs()


@pytest.mark.parametrize("name", brdfs())
def test_reflectance_models_describe_themselves(name):
    assert brdfs()[name].name == name
    assert brdfs()[name].summary
    assert brdfs()[name].source


@pytest.mark.parametrize(("package", "found"), [(render.techniques, techniques()), (render.brdfs, brdfs())])
def test_a_file_is_an_entry(package, found):
    files = {path.stem for path in Path(package.__path__[0]).glob("[a-z]*.py")}
    assert {name.replace("-", "_") for name in found} == files


@pytest.fixture
def package_of(tmp_path, monkeypatch):
    """A package of one-line modules."""

    def package_of(name, **modules):
        folder = tmp_path / name
        folder.mkdir()
        (folder / "__init__.py").write_text("")
        for module, line in modules.items():
            (folder / f"{module}.py").write_text(f"from types import SimpleNamespace\n{line}\n")
        monkeypatch.syspath_prepend(tmp_path)
        package = __import__(name)
        for each in (name, *(f"{name}.{module}" for module in modules)):
            monkeypatch.delitem(sys.modules, each, raising=False)
        return package

    return package_of


def test_modules_are_found_and_sorted_by_name(package_of):
    lines = {"b": "ENTRY = SimpleNamespace(name='alpha')", "a": "ENTRY = SimpleNamespace(name='beta')"}
    assert list(discover(package_of("two_entries", **lines), "ENTRY")) == ["alpha", "beta"]


def test_a_name_that_is_taken_is_refused(package_of):
    lines = {"a": "ENTRY = SimpleNamespace(name='same')", "b": "ENTRY = SimpleNamespace(name='same')"}
    with pytest.raises(ValueError, match=r"twins\.b: twins has a 'same' already"):
        discover(package_of("twins", **lines), "ENTRY")


def test_a_module_without_entry_is_refused(package_of):
    with pytest.raises(AttributeError, match="ENTRY"):
        discover(package_of("empty_handed", a="OTHER = 1"), "ENTRY")
