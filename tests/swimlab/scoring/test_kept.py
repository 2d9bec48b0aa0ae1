"""Scores are measured once: they are kept while pictures, settings and code are the same, and no longer."""

import json

import pytest

from swimlab.render import run as render_run
from swimlab.report import kept as kept_reports
from swimlab.runs.configuration import Configuration
from swimlab.runs.frames import frame_path
from swimlab.scoring import kept, measure, score


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
    monkeypatch.setattr(kept, "hash_of_code", lambda: "of another version")
    assert swimlab("measure", run, "-q")[0] == 0
    assert sorted(measured) == ["pixel-point", "vertex"]


@pytest.mark.parametrize("text", ["", "[]", '{"version": 1}', '{"version": 1, "sequences": [1]}'])
def test_damaged_scores_are_measured_again(swimlab, run, measured, text):
    first = scores(run)
    (run / "scores.json").write_text(text, encoding="utf-8")
    assert swimlab("measure", run, "-q")[0] == 0
    assert sorted(measured) == ["pixel-point", "vertex"]
    assert scores(run) == first


def test_what_a_view_shows_is_kept_while_its_configuration_is_the_same(swimlab, tmp_path, measured, monkeypatch):
    sequence = tmp_path / "shown.toml"
    view = "sRGB - Display/Un-tone-mapped"
    sequence.write_text(
        f'version = 1\nname = "shown"\nframes = 2\nsize = [64, 36]\n[display]\nview = "{view}"\n'
        '[motion]\nkind = "shift"\nvelocity = [0.5, 0.5]\n',
        encoding="utf-8",
    )
    words = ("-t", "vertex", "--samples", 4, "--domain", "display", "-q", "-o", tmp_path / "run")
    counts = []
    for named in (None, None, ("a", True), ("a", True), ("b", True), ("b", False), ("b", False)):
        for module in (kept, score):
            monkeypatch.setattr(module, "configuration", lambda named=named: named and Configuration(*named))
        code, _, err = swimlab("study", sequence, *words)
        assert code == 0, err
        counts.append(len(measured))
        assert scores(tmp_path / "run")[0]["display"].get("configuration") == (named and named[0])
    assert counts == [1, 1, 2, 2, 3, 4, 5]


def test_nothing_is_rendered_or_written_where_nothing_is_new(swimlab, run, monkeypatch):
    monkeypatch.setattr(render_run, "Renderer", None)
    files = ("run.json", "scores.json", "frames.csv", "contact.png", "report.html")
    before = [(run / name).stat().st_mtime_ns for name in files]
    words = ("-t", "pixel-point,vertex", "--size", "96x54", "--frames", "0-2", "--samples", 4, "-q", "-o", run)
    assert swimlab("study", "road-shift", *words)[0] == 0
    assert [(run / name).stat().st_mtime_ns for name in files] == before


def test_the_report_is_made_again_of_other_code_or_where_it_is_another_page(swimlab, run, monkeypatch):
    page = run / "report.html"
    words = ("-t", "pixel-point,vertex", "--size", "96x54", "--frames", "0-2", "--samples", 4, "-q", "-o", run)
    for change in (lambda: page.write_text("another", encoding="utf-8"), (run / "contact.png").unlink):
        change()
        before = page.stat().st_mtime_ns
        assert swimlab("study", "road-shift", *words)[0] == 0
        assert page.stat().st_mtime_ns > before
        assert "<html" in page.read_text(encoding="utf-8")
    monkeypatch.setattr(kept_reports, "hash_of_code", lambda *_: "of another version")
    before = page.stat().st_mtime_ns
    assert swimlab("study", "road-shift", *words)[0] == 0
    assert page.stat().st_mtime_ns > before
