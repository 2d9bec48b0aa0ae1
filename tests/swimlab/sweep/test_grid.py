"""Sweep files, their configurations, and which work is the same work."""

from itertools import chain

import pytest
from hypothesis import given
from hypothesis import strategies as st

from sequences import load
from swimlab.render.geometry import describe_geometry
from swimlab.render.plan import Plan
from swimlab.runs.configuration import Configuration
from swimlab.runs.record import RunError
from swimlab.sweep import score
from swimlab.sweep.chunk import cut, spans
from swimlab.sweep.file import SweepError, load_sweep
from swimlab.sweep.grid import configurations, name_of

DOMAINS = ("linear", "display")
HEAD = 'version = 1\nname = "s"\n'
PLAIN = HEAD + 'sequences = ["road-shift"]\ntechniques = ["tsl", "pixel-aniso"]\n'

BAD = {
    "an unknown key": (PLAIN + "chunks = 3", "chunks: unknown key (did you mean 'chunk'?"),
    "no sequences": (HEAD + 'techniques = ["tsl"]', "sequences: missing"),
    "an unknown technique": (PLAIN.replace('"tsl"', '"tls"'), "techniques: there is no 'tls' (did you mean 'tsl'?"),
    "a technique twice": (PLAIN.replace('"tsl"', '"pixel-aniso"'), "techniques: 'pixel-aniso' is listed twice"),
    "a sequence twice": (PLAIN.replace('["road-shift"]', '["a", "a"]'), "sequences: 'a' is listed twice"),
    "no frames in a chunk": (PLAIN + "chunk = 0", "chunk: should be greater than or equal to 1"),
    "another version": (PLAIN.replace("version = 1", "version = 2"), "version: should be 1, got 2"),
    "no values": (PLAIN + '[grid]\n"camera.fov" = []', "grid.camera.fov: "),
    "a value twice": (PLAIN + '[grid]\n"camera.fov" = [40, 50, 40]', "grid: 'camera.fov': 40 is listed twice"),
    "a varied name": (PLAIN + '[grid]\nname = ["a"]', "grid: 'name': is made from what is varied"),
    "settings of nobody": (PLAIN + '[grid]\n"techniques.taa.blend" = [0.1]', "taa is not among the techniques"),
    "no TOML": ("[grid", "not TOML"),
    "an unknown sequence": (PLAIN.replace("road-shift", "road-shfit"), "no such sequence (did you mean 'road-shift'?"),
    "a missing file": (PLAIN.replace("road-shift", "gone.toml"), "gone.toml: cannot be read"),
    "an unknown varied key": (PLAIN + '[grid]\n"scene.son.elevation" = [1.0]', "scene.son: unknown key"),
    "a bad varied value": (PLAIN + '[grid]\n"techniques.tsl.size" = [64, 100]', "techniques.tsl.size: must be a power"),
    "a key of no table": (PLAIN + '[grid]\n"frames.first" = [1]', "frames.first: frames is not a table"),
    "frames beyond the last": (PLAIN + 'frames = "0-99"', "s.toml: frames 0-99: the sequence has frames 0-31"),
    "samples that are no square": (PLAIN + "samples = 5", "s.toml: samples 5: must be a square number"),
}


@pytest.mark.parametrize("what", BAD)
def test_bad_files_are_refused_by_key(swimlab, tmp_path, what):
    text, message = BAD[what]
    (tmp_path / "s.toml").write_text(text + "\n", encoding="utf-8")
    code, out, err = swimlab("sweep", "s.toml", "-o", "out")
    assert (code, out) == (2, "")
    assert message in err
    assert {path.name for path in tmp_path.iterdir()} == {"s.toml"}


def test_every_mistake_is_named_at_once(tmp_path):
    text = PLAIN.replace('"tsl"', '"tls"') + '[grid]\nname = ["a"]\n"camera.fov" = [1, 1]\n"scene.son.x" = [1]\n'
    (tmp_path / "s.toml").write_text(text, encoding="utf-8")
    with pytest.raises(SweepError) as error:
        configurations(load_sweep(tmp_path / "s.toml"))
    lines = str(error.value).splitlines()
    assert len(lines) == 4
    for line, key in zip(lines, ("techniques", "'name'", "'camera.fov'", "scene.son"), strict=True):
        assert line.startswith(f"{tmp_path / 's.toml'}: ")
        assert key in line
    (tmp_path / "s.toml").write_text(PLAIN + '[grid]\n"camera.fov" = [-1, 500]\n"fps" = [-1]\n', encoding="utf-8")
    with pytest.raises(SweepError) as error:
        configurations(load_sweep(tmp_path / "s.toml"))
    assert {line.split(": ")[2] for line in str(error.value).splitlines()} == {"fps", "camera.fov"}


def test_the_product_is_taken_and_named(tmp_path):
    (tmp_path / "own.toml").write_text('version = 1\nname = "own"\nframes = 5\n', encoding="utf-8")
    text = PLAIN.replace('"road-shift"', '"road-shift", "own.toml"') + 'size = [64, 36]\nframes = "0-2"\n'
    text += '[grid]\n"techniques.tsl.size" = [64, 128]\n"scene.sun.elevation" = [10.0, 14.0]\n'
    (tmp_path / "s.toml").write_text(text, encoding="utf-8")
    plans = configurations(load_sweep(tmp_path / "s.toml"))
    found = {
        (plan.sequence.techniques["tsl"]["size"], plan.sequence.scene.sun.elevation, plan.sequence.name)
        for plan in plans
    }
    assert found == {
        (size, elevation, f"{name}_tsl.size-{size}_sun.elevation-{elevation}")
        for name in ("road-shift", "own")
        for size in (64, 128)
        for elevation in (10.0, 14.0)
    }
    assert {plan.techniques for plan in plans} == {("pixel-aniso", "reference", "tsl")}
    assert {(plan.sequence.size, plan.frames) for plan in plans} == {((64, 36), (0, 1, 2))}
    (tmp_path / "own.toml").write_text('version = 1\nname = "road-shift"\n', encoding="utf-8")
    with pytest.raises(SweepError, match="two are named"):
        configurations(load_sweep(tmp_path / "s.toml"))


def test_names_are_short_and_tell_values_apart():
    assert name_of("a", {}) == "a"
    assert name_of("a", {"scene.road.two_sided": True, "fps": 30}) == "a_road.two_sided-true_fps-30"
    long = [{f"key.{n}": "x" * 20 for n in range(6)}, {f"key.{n}": "y" * 20 for n in range(6)}]
    odd = [{"size": [1, 2]}, {"size": [2, 1]}, {"a.x.k": 1, "b.x.k": 1}, {"scene.material.albedo": "a/b.exr"}]
    names = [name_of("n" * 100, varied) for varied in long + odd]
    assert len(set(names)) == len(names)
    assert max(map(len, names)) <= 100


PLAN = Plan(load("road-drive"), ("pixel-aniso", "reference", "taa", "tsl"), tuple(range(6)))


def digests(plan, size=6):
    return {name: [chunk.digest for chunk in chunks] for name, chunks in cut(plan, size).items()}


def changed(**changes):
    """Names of the techniques whose work is another."""
    plan = {"sequence": PLAN.sequence, "techniques": PLAN.techniques, "frames": PLAN.frames} | {
        key: value for key, value in changes.items() if key in {"samples", "half"}
    }
    given = {key: value for key, value in changes.items() if key not in {"samples", "half"}}
    before, after = digests(PLAN), digests(Plan(**(plan | {"sequence": PLAN.sequence.with_changes(**given)})))
    return {name for name in before if before[name] != after[name]}


TECHNIQUES = {"pixel-aniso", "reference", "taa", "tsl"}


def test_only_what_decides_pixels_makes_other_work():
    assert changed() == set()
    assert changed(name="other", viewing={"luminance": 50.0}, display={"exposure": 1.0}) == set()
    assert changed(techniques={"tsl": {"size": 64}}) == {"tsl"}
    assert changed(samples=16) == {"reference"}
    assert changed(half=False) == TECHNIQUES
    assert changed(scene={"sun": {"elevation": 20.0}}) == TECHNIQUES
    assert changed(scene={"material": {"brdf": "banks"}}) == TECHNIQUES
    assert changed(seed=1) == TECHNIQUES | {"geometry"}
    assert changed(camera={"fov": 40.0}) == TECHNIQUES | {"geometry"}
    assert changed(frames=40) == TECHNIQUES | {"geometry"}


def test_the_bytes_of_maps_make_other_work(tmp_path):
    (tmp_path / "own.toml").write_text('version = 1\nname = "own"\n[scene.material]\nalbedo = "a.exr"\n')
    (tmp_path / "a.exr").write_bytes(b"one")
    plan = Plan(load(tmp_path / "own.toml"), ("reference",), (0,))
    before = digests(plan)
    (tmp_path / "a.exr").write_bytes(b"another")
    after = digests(plan)
    assert before["reference"] != after["reference"]
    assert before["geometry"] == after["geometry"]


def test_geometry_is_the_same_under_any_light(shoot, pack_maps, maps):
    sequence = PLAN.sequence.with_changes(size=(48, 27))
    other = sequence.with_changes(scene={"sun": {"azimuth": 90.0}, "material": {"brdf": "banks"}})
    one, two = describe_geometry(shoot(sequence, 2)), describe_geometry(shoot(other, 2, pack_maps(1 - maps)))
    for name in ("coverage", "motion", "depth"):
        assert getattr(one, name).tobytes() == getattr(two, name).tobytes()


@given(st.sets(st.integers(0, 300), min_size=1, max_size=60), st.integers(1, 20), st.booleans())
def test_chunks_hold_every_frame_once_in_order(numbers, size, doubling):
    frames = tuple(sorted(numbers))
    parts = list(spans(frames, size, doubling=doubling))
    assert tuple(chain.from_iterable(parts)) == frames
    assert all(len(part) >= size for part in parts[:-1])


@given(st.integers(1, 2000), st.integers(1, 20))
def test_a_technique_that_remembers_renders_no_frame_often(count, size):
    """What goes before the chunks is at most what is in them: chunks double."""
    parts = list(spans(tuple(range(count)), size, doubling=True))
    assert sum(part[0] for part in parts) <= count


def test_scores_of_a_view_are_named_by_its_configuration(monkeypatch, tmp_path):
    viewed = PLAN.sequence.with_changes(display={"view": "sRGB - Display/Raw"})
    plan = Plan(viewed, ("taa",), (0, 1))
    chunks = cut(plan, 1)
    names = set()
    for digest in "ab":
        monkeypatch.setattr(score, "configuration", lambda digest=digest: Configuration(digest, whole=True))
        names |= {score.score_path(plan, chunks | {"reference": []}, "taa", domain, tmp_path) for domain in DOMAINS}
    assert len(names) == 3
    monkeypatch.setattr(score, "configuration", lambda: Configuration("c", whole=False))
    with pytest.raises(RunError, match="without variables"):
        score.score_path(plan, chunks | {"reference": []}, "taa", "display", tmp_path)


def test_only_techniques_that_remember_double():
    lengths = {name: [len(c.frames) for c in chunks] for name, chunks in cut(PLAN, 1).items()}
    assert lengths.pop("taa") == [1, 1, 4]
    assert set(map(tuple, lengths.values())) == {(1,) * 6}
    scale = Plan(load("road-scale"), ("taa",), tuple(range(6)))
    assert [len(chunk.frames) for chunk in cut(scale, 2)["taa"]] == [2, 2, 2]
