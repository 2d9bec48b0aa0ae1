"""The table [display] of a sequence file."""

import pytest

from sequences import Bloom, Display, SequenceError, load

HEAD = 'version = 1\nname = "mine"\n'


@pytest.fixture
def read(tmp_path):
    """The sequence of a file with these lines after its name."""

    def read(text):
        path = tmp_path / "mine.toml"
        path.write_text(HEAD + text, encoding="utf-8")
        return load(path)

    return read


def test_without_the_table_radiance_is_clamped_and_shown_as_srgb(read):
    assert read("").display == Display(exposure=0, tone_map="none", gamma="srgb", bits=None, dither=False)
    assert read("").display.bloom.strength == 0


def test_every_key_is_read(read):
    found = read(
        '[display]\nexposure = -1.5\ntone_map = "aces"\ngamma = "sqrt"\nbits = 8\ndither = true\n'
        "[display.bloom]\nstrength = 0.25\nthreshold = 2\nradius = 0.05\n"
    ).display
    bloom = Bloom(strength=0.25, threshold=2, radius=0.05)
    assert found == Display(exposure=-1.5, tone_map="aces", gamma="sqrt", bits=8, dither=True, bloom=bloom)


def test_a_view_stands_in_place_of_tone_map_and_gamma(read):
    assert read('[display]\nview = "sRGB - Display/Raw"\nexposure = 1\n').display.view == "sRGB - Display/Raw"
    assert read("").display.view is None


@pytest.mark.parametrize(
    ("lines", "message"),
    [
        ('view = "sRGB - Display"', "display.view: .*pattern"),
        ('view = "a/b"\ntone_map = "aces"', "display.view: .*remove tone_map and gamma"),
        ('gamma = "sqrt"\nview = "a/b"', "display.view: .*remove tone_map and gamma"),
        ("exposure = 21", "display.exposure: .*less than or equal to 20"),
        ('tone_map = "filmic"', "display.tone_map: .*'none', 'reinhard' or 'aces'"),
        ("bits = 8.0", "display.bits: .*integer"),
        ("bits = 17", "display.bits: .*less than or equal to 16"),
        ("dither = true", "display.dither: .*set bits"),
        ("dither = 1\nbits = 8", "display.dither: .*boolean"),
        ("bloom = 0.5", "display.bloom: should be a table"),
        ("[display.bloom]\nstrenght = 1", "did you mean 'strength'"),
        ("[display.bloom]\nstrength = 1.5", "display.bloom.strength: .*less than or equal to 1"),
        ("[display.bloom]\nradius = 0", "display.bloom.radius: .*greater than 0"),
    ],
)
def test_a_mistake_is_named_with_its_key(read, lines, message):
    with pytest.raises(SequenceError, match=message):
        read(f"[display]\n{lines}\n")
