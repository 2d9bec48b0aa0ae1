"""What an own technique may be called, and what it has to give: faults are told by file, technique and frame."""

import sys

import pytest

import swimlab.render.techniques as package
from sequences.names import LONGEST
from swimlab.render import catalogue
from swimlab.runs.record import PARTS

FILE = """
import numpy as np

from swimlab.render import Picture, Technique


def render(shot, settings):
    height, width = shot.view.height, shot.view.width
    whole = np.ones((height, width, 4), np.float32)
    return {given}


TECHNIQUE = Technique(name={name!r}, summary="", source="a test", render=render)
"""


@pytest.fixture
def own(swimlab, tmp_path, monkeypatch):
    """Render with a file of one's own: exit code and what is said."""
    monkeypatch.setattr(package, "__path__", list(package.__path__))
    monkeypatch.setenv(catalogue.FOLDERS, str(tmp_path / "own"))
    (tmp_path / "own").mkdir()

    def own(text, name="mine"):
        (tmp_path / "own" / "own_file.py").write_text(text, encoding="utf-8")
        catalogue.techniques.cache_clear()
        words = ("-t", name, "--size", "24x16", "--frames", "0", "--samples", 4, "-o", "runs/run", "-q")
        code, _, err = swimlab("render", "road-shift", *words)
        return code, err

    yield own
    sys.modules.pop(f"{package.__name__}.own_file", None)
    catalogue.techniques.cache_clear()


def test_a_picture_of_its_own_is_rendered(own, tmp_path):
    assert own(FILE.format(name="mine", given="Picture(whole, whole, 7)")) == (0, "")
    assert (tmp_path / "runs" / "run" / "mine" / "0000.exr").is_file()


@pytest.mark.parametrize(
    "name",
    ["../escaped", "..", "", "a b", "a/b", "-t", "a,b", "é", "a" * (LONGEST + 1), *PARTS, "Geometry", "TSL", None, 3],
)
def test_a_name_that_is_no_folder_of_its_own_is_refused_before_anything_is_written(own, tmp_path, name):
    code, err = own(FILE.format(name=name, given="None"), name="tsl")
    assert code == 2
    assert err.startswith(f"swimlab: {catalogue.FOLDERS}={tmp_path / 'own'}: ")
    assert repr(name) in err
    assert not (tmp_path / "runs").exists()


@pytest.mark.parametrize(
    ("given", "said"),
    [
        ("None", "a Picture, and gave NoneType"),
        ("whole", "a Picture, and gave ndarray"),
        ("Picture(whole[..., :3])", "whose rgba is an array of floats [16, 24, 4], and gave float32 [16, 24, 3]"),
        ("Picture(whole[:3])", "whose rgba is an array of floats [16, 24, 4], and gave float32 [3, 24, 4]"),
        ("Picture(whole.swapaxes(0, 1))", "and gave float32 [24, 16, 4]"),
        ("Picture(whole.astype(np.uint8))", "and gave uint8 [16, 24, 4]"),
        ("Picture(whole.tolist())", "whose rgba is an array of floats [16, 24, 4], and gave list"),
        (
            "Picture(whole, whole[..., :1])",
            "whose error is an array of floats [16, 24, 4], and gave float32 [16, 24, 1]",
        ),
        ("Picture(whole, None, None)", "whose shaded is a whole number, and gave None"),
    ],
)
def test_what_is_no_picture_of_the_frame_is_told(own, tmp_path, given, said):
    code, err = own(FILE.format(name="mine", given=given))
    assert (code, "Traceback" in err) == (2, False)
    assert err.startswith("swimlab: mine, frame 0: the technique should give a Picture")
    assert said in err
    assert not (tmp_path / "runs" / "run" / "mine").exists()


@pytest.mark.parametrize(
    ("text", "said"),
    [
        ("raise ValueError('boo')", "boo"),
        ("1 / 0", "ZeroDivisionError: division by zero"),
        ("import no_such", "ModuleNotFoundError: No module named 'no_such'"),
        ("def", "SyntaxError: invalid syntax"),
        ("a = 1", "has no attribute 'TECHNIQUE'"),
        ("TECHNIQUE = 3", "TECHNIQUE is no Technique"),
    ],
)
def test_a_file_that_fails_is_named(own, tmp_path, text, said):
    code, err = own(text, name="tsl")
    assert (code, "Traceback" in err) == (2, False)
    assert f"{tmp_path / 'own' / 'own_file.py'}: {said}" in err or (said in err and "own_file.py: " in err)
