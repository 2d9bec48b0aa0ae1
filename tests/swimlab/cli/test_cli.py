"""The command line: what it prints, what it refuses, and with which exit code."""

import json
import subprocess
import sys

import pytest
from gate_files import entry, write_scores

from metrics.ocio import space_names, view_names
from sequences import library
from swimlab import __version__
from swimlab.cli.doctor_command import CHECKS
from swimlab.cli.main import COMMANDS
from swimlab.footage.convention import PRESETS
from swimlab.render.catalogue import brdfs, techniques

TINY = """
version = 1
name = "tiny"
frames = 3
size = [24, 16]
[scene.material]
albedo = "albedo.exr"
normal = "normal.exr"
gloss = "gloss.exr"
[techniques.tsl]
size = 32
"""


@pytest.fixture
def tiny(tmp_path, maps):
    from swimlab.runs.frames import write_channels

    for key, pixels in {"albedo": maps[..., :3], "normal": maps[..., 3:6], "gloss": maps[..., 6:]}.items():
        names = ("R", "G", "B")[: pixels.shape[2]]
        write_channels(tmp_path / f"{key}.exr", pixels, names, half=False, metadata={})
    (tmp_path / "tiny.toml").write_text(TINY, encoding="utf-8")
    return tmp_path / "tiny.toml"


def test_help_is_quick_and_names_every_command():
    """It loads none of the heavy libraries."""
    script = """
import sys
from swimlab.cli.doctor_command import CHECKS
from swimlab.cli.main import main
sys.argv = ["swimlab", "--help"]
try:
    main()
except SystemExit as error:
    code = error.code or 0
heavy = {"warp", "scipy", "cv2", "OpenImageIO", "matplotlib"} & set(sys.modules)
print("heavy:", sorted(heavy), "code:", code)
"""
    result = subprocess.run([sys.executable, "-c", script], capture_output=True, text=True, check=True)
    assert "heavy: [] code: 0" in result.stdout
    for command in COMMANDS:
        assert command in result.stdout


def test_the_script_is_installed():
    words = [sys.executable, "-c", "from swimlab.cli.main import main; main()", "render", "nowhere"]
    result = subprocess.run(words, capture_output=True, text=True, check=False)
    assert result.returncode == 2
    assert result.stdout == ""
    assert "swimlab: nowhere: no such sequence" in result.stderr
    assert "Traceback" not in result.stderr


def test_version(swimlab):
    assert swimlab("--version")[:2] == (0, __version__ + "\n")


@pytest.mark.parametrize("command", COMMANDS)
def test_every_command_has_help(swimlab, command):
    code, out, _ = swimlab(command, "--help")
    assert code == 0
    assert f"swimlab {command}" in out


def test_a_commands_page_holds_more_than_its_line(swimlab):
    assert "tables are scores, frames, runs and times" in " ".join(swimlab("table", "--help")[1].split())


def test_render_writes_what_the_contract_says(swimlab, tiny, tmp_path):
    words = ("render", tiny, "-t", "tsl,pixel-point", "-o", "out", "--frames", "0-2x2", "--threads", "2")
    code, out, err = swimlab(*words)
    assert code == 0
    assert out == "out\n"
    assert "rendering tiny: done" in err
    files = {path.relative_to(tmp_path / "out").as_posix() for path in (tmp_path / "out").rglob("*.*")}
    folders = ("tsl", "pixel-point", "geometry")
    assert files == {f"{folder}/{frame}.exr" for folder in folders for frame in ("0000", "0002")} | {"run.json"}
    record = json.loads((tmp_path / "out" / "run.json").read_text())
    assert record["provenance"]["command"].startswith(f"swimlab render {tiny} -t tsl,pixel-point")
    assert record["frames"] == [0, 2]

    # Once more: it has all there is. With other settings: refused.
    assert swimlab(*words, "-q") == (0, "out\n", "")
    code, out, err = swimlab(*words, "--float")
    assert (code, out) == (2, "")
    assert "holds a run of other settings" in err
    assert "--force" in err
    assert swimlab(*words, "--float", "--force", "-q")[0] == 0

    code, out, _ = swimlab("info", tmp_path / "out")
    assert code == 0
    digest = json.loads((tmp_path / "out" / "run.json").read_text())["hash"]
    for word in ("tiny, shift, 24x16", "pixel-point, tsl", "2 of 3", digest):
        assert word in out


def test_size_changes_the_pictures(swimlab, tiny, tmp_path):
    from swimlab.runs.frames import read_frame

    assert swimlab("render", tiny, "-t", "pixel-point", "-o", "out", "--frames", "0", "--size", "32x18")[0] == 0
    assert read_frame(tmp_path / "out" / "pixel-point" / "0000.exr").shape == (18, 32, 4)


def test_runs_have_a_folder_by_default(swimlab, tiny, tmp_path):
    assert swimlab("render", tiny, "-t", "pixel-point", "--frames", "1", "-q")[:2] == (0, "runs/tiny\n")
    assert (tmp_path / "runs" / "tiny" / "pixel-point" / "0001.exr").is_file()


REFUSED = {
    "an unknown sequence": (["render", "road-shfit"], "road-shfit: no such sequence (did you mean 'road-shift'?"),
    "a missing file": (["render", "nowhere.toml"], "nowhere.toml: cannot be read"),
    "an unknown technique": (["render", "road-shift", "-t", "tls"], "-t tls: names no technique; did you mean 'tsl'?"),
    "no technique": (["render", "road-shift", "-t", ","], "-t ,: names no technique; there are"),
    "no size": (["render", "road-shift", "--size", "640"], "--size 640: write WIDTHxHEIGHT"),
    "a size without number": (["render", "road-shift", "--size", "axb"], "--size axb: write WIDTHxHEIGHT"),
    "a size too small": (["render", "road-shift", "--size", "2x2"], "size.0: should be greater than or equal to 8"),
    "no frames": (["render", "road-shift", "--frames", "a-b"], "--frames a-b: not a range"),
    "frames beyond the last": (["render", "road-shift", "--frames", "30-40"], "the sequence has frames 0-31"),
    "samples that are no square": (["render", "road-shift", "--samples", "63"], "--samples 63: must be a square"),
    "no threads": (["render", "road-shift", "--threads", "0"], "--threads 0: must be at least 1"),
    "fewer threads": (["render", "road-shift", "--threads=-2"], "--threads -2: must be at least 1"),
    "a device that is not there": (["render", "road-shift", "--device", "tpu"], "--device tpu: not on this machine"),
    "samples that are no number": (["render", "road-shift", "--samples", "many"], "many"),
    "an unknown option": (["render", "road-shift", "--fast"], "--fast"),
    "a command that is not there": (["rendr", "road-shift"], "rendr"),
    "no sequence": (["render"], "SEQUENCE"),
    "an unknown kind of list": (["list", "colours"], "colours"),
    "info of nothing": (["info", "nowhere"], "nowhere: no such sequence"),
    "info of a folder that is no run": (["info", "."], "run.json: is missing"),
    "measure of a folder that is no run": (["measure", "."], "run.json"),
    "report of a folder that is no run": (["report", "."], "run.json"),
}


@pytest.mark.parametrize("what", REFUSED)
def test_refused_with_exit_code_2_and_a_reason(swimlab, what, tmp_path):
    words, message = REFUSED[what]
    code, out, err = swimlab(*words)
    assert code == 2
    assert out == ""
    assert message in " ".join(err.split())
    assert "Traceback" not in err
    assert list(tmp_path.iterdir()) == []


BAD_FILES = {
    "an unknown key": ("framse = 3", "framse: unknown key (did you mean 'frames'?"),
    "a wrong type": ('fps = "fast"', "fps: should be a valid number"),
    "an unknown technique": ("[techniques.tls]\nsize = 64", "techniques.tls: unknown technique (did you mean 'tsl'?"),
    "an unknown setting": ("[techniques.tsl]\nsise = 64", "techniques.tsl.sise: unknown key (did you mean 'size'?"),
    "a bad setting": ("[techniques.tsl]\nsize = 100", "techniques.tsl.size: must be a power of two, as 64 or 128"),
    "a fade that ends before it starts": ("[techniques.lod-hack]\nstart = 3\nend = 2", "fade must end after it starts"),
    "an unknown model": ('[scene.material]\nbrdf = "blin-phong"', "scene.material.brdf: there is no 'blin-phong'"),
    "a map that is not there": ('[scene.material]\nalbedo = "gone.exr"', "scene.material.albedo: "),
    "no TOML": ("[scene", "not TOML"),
}


@pytest.mark.parametrize("what", BAD_FILES)
def test_bad_files_are_refused_by_file_and_key(swimlab, what, tmp_path):
    text, message = BAD_FILES[what]
    (tmp_path / "bad.toml").write_text(f'version = 1\nname = "bad"\n{text}\n', encoding="utf-8")
    code, out, err = swimlab("render", "bad.toml", "-t", "pixel-point", "--frames", "0")
    assert (code, out) == (2, "")
    assert message in err
    assert {path.name for path in tmp_path.iterdir()} == {"bad.toml"}


def test_every_mistake_is_named_at_once(swimlab, tmp_path):
    (tmp_path / "bad.toml").write_text('version = 1\nname = "bad"\nfps = -1\n[camera]\nfov = 200\n', encoding="utf-8")
    code, _, err = swimlab("info", "bad.toml")
    assert code == 2
    lines = err.splitlines()
    assert len(lines) == 2
    assert all(line.startswith("swimlab: bad.toml: ") for line in lines)


def test_an_output_that_cannot_be_written_is_named_as_it_was_given(swimlab, tiny, tmp_path):
    (tmp_path / "taken").write_text("in the way", encoding="utf-8")
    code, out, err = swimlab("render", tiny, "-t", "pixel-point", "-o", "taken/run")
    assert (code, out) == (2, "")
    assert err.startswith("swimlab: taken/run")
    assert err.endswith(": cannot be written: taken is a file, not a folder\n")


def test_interrupts_have_their_own_exit_code(swimlab, tiny, tmp_path, monkeypatch):
    def interrupted(*_, **__):
        raise KeyboardInterrupt

    monkeypatch.setattr("swimlab.render.renderer.write_frame", interrupted)
    code, out, err = swimlab("render", tiny, "-t", "pixel-point", "-o", "out")
    assert (code, out) == (130, "")
    assert "interrupted" in err
    assert {path.name for path in (tmp_path / "out").rglob("*.*")} == {"run.json", "0000.exr"}


@pytest.mark.parametrize("module", ["cyclopts", "swimlab.cli.render_command"])
def test_an_interrupt_while_libraries_are_loaded_shows_no_traceback(module):
    script = f"""
import sys
class Interrupt:
    def find_spec(self, name, *_):
        if name == {module!r}:
            raise KeyboardInterrupt
sys.meta_path.insert(0, Interrupt())
from swimlab.__main__ import main
main()
"""
    ended = subprocess.run([sys.executable, "-c", script, "render"], capture_output=True, text=True, check=False)
    assert ended.returncode == 130
    assert "Traceback" not in ended.stderr


def test_the_doctor_finds_this_machine_well(swimlab):
    code, out, _ = swimlab("doctor")
    assert code == 0
    assert [line.split(":")[0] for line in out.splitlines()] == [f"ok    {name}" for name in CHECKS]


def test_the_doctor_names_what_is_broken(swimlab, monkeypatch):
    def broken():
        raise RuntimeError("no disk")

    monkeypatch.setitem(CHECKS, "a disk", broken)
    for name in [name for name in CHECKS if name != "a disk"]:
        monkeypatch.delitem(CHECKS, name)
    code, out, _ = swimlab("doctor")
    assert (code, out) == (2, "FAIL  a disk: RuntimeError: no disk\n")


def test_the_schema_is_json(swimlab):
    code, out, _ = swimlab("schema")
    assert code == 0
    schema = json.loads(out)
    assert schema["$schema"].startswith("https://json-schema.org/")
    assert set(schema["properties"]["techniques"]["properties"]) == set(techniques())


@pytest.mark.parametrize(
    ("kind", "required"),
    [
        ("sequence", {"version", "name"}),
        ("shot", {"version", "name", "builds"}),
        ("gate", {"version", "rule"}),
        ("sweep", {"version", "name", "sequences", "techniques"}),
    ],
)
def test_every_kind_of_file_has_a_schema_whose_keys_are_all_explained(swimlab, kind, required):
    code, out, _ = swimlab("schema", kind)
    assert code == 0
    described = json.loads(out)
    assert required <= set(described["required"])
    for table in (described, *described["$defs"].values()) if "$defs" in described else (described,):
        for key, value in table.get("properties", {}).items():
            assert "description" in value or "$ref" in value or "description" in str(value), (kind, key)


def test_a_gate_files_schema_takes_what_a_gate_file_takes():
    """As an editor would: shares, amounts and both."""
    from jsonschema import Draft202012Validator

    from swimlab.gate.rules import gate_schema

    validator = Draft202012Validator(gate_schema())
    for given, good in (("5%", True), (0.001, True), (["5%", 0.001], True), (-1, False), ("five", False), ([], False)):
        gate = {"version": 1, "baseline": {"file": "a.json"}, "rule": [{"metric": "*", "max_increase": given}]}
        assert validator.is_valid(gate) == good, given


@pytest.mark.parametrize(
    ("kind", "names"),
    [("techniques", techniques()), ("brdfs", brdfs()), ("sequences", library()), ("conventions", PRESETS)],
)
def test_lists_name_all_there_is(swimlab, kind, names):
    code, out, _ = swimlab("list", kind)
    assert code == 0
    first = [line.split()[0] for line in out.splitlines()[1:] if line and not line.startswith(" ")]
    assert first == list(names)


@pytest.mark.parametrize("kind", ["colorspaces", "views"])
def test_names_of_opencolorio_are_listed(swimlab, kind):
    known = {"colorspaces": ("linear", "srgb", *space_names()), "views": view_names()}[kind]
    rows = json.loads(swimlab("list", kind, "--json")[1])
    assert [row[kind.removesuffix("s")] for row in rows] == list(known)


def test_metrics_are_listed_with_unit_and_direction(swimlab):
    from metrics import METRICS

    code, out, _ = swimlab("list", "metrics")
    assert code == 0
    named = [line.split()[0] for line in out.splitlines()[1:] if line[0] != " "]
    assert named == [name for name in METRICS if not name.endswith((".near", ".mid", ".far"))]
    assert "squared error of the radiance; also .near, .mid, .far" in " ".join(out.split())
    assert all(word in out.splitlines()[0] for word in ("metric", "unit", "better"))
    whole = json.loads(swimlab("list", "metrics", "--json")[1])
    assert [row["metric"] for row in whole] == list(METRICS)
    assert [row["source"] for row in whole] == [metric.source for metric in METRICS.values()]


def test_sequences_are_listed_with_what_they_are(swimlab, monkeypatch):
    monkeypatch.setenv("COLUMNS", "200")
    code, out, _ = swimlab("list", "sequences")
    assert code == 0
    assert all(len(line.split(maxsplit=4)) == 5 and line.rstrip()[-1] == "." for line in out.splitlines()[1:])
    assert ".toml" not in out
    whole = json.loads(swimlab("list", "sequences", "--json")[1])
    assert [row["file"] for row in whole] == [str(path) for path in library().values()]
    assert all(path.read_text(encoding="utf-8").startswith("# ") for path in library().values())


def test_a_list_of_nothing_names_its_choices(swimlab):
    code, out, err = swimlab("list")
    assert (code, out) == (2, "")
    assert "techniques, sequences, brdfs, metrics, conventions, colorspaces, views" in err


def test_a_reader_that_is_gone_is_no_complaint():
    words = [sys.executable, "-c", "from swimlab.cli.main import main; main()", "list", "techniques", "--json"]
    process = subprocess.Popen(words, stdout=subprocess.PIPE, stderr=subprocess.PIPE)
    process.stdout.close()
    assert process.stderr.read() == b""
    process.stderr.close()
    assert process.wait() == 2


def test_info_prints_a_sequence_with_every_default(swimlab):
    code, out, _ = swimlab("info", "road-drive")
    assert code == 0
    for line in ('name = "road-drive"', "camera.fov = 50.0", 'motion.kind = "drive"', "size = [640, 360]"):
        assert line in out.splitlines()


def test_info_names_whom_a_note_is_of_and_says_it_once(swimlab, tmp_path):
    one, other = entry(technique="a"), entry(technique="b")
    write_scores(tmp_path / "run", one | {"notes": ["short", "dark"]}, other | {"notes": ["short", "short"]})
    notes = [line for line in swimlab("info", "run")[1].splitlines() if line.startswith("note")]
    assert notes == ["note        a and b: short", "note        a: dark"]


def test_a_fault_is_no_failed_gate(swimlab, monkeypatch):
    """What nobody foresaw ends with 2 and its traceback: exit code 1 says that a gate failed."""

    def broken():
        raise RuntimeError("a technique's kernel does not compile")

    monkeypatch.setattr("swimlab.cli.list_command.techniques", broken)
    code, _, err = swimlab("list", "techniques")
    assert code == 2
    assert "RuntimeError: a technique's kernel does not compile" in err
    assert err.splitlines()[-1].startswith("swimlab: could not finish: a fault")
