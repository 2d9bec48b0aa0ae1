"""The hash of `$OCIO` moves with all that a configuration is made of, and says where that cannot be told."""

import pytest

from swimlab.runs.configuration import configuration

TABLE = "!<FileTransform> {src: curve.spi1d, interpolation: linear}"


@pytest.fixture
def own(tmp_path, monkeypatch):
    """A configuration that names one file in luts/."""
    path = tmp_path / "own.ocio"
    (tmp_path / "luts").mkdir()
    (tmp_path / "luts" / "curve.spi1d").write_text("0 1", encoding="utf-8")
    path.write_text(f"ocio_profile_version: 2\nsearch_path: luts\n  from: {TABLE}\n", encoding="utf-8")
    for name in ("OCIO", "OCIO_ACTIVE_VIEWS"):
        monkeypatch.delenv(name, raising=False)
    return path


def test_without_a_name_it_is_the_built_in_one(own):
    assert configuration() is None


def test_text_files_and_variables_move_it(own, monkeypatch):
    monkeypatch.setenv("OCIO", str(own))
    found = [configuration()]
    (own.parent / "luts" / "curve.spi1d").write_text("0 2", encoding="utf-8")
    found.append(configuration())
    own.write_text(own.read_text(encoding="utf-8") + "# more", encoding="utf-8")
    found.append(configuration())
    monkeypatch.setenv("OCIO_ACTIVE_VIEWS", "Raw")
    found.append(configuration())
    assert all(each.whole for each in found)
    assert len({each.digest for each in found}) == 4


def test_the_place_does_not_move_it(own, monkeypatch, tmp_path):
    monkeypatch.setenv("OCIO", str(own))
    before = configuration()
    moved = own.parent.rename(tmp_path.with_name(f"{tmp_path.name} moved"))
    monkeypatch.setenv("OCIO", str(moved / own.name))
    assert configuration() == before


@pytest.mark.parametrize("change", [("luts", "$SHOT/luts"), ("curve", "gone"), ("luts", "nowhere"), ("{src", "{\n  a")])
def test_files_that_cannot_be_told_are_told(own, monkeypatch, change):
    monkeypatch.setenv("OCIO", str(own))
    own.write_text(own.read_text(encoding="utf-8").replace(*change), encoding="utf-8")
    assert not configuration().whole


def test_lists_of_folders_are_searched(own, monkeypatch):
    monkeypatch.setenv("OCIO", str(own))
    text = own.read_text(encoding="utf-8")
    own.write_text(text.replace("search_path: luts", "search_path:\n  - none\n  - luts"), encoding="utf-8")
    assert configuration().whole


def test_what_is_not_there_is_not_whole(own, monkeypatch):
    monkeypatch.setenv("OCIO", str(own.with_name("none.ocio")))
    assert not configuration().whole
