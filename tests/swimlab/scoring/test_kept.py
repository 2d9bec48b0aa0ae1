"""Scores are measured once: they are kept while pictures, settings and code are the same, and no longer."""

import json

import pytest

from swimlab.runs.frames import frame_path
from swimlab.scoring import kept, measure


@pytest.fixture
def run(swimlab, tmp_path):
    """A measured run of two techniques beside the reference."""
    words = ("-t", "pixel-point,vertex", "--size", "96x54", "--frames", "0-2", "--samples", 4, "-q", "-o", tmp_path)
    assert swimlab("study", "road-shift", *words)[0] == 0
    return tmp_path


@pytest.fixture
def measured(monkeypatch):
    """The techniques that are measured from now on."""
    names = []
    real = measure.measure_techniques

    def note(run, record, tests, **options):
        names.extend(tests)
        return real(run, record, tests, **options)

    monkeypatch.setattr(measure, "measure_techniques", note)
    return names


def scores(run):
    return json.loads((run / "scores.json").read_text(encoding="utf-8"))["sequences"]


def test_a_second_measurement_measures_nothing(swimlab, run, measured):
    first = scores(run)
    assert swimlab("measure", run, "-q")[0] == 0
    assert measured == []
    assert scores(run) == first


def test_only_a_new_technique_is_measured(swimlab, run, measured):
    first = scores(run)
    words = ("-t", "pixel-bilinear", "--size", "96x54", "--frames", "0-2", "--samples", 4, "-q", "-o", run)
    assert swimlab("study", "road-shift", *words)[0] == 0
    assert measured == ["pixel-bilinear"]
    assert [entry for entry in scores(run) if entry["technique"] != "pixel-bilinear"] == first


def test_another_domain_is_measured(swimlab, run, measured):
    first = scores(run)
    assert swimlab("measure", run, "--domain", "display", "-q")[0] == 0
    assert sorted(measured) == ["pixel-point", "vertex"]
    assert scores(run) != first


def test_a_changed_viewing_is_measured(swimlab, run, measured):
    assert swimlab("measure", run, "--pixels-per-degree", 20, "-q")[0] == 0
    assert sorted(measured) == ["pixel-point", "vertex"]


def test_a_changed_picture_is_measured_alone(swimlab, run, measured):
    frame_path(run, "vertex", 1).write_bytes(frame_path(run, "vertex", 0).read_bytes())
    assert swimlab("measure", run, "-q")[0] == 0
    assert measured == ["vertex"]


def test_a_changed_reference_is_measured_by_all(swimlab, run, measured):
    frame_path(run, "reference", 1).write_bytes(frame_path(run, "reference", 0).read_bytes())
    assert swimlab("measure", run, "-q")[0] == 0
    assert sorted(measured) == ["pixel-point", "vertex"]


def test_changed_code_measures_again(swimlab, run, measured, monkeypatch):
    monkeypatch.setattr(kept, "_code", lambda: "of another version")
    assert swimlab("measure", run, "-q")[0] == 0
    assert sorted(measured) == ["pixel-point", "vertex"]


@pytest.mark.parametrize("text", ["", "[]", '{"version": 1}', '{"version": 1, "sequences": [1]}'])
def test_damaged_scores_are_measured_again(swimlab, run, measured, text):
    first = scores(run)
    (run / "scores.json").write_text(text, encoding="utf-8")
    assert swimlab("measure", run, "-q")[0] == 0
    assert sorted(measured) == ["pixel-point", "vertex"]
    assert scores(run) == first


def test_what_a_view_shows_is_measured_again(swimlab, tmp_path, measured):
    """Its configuration may have changed, which no picture tells."""
    sequence = tmp_path / "shown.toml"
    view = "sRGB - Display/Un-tone-mapped"
    sequence.write_text(
        f'version = 1\nname = "shown"\nframes = 2\nsize = [64, 36]\n[display]\nview = "{view}"\n'
        '[motion]\nkind = "shift"\nvelocity = [0.5, 0.5]\n',
        encoding="utf-8",
    )
    words = ("-t", "vertex", "--samples", 4, "--domain", "display", "-q", "-o", tmp_path / "run")
    for _ in range(2):
        code, _, err = swimlab("study", sequence, *words)
        assert code == 0, err
    assert measured == ["vertex", "vertex"]
