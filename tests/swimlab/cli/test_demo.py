"""The demonstration, smaller than it is: what it writes and what it says to look at."""

import pytest
from gate_files import entry

from swimlab.cli import demo_command
from swimlab.render.catalogue import techniques


def test_the_sentences_name_what_sparkles_what_is_biased_and_what_is_near():
    parts = ("budget_mse", "budget_bias", "budget_flicker")
    rows = {"sparks": (0.25, 0.0, 0.25), "calm": (0.36, 0.25, 0.01), "good": (0.01, 0.0, 0.0025)}
    first, second, third = demo_command.what_to_look_at(
        [entry(technique=name, **dict(zip(parts, row, strict=True))) for name, row in rows.items()]
    )
    assert first == "Play sparks: it flickers most, 0.50 rms, 100% of its squared error."
    assert "Flip calm against the reference: it flickers 20% as much" in second
    assert "0.50 of its 0.60 rms error" in second
    assert "Flip good against the reference" in third
    assert "0.10 rms, of which 0.05 is flicker" in third


def test_its_techniques_are_there():
    assert set(demo_command.TECHNIQUES.split(",")) <= set(techniques())


def test_the_demo_writes_a_report_and_says_where(swimlab, monkeypatch, tmp_path):
    monkeypatch.setattr(demo_command, "TECHNIQUES", "pixel-point,pixel-aniso")
    monkeypatch.setattr(demo_command, "SIZE", "96x54")
    monkeypatch.setattr(demo_command, "FRAMES", "0-3")
    code, out, err = swimlab("demo", "-o", "run", "-q")
    assert code == 0, err
    assert (tmp_path / "run" / "report.html").is_file()
    *_, told, first, _second, _third = out.splitlines()
    assert told == "Open run/report.html in a browser. What to look at:"
    assert first.startswith("- Play pixel-point")


@pytest.mark.parametrize("option", ["--output", "--threads", "--force", "--quiet"])
def test_the_demo_has_the_usual_options(swimlab, option):
    assert option in swimlab("demo", "--help")[1]
