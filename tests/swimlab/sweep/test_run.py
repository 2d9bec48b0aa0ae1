"""Sweeps on one machine: as render and measure, resumed, interrupted, failed and mended, in pieces for a farm."""

import json
import shutil
import sys

import pytest
from openjd.model import (
    DocumentType,
    ParameterValue,
    ParameterValueType,
    StepParameterSpaceIterator,
    create_job,
    decode_job_template,
    document_string_to_object,
)
from run_folders import entries, pixels

SWEEP = """
version = 1
name = "small"
sequences = ["own.toml"]
techniques = ["pixel-point", "tsl", "taa"]
size = [40, 24]
samples = 4
chunk = 2
[grid]
"techniques.tsl.size" = [32, 64]
"""
OWN = 'version = 1\nname = "own"\nframes = 8\n[techniques.taa]\npreroll = 2\n'
NAMES = ("own_tsl.size-32", "own_tsl.size-64")


@pytest.fixture
def sweep(tmp_path):
    (tmp_path / "sweep.toml").write_text(SWEEP, encoding="utf-8")
    (tmp_path / "own.toml").write_text(OWN, encoding="utf-8")
    return tmp_path / "sweep.toml"


def inodes(folder):
    return {str(path.relative_to(folder)): path.stat().st_ino for path in folder.rglob("*.exr")}


def test_a_sweep_is_what_render_and_measure_make(swimlab, sweep, tmp_path):
    """Bit for bit, frames of taa in chunks too."""
    code, out, err = swimlab("sweep", sweep, "-o", "out", "--threads", "2")
    assert code == 0, err
    assert out.splitlines()[-1] == str(tmp_path / "out" / "scores.json")
    assert "rendering chunks: done" in err
    for name, size in zip(NAMES, (32, 64), strict=True):
        text = OWN.replace('"own"', f'"{name}"') + f"[techniques.tsl]\nsize = {size}\n"
        (tmp_path / "one.toml").write_text(text, encoding="utf-8")
        words = ("-t", "pixel-point,tsl,taa,reference", "--size", "40x24", "--samples", "4", "-q")
        assert swimlab("render", "one.toml", "-o", name, *words)[0] == 0
        assert swimlab("measure", name, "-q")[0] == 0
        whole, made = tmp_path / name, tmp_path / "out" / "runs" / name
        assert pixels(whole) == pixels(made)
        assert entries(whole / "scores.json") == entries(made / "scores.json")
        assert (whole / "frames.csv").read_text() == (made / "frames.csv").read_text()
        one, two = (json.loads((folder / "run.json").read_text()) for folder in (whole, made))
        for key in ("sequence", "settings", "hash", "techniques", "frames", "reference_rms_error"):
            assert one[key] == two[key]
        assert swimlab("info", made)[0] == 0
    assert [entry["sequence"] for entry in entries(tmp_path / "out" / "scores.json")] == [
        name for name in NAMES for _ in range(3)
    ]
    assert swimlab("report", tmp_path / "out" / "runs")[0] == 0

    # Equal work was done once: of both sizes' pixel-point there is one file, and one score.
    point, tsl = ([(tmp_path / "out" / "runs" / n / t / "0000.exr") for n in NAMES] for t in ("pixel-point", "tsl"))
    assert point[0].samefile(point[1])
    assert not tsl[0].samefile(tsl[1])
    assert len(list((tmp_path / "out" / "scores").iterdir())) == 4
    assert len(list((tmp_path / "out" / "chunks").glob("*/*/chunk.json"))) == 23


def test_one_table_has_a_row_for_each_distinct_result(swimlab, sweep, tmp_path):
    """The settings of tsl concern tsl alone; another sun is another truth, with rows of its own, the best first."""
    text = (
        SWEEP.replace('"pixel-point", "tsl", "taa"', '"pixel-point", "tsl"') + '"scene.sun.elevation" = [10.0, 14.0]\n'
    )
    sweep.write_text(text.replace("[40, 24]", "[128, 72]"), encoding="utf-8")
    code, out, _ = swimlab("sweep", sweep, "-o", "out", "-q")
    assert code == 0
    (head,) = [line.split() for line in out.splitlines() if "technique" in line and "≈" not in line]
    assert " ".join(head) == "tsl.size sun.elevation technique rms error flicker visible flicker ms a frame"
    rows = [line.split() for line in out.splitlines() if "tsl " in line or "pixel-point " in line]
    found = [row[:3] if row[-5] == "tsl" else row[:2] for row in rows]
    own = [["32", "10.0", "tsl"], ["64", "10.0", "tsl"], ["10.0", "pixel-point"]]
    assert sorted(found[:3]) == sorted(own)
    assert sorted(found[3:]) == sorted([["14.0" if cell == "10.0" else cell for cell in row] for row in own])
    errors = [float(row[-4].removeprefix("≈")) for row in rows]
    assert errors == [*sorted(errors[:3]), *sorted(errors[3:])]
    for row in rows:
        size, elevation = (row[0], row[1]) if row[-5] == "tsl" else ("32", row[0])
        run = tmp_path / "out" / "runs" / f"own_tsl.size-{size}_sun.elevation-{elevation}"
        (entry,) = [e for e in entries(run / "scores.json") if e["technique"] == row[-5]]
        assert row[-4].removeprefix("≈") == f"{entry['scores']['budget.mse'] ** 0.5:.4f}"
    assert len(json.loads(swimlab("sweep", sweep, "-o", "out", "-q", "--json")[1])["sequences"]) == 8


def test_a_whole_run_folder_is_passed_over_until_a_chunk_is_newer(swimlab, sweep, tmp_path, monkeypatch):
    from swimlab.sweep import assemble

    command = ("sweep", sweep, "-o", "out", "-q")
    assert swimlab(*command)[0] == 0
    placed = []
    with monkeypatch.context() as patch:
        patch.setattr(assemble, "_place", lambda source, _: placed.append(source))
        assert swimlab(*command)[0] == 0
        assert not placed
        chunk = next((tmp_path / "out" / "chunks").glob("*/*/tsl")).parent
        shutil.rmtree(chunk)
        assert swimlab(*command)[0] == 0
        assert chunk in {source.parents[1] for source in placed}
        placed.clear()
        # How it is looked at is no part of the hash, but of the record.
        (tmp_path / "own.toml").write_text(OWN + "[viewing]\nluminance = 50.0\n", encoding="utf-8")
        assert swimlab(*command)[0] == 0
        assert placed
    record = json.loads((tmp_path / "out" / "runs" / NAMES[0] / "run.json").read_text())
    assert record["sequence"]["viewing"]["luminance"] == 50.0


def test_two_runs_of_a_sweep_can_be_compared(swimlab, sweep, tmp_path):
    assert swimlab("sweep", sweep, "-o", "out", "-q")[0] == 0
    code, out, _ = swimlab("compare", *(tmp_path / "out" / "runs" / name for name in NAMES))
    assert code == 0
    assert f"#1: {NAMES[0]}: OTHER SETTINGS: techniques.tsl.size 32 → 64\n" in out
    assert not [line for line in out.splitlines() if line.startswith("  pixel-point")]


def test_a_sweep_goes_on_where_it_was_killed(swimlab, sweep, tmp_path):
    out = tmp_path / "out"
    assert swimlab("sweep", sweep, "-o", "out", "-q")[0] == 0
    scores, frames, before = entries(out / "scores.json"), pixels(out / "runs"), inodes(out / "chunks")
    chunks = sorted(path.parent for path in (out / "chunks").glob("*/*/chunk.json"))
    # As SIGKILL leaves it: a chunk half written, one not begun, a score and a run folder missing.
    chunks[0].rename(chunks[0].with_name(f".{chunks[0].name}.elsewhere.7.tmp"))
    for path in sorted(chunks[1].rglob("*"), reverse=True):
        path.rmdir() if path.is_dir() else path.unlink()
    chunks[1].rmdir()
    next((out / "scores").iterdir()).unlink()
    (out / "runs" / NAMES[0] / "run.json").unlink()
    code, printed, _ = swimlab("sweep", sweep, "-o", "out", "--dry-run", "--json")
    assert code == 0
    work = json.loads(printed)["work"]
    assert sum(row["chunks"] - row["done"] for row in work) == 2
    assert {row["technique"]: row["frames"] for row in work} == {
        "geometry": 8,
        "pixel-point": 8,
        "reference": 8,
        "taa": 8,
        "tsl": 16,
    }  # fmt: skip
    assert swimlab("sweep", sweep, "-o", "out", "-q")[0] == 0
    assert entries(out / "scores.json") == scores
    assert pixels(out / "runs") == frames
    after = inodes(out / "chunks")
    assert after.keys() == before.keys()
    kept = [name for name in after if before[name] == after[name]]
    assert 0 < len(after) - len(kept) <= sum(len(list(chunk.rglob("*.exr"))) for chunk in chunks[:2])
    assert not list(out.rglob("*.tmp"))


def test_failures_are_recorded_and_tried_again(swimlab, sweep, tmp_path, monkeypatch):
    from swimlab.render import renderer

    check_range = renderer.check_range

    def broken(picture, name, frame, **given):
        if (name, frame) == ("pixel-point", 3):
            raise ValueError("no more paper")
        check_range(picture, name, frame, **given)

    out = tmp_path / "out"
    with monkeypatch.context() as patch:
        patch.setattr(renderer, "check_range", broken)
        code, printed, err = swimlab("sweep", sweep, "-o", "out")
        assert code == 2
        assert "1 task failed" in err
        assert "own_tsl.size-32, pixel-point, frames 2-3: no more paper" in err
        (file,) = (out / "failures").iterdir()
        failure = json.loads(file.read_text())
        assert failure["error"] == "ValueError: no more paper"
        assert "in broken" in failure["traceback"]
        # The others are done and measured.
        assert {entry["technique"] for entry in entries(out / "scores.json")} == {"tsl", "taa"}
        assert "tsl" in printed
        assert not list(out.rglob("*.tmp"))
    before = inodes(out / "chunks")
    assert swimlab("sweep", sweep, "-o", "out", "-q")[0] == 0
    assert not list((out / "failures").iterdir())
    assert {entry["technique"] for entry in entries(out / "scores.json")} == {"pixel-point", "tsl", "taa"}
    after = inodes(out / "chunks")
    assert {name: after[name] for name in before} == before


def test_without_a_reference_nothing_is_measured(swimlab, sweep, tmp_path, monkeypatch):
    from swimlab.render import renderer

    monkeypatch.setattr(renderer, "rms_error", lambda *_: 1 / 0)
    code, printed, err = swimlab("sweep", sweep, "-o", "out", "-q")
    assert (code, printed) == (2, "")
    assert "reference" in err
    assert not (tmp_path / "out" / "runs").exists()


def test_an_interrupt_leaves_whole_chunks_only(swimlab, sweep, tmp_path, monkeypatch):
    from swimlab.render import renderer

    written = renderer.write_frame

    def interrupted(path, *rest, **given):
        if path.name == "0003.exr":
            raise KeyboardInterrupt
        written(path, *rest, **given)

    with monkeypatch.context() as patch:
        patch.setattr(renderer, "write_frame", interrupted)
        assert swimlab("sweep", sweep, "-o", "out")[0] == 130
    assert not list((tmp_path / "out").rglob("*.tmp"))
    assert len(list((tmp_path / "out" / "chunks").glob("*/*/chunk.json"))) == 5  # 4 of geometry, 1 of frames 0-1
    assert swimlab("sweep", sweep, "-o", "out", "-q")[0] == 0


def test_where_there_are_no_links_frames_are_copied(swimlab, sweep, tmp_path, monkeypatch):
    def unsupported(*_):
        raise OSError("Operation not supported")

    monkeypatch.setattr("pathlib.Path.hardlink_to", unsupported)
    assert swimlab("sweep", sweep, "-o", "out", "-q")[0] == 0
    runs = tmp_path / "out" / "runs"
    before = inodes(runs)
    frames = list(runs.rglob("*.exr"))
    assert {path.stat().st_nlink for path in frames} == {1}
    assert swimlab("sweep", sweep, "-o", "out", "-q")[0] == 0
    assert inodes(runs) == before


def test_an_export_does_the_sweep_in_pieces(swimlab, sweep, tmp_path):
    """The template is valid; its commands, given as a farm would give them, make what the sweep makes."""
    assert swimlab("sweep", sweep, "--export", "openjd", "job.json") == (0, "job.json\n", "")
    assert not (tmp_path / "runs").exists()
    text = (tmp_path / "job.json").read_text(encoding="utf-8")
    template = decode_job_template(template=document_string_to_object(document=text, document_type=DocumentType.JSON))
    given = {"SweepFile": str(sweep), "Out": str(tmp_path / "out")}
    values = {name: ParameterValue(type=ParameterValueType.PATH, value=value) for name, value in given.items()}
    job = create_job(job_template=template, job_parameter_values=values)
    render, measure = job.steps
    assert [dependency.dependsOn for dependency in measure.dependencies] == [render.name]
    assert len(StepParameterSpaceIterator(space=render.parameterSpace)) == 23

    def call(step, chunk=None):
        action = json.loads(text)["steps"][step]["script"]["actions"]["onRun"]
        words = " ".join(action["args"]).replace("{{Task.Param.Chunk}}", str(chunk))
        for name, value in given.items():
            words = words.replace(f"{{{{Param.{name}}}}}", value)
        assert action["command"] == "swimlab"
        return swimlab(*words.split())

    for chunk in range(1, 24):
        assert call(0, chunk) == (0, "", "")
        assert len(list((tmp_path / "out" / "chunks").glob("*/*/chunk.json"))) == chunk
    before = inodes(tmp_path / "out" / "chunks")
    assert call(1)[0] == 0
    assert inodes(tmp_path / "out" / "chunks") == before
    assert {entry["sequence"] for entry in entries(tmp_path / "out" / "scores.json")} == set(NAMES)


def test_damage_is_found_named_and_mended(swimlab, sweep, tmp_path):
    out = tmp_path / "out"
    command = ("sweep", sweep, "-o", "out", "-q")
    assert swimlab(*command)[0] == 0
    scores = entries(out / "scores.json")

    frame = next((out / "chunks").glob("*/*/tsl/0001.exr"))
    frame.write_bytes(frame.read_bytes()[:500])
    shutil.rmtree(out / "scores")
    code, _, err = swimlab(*command)
    assert code == 2
    assert "tsl/0001.exr: is damaged" in err
    assert "of its chunks 1 were damaged and are removed already" in err
    assert not frame.parents[1].exists()
    assert swimlab(*command)[0] == 0
    assert entries(out / "scores.json") == scores

    about = frame.parents[1] / "chunk.json"
    score = next((out / "scores").iterdir())
    for broken, mend in ((about, about.parent), (score, score)):
        content = broken.read_bytes()
        broken.write_bytes(content[:100])
        code, printed, err = swimlab(*command)
        assert (code, printed) == (2, "")
        assert f"{broken}: is " in err
        assert f"delete {mend}" in err or "delete it" in err
        broken.write_bytes(content)

    frame.unlink()
    shutil.rmtree(out / "runs")
    code, printed, err = swimlab(*command)
    assert (code, printed) == (2, "")
    assert f"{frame}: is missing; delete {about.parent}" in err


def test_who_is_second_with_a_chunk_takes_the_firsts(sweep, tmp_path, monkeypatch):
    """And its own frames may be cleared away by then."""
    from swimlab.render import renderer
    from swimlab.sweep.file import load_sweep
    from swimlab.sweep.render import clear_temporaries, render_chunk
    from swimlab.sweep.run import RenderedWork

    chunk = RenderedWork.of(load_sweep(sweep)).pieces()[0]
    render_chunk(chunk, tmp_path, 1)
    first = tmp_path / "first"
    chunk.path(tmp_path).rename(first)
    written = renderer.write_geometry

    def overtaken(path, *rest, **given):
        if path.name == "0001.exr":
            shutil.copytree(first, chunk.path(tmp_path))
            clear_temporaries(tmp_path)
            raise FileNotFoundError(path)
        written(path, *rest, **given)

    monkeypatch.setattr(renderer, "write_geometry", overtaken)
    render_chunk(chunk, tmp_path, 1)
    assert pixels(chunk.path(tmp_path)) == pixels(first)
    assert not list(tmp_path.rglob("*.tmp"))


REFUSED = {
    "a scheduler for nobody": (["--scheduler", "tcp://h:1"], "--scheduler tcp://h:1: is for --engine dask"),
    "no threads": (["--threads", "0"], "--threads 0: must be at least 1"),
    "a share of nothing": (["--only", "3"], "--only 3: write K/N"),
    "a share beyond the last": (["--only", "3/2"], "--only 3/2: write K/N"),
    "scores of no measurement": (["--only", "1/2", "--json"], "--json: with --only nothing is measured"),
    "an unknown engine": (["--engine", "slurm"], "slurm"),
    "an unknown template": (["--export", "slurm", "x"], "slurm"),
}


@pytest.mark.parametrize("what", REFUSED)
def test_refused_with_a_reason(swimlab, sweep, tmp_path, what):
    words, message = REFUSED[what]
    code, out, err = swimlab("sweep", sweep, *words)
    assert (code, out) == (2, "")
    assert message in " ".join(err.split())
    assert {path.name for path in tmp_path.iterdir()} == {"sweep.toml", "own.toml"}


def test_a_dry_run_of_a_share_speaks_of_that_alone(swimlab, sweep):
    shares = [swimlab("sweep", sweep, "--dry-run", "--json", "--only", f"{k}/3")[1] for k in (1, 2, 3)]
    whole = swimlab("sweep", sweep, "--dry-run", "--json")[1]
    count = [sum(row["chunks"] for row in json.loads(text)["work"]) for text in (*shares, whole)]
    assert sum(count[:3]) == count[3] > count[0]


def test_without_dask_the_extra_is_named(swimlab, sweep, tmp_path, monkeypatch):
    monkeypatch.setitem(sys.modules, "distributed", None)
    code, out, err = swimlab("sweep", sweep, "--engine", "dask")
    assert (code, out) == (2, "")
    assert "pip install 'swimlab[cluster]'" in err
    assert {path.name for path in tmp_path.iterdir()} == {"sweep.toml", "own.toml"}


def test_a_machine_with_another_version_refuses(tmp_path):
    from dataclasses import replace

    from sequences import load
    from swimlab.render.plan import Plan
    from swimlab.runs.record import RunError
    from swimlab.sweep.chunk import cut
    from swimlab.sweep.render import render_chunk

    chunk = cut(Plan(load("road-shift"), ("reference",), (0,)), 1)["geometry"][0]
    with pytest.raises(RunError, match=r"and the sweep was made by 0\.0\.0"):
        render_chunk(replace(chunk, version="0.0.0"), tmp_path, 1)
    with pytest.raises(RunError, match="lacks the sweep's 'geometry', or has another; let SWIMLAB_TECHNIQUES name"):
        render_chunk(replace(chunk, code="1234"), tmp_path, 1)
