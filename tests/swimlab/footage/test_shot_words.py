"""What commands say of shots: in the words of their files, and of frames that changed by name."""

import json
import re
import shutil
from dataclasses import fields

import numpy as np
import pytest
from small_shot import COUNT, SHOT, SIDE, write_picture, write_shot

from swimlab.cli.footage_options import Footage
from swimlab.footage.keys import as_keys
from swimlab.footage.shot import is_shot, load_shot, shot_schema
from swimlab.runs.frames import write_channels


@pytest.fixture
def shot(tmp_path):
    return write_shot(tmp_path)


@pytest.fixture
def run(swimlab, shot):
    code, _, err = swimlab("measure", shot, "-o", shot.parent / "run", "-q")
    assert code == 0, err
    return shot.parent / "run"


@pytest.mark.parametrize("typo", ["[build.", "[bulids."])
def test_a_slip_of_the_pen_is_told_as_one_of_a_shot_file(swimlab, shot, typo):
    shot.write_text(SHOT.replace("[builds.", typo).replace("[reference]", "[referense]"), encoding="utf-8")
    code, _, err = swimlab("study", shot, "-o", "run")
    assert code == 2
    assert f"{typo[1:-1]}: unknown key (did you mean 'builds'?" in err
    assert "referense: unknown key (did you mean 'reference'?" in err
    assert "scene" not in err


def test_a_sequence_with_a_stray_table_stays_a_sequence(tmp_path):
    path = tmp_path / "road.toml"
    path.write_text('version = 1\nname = "road"\n[build.x]\n[motion]\nkind = "shift"\n[scene]\n', encoding="utf-8")
    assert not is_shot(path)


def test_messages_speak_of_keys(swimlab, shot):
    shot.write_text(SHOT.replace("[1.0, 0.0]", "[-1.0, 0.0]"), encoding="utf-8")
    code, _, err = swimlab("study", shot, "-o", "run")
    assert code == 2
    assert "motion.velocity = [1, " in err
    assert "motion.unverified = true" in err
    assert f"swimlab: {shot}: one: motion: " in err
    assert not re.search(r"--[a-z]", err)


def test_notes_speak_of_keys(swimlab, shot):
    shot.write_text(SHOT.replace("[motion]\nvelocity = [1.0, 0.0]\n", "[motion]\nestimate = true\n"), encoding="utf-8")
    code, _, err = swimlab("study", shot, "-o", "run")
    assert code == 0, err
    assert "viewing.pixels_per_degree" in err
    assert not re.search(r"--[a-z]", err)


def test_keys_stand_for_options():
    said = "mask with --mask, --skip-bad-frames; --colorspace, --reference-part, --motion-jitter-in; oiiotool --flatten"
    keys = "mask with mask, skip_bad_frames = true; colorspace, reference.part, motion.jitter_in; oiiotool --flatten"
    assert as_keys(said) == keys
    assert (
        as_keys("--motion -0.5,1e-3 or --motion estimate") == "motion.velocity = [-0.5, 1e-3] or motion.estimate = true"
    )


def test_a_range_stands_for_its_option():
    assert as_keys("those with --frames 1-47x2") == 'those with frames = "1-47x2"'


def test_a_build_of_another_size_is_named_with_both_sizes(swimlab, shot):
    for t in range(COUNT):
        write_picture(shot.parent / "two" / f"{t}.exr", np.ones((32, 40, 3)))
    code, _, err = swimlab("study", shot, "-o", "run")
    assert code == 2
    assert re.search(r"two: \S+two\S* is 40x32 px, the reference \S+ref\S* 48x48 px", err)
    assert "the test" not in err


def test_motion_without_the_first_frame_says_which_frames_can_be_measured(swimlab, shot):
    for t in range(1, COUNT):
        vectors = np.broadcast_to(np.float32([1, 0]), (SIDE, SIDE, 2))
        write_channels(shot.parent / "mv" / f"{t}.exr", vectors, ("motion.X", "motion.Y"), half=False, metadata={})
    text = SHOT.replace("velocity = [1.0, 0.0]", 'frames = "mv"')
    shot.write_text(text, encoding="utf-8")
    code, _, err = swimlab("study", shot, "-o", shot.parent / "run")
    remedy = 'frames = "1-2"'
    assert (code, f"they must match: measure those that both have with {remedy}" in err) == (2, True)
    shot.write_text(text.replace("version = 1\n", f"version = 1\n{remedy}\n"), encoding="utf-8")
    code, _, err = swimlab("measure", shot, "-q")
    assert code == 0, err


def test_what_stands_for_an_option_is_a_key_of_a_shot():
    skipped = {"test", "name", "build", "sequence", "reference", "motion", "depth", "mask", "range-of-frames"}
    options = {field.name.replace("_", "-") for field in fields(Footage)} - skipped
    schema = shot_schema()
    places = {"": "Pictures", "reference": "Pictures", "motion": "Vectors", "depth": "Depth", "mask": "Mask"}
    tables = {table: set(schema["$defs"][name]["properties"]) for table, name in places.items()}
    tables |= {table: set(schema["$defs"][table.capitalize()]["properties"]) for table in ("viewing", "display")}
    tables[""] |= set(schema["properties"])
    for option in options:
        table, _, key = as_keys(f"--{option}").removesuffix(" = true").rpartition(".")
        assert key in tables[table], option


def test_measure_takes_a_shot_file_and_render_says_what_does(swimlab, shot, run):
    code, out, err = swimlab("measure", shot, "--json", "-q")
    assert code == 0, err
    written = json.loads((run / "scores.json").read_text(encoding="utf-8"))["sequences"]
    assert [each["scores"] for each in json.loads(out)["sequences"]] == [each["scores"] for each in written]
    code, _, err = swimlab("measure", shot, "--motion", "1,0")
    assert (code, "--motion: is for frames of your own, with --test; a shot file has keys for it" in err) == (2, True)
    code, _, err = swimlab("render", shot, "-t", "tsl")
    assert (code, f"swimlab study {shot}" in err) == (2, True)


def test_gates_warn_of_sources_by_name_and_judge_all_the_same(swimlab, shot, run):
    gate = shot.parent / "gate.toml"
    gate.write_text(
        'version = 1\n[baseline]\nfile = "base.json"\n[[rule]]\nmetric = "budget.flicker"\nmax = 1.0\n',
        encoding="utf-8",
    )
    changed, gone = shot.parent / "two" / "2.exr", shot.parent / "ref" / "1.exr"
    changed.write_bytes(b"other")
    gone.unlink()
    for words in (("baseline", "update", gate, run), ("gate", gate, run)):
        code, _, err = swimlab(*words)
        assert code == 0, err
        assert f"warning: {run}: {changed}: has changed since it was measured (two)" in err
        assert f"warning: {run}: {gone}: is gone since it was measured (reference)" in err
    code, out, _ = swimlab("info", run)
    assert (code, f"beware      {gone}: is gone" in out) == (0, True)
    code, out, _ = swimlab("info", run, "--json")
    assert [text.partition(": ")[0] for text in json.loads(out)["changes"]] == [str(changed), str(gone)]


def test_a_draft_drops_no_second_input_of_a_kind(swimlab, shot):
    shutil.copytree(shot.parent / "ref", shot.parent / "truth")
    assert swimlab("init-shot", shot.parent)[0] == 0
    drafted = shot.parent / "shot.toml"
    assert '# frames = "truth/%01d.exr"  # 3 frames, 48x48; as likely, choose one' in drafted.read_text(
        encoding="utf-8"
    )
    assert load_shot(drafted).reference.frames == "ref/%01d.exr"
