"""Where the surface is in no picture there is nothing to measure, which is said in place of an empty report."""

import pytest

UP = 'version = 1\nname = "up"\nframes = 3\nsize = [48, 32]\n[camera]\npitch = 60\n'
BEHIND = 'version = 1\nname = "behind"\nframes = 3\nsize = [48, 32]\n[scene.road]\nlength = 1\n'
SMALLER = UP.replace('"up"', '"smaller"') + '[motion]\nkind = "scale"\n'


@pytest.mark.parametrize("text", [UP, BEHIND, SMALLER], ids=["up", "behind", "smaller"])
@pytest.mark.parametrize("techniques", ["tsl", "pixel-point,vertex"])
def test_a_road_out_of_sight_is_told_in_a_sentence(swimlab, tmp_path, text, techniques):
    (tmp_path / "road.toml").write_text(text, encoding="utf-8")
    name = text.split('"')[1]
    words = ("study", "road.toml", "-t", techniques, "--samples", 4, "-o", "run", "-q")
    for command in (words, ("report", "run"), ("report", "run", "--folder")):
        code, out, err = swimlab(*command)
        assert (code, out) == (2, "")
        assert err.startswith(f"swimlab: {name}: the surface covers no pixel wholly in any frame, so there is nothing")
        assert len(err.splitlines()) == 1
    assert not (tmp_path / "run" / "report.html").exists()
    assert not (tmp_path / "run" / "report").exists()
