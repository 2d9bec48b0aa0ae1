"""A name that becomes part of a path never leads out of the folder, whoever wrote it."""

import json
from pathlib import Path

import pytest
from gate_files import HASH, entry, write_gate, write_scores

from sequences.names import LONGEST, check_name
from swimlab.runs.names import check_part, file_name
from swimlab.runs.record import Record, RunError

LEADING_OUT = ("../../evil", "..", "", ".", "/evil", "a/b", "a/")


@pytest.mark.parametrize("name", [*LEADING_OUT, "a b", "-a", ".a", "a\n", "a\\b", "C:a", "é", "a" * (LONGEST + 1)])
def test_a_given_name_is_of_letters_digits_dot_dash_and_underscore(name):
    with pytest.raises(ValueError, match="name of a sequence: use "):
        check_name(name, "a sequence")
    assert check_name("A1._-", "a sequence") == "A1._-"


@pytest.mark.parametrize("name", LEADING_OUT)
def test_a_name_of_a_file_is_one_part_of_a_path(name):
    with pytest.raises(ValueError, match="is no name, it leads to another folder"):
        check_part(name, "sequence")
    assert check_part("my shot, 2 (é)", "sequence") == "my shot, 2 (é)"


@pytest.mark.parametrize("name", [*LEADING_OUT, "a\\..\\b", "C:evil", "a\0b", "a|b<c>*?\n"])
def test_a_file_stays_in_its_folder(name):
    made = file_name(name, "tsl", "budget.mse.png")
    assert Path(made).name == made
    assert not set(made) & set('/\\:*?"<>|\0\n')
    assert made.endswith("-tsl-budget.mse.png")


@pytest.mark.parametrize("name", ["../../evil", "a b"])
def test_the_option_takes_no_other_names_than_a_shot(swimlab, tmp_path, name):
    code, out, err = swimlab("measure", "--test", "f.####.exr", "--sequence", name, "-o", "runs/a")
    assert (code, out, list(tmp_path.iterdir())) == (2, "", [])
    assert err == (
        f"swimlab: --sequence: {name!r} is no name of a sequence: use letters, digits, dot, dash and underscore\n"
    )


@pytest.mark.parametrize("command", ["gate", "compare", "baseline"])
@pytest.mark.parametrize("key", ["sequence", "technique"])
def test_scores_from_elsewhere_lead_nowhere(swimlab, tmp_path, command, key):
    write_gate(tmp_path / "gate.toml", 'metric = "budget.mse"\nmax_increase = 0', baseline='file = "b.json"')
    write_scores(tmp_path / "runs" / "run", entry(**{key: "../../evil"}, budget_mse=2.0))
    words = {"gate": ("gate.toml",), "compare": ("runs/run",), "baseline": ("update", "gate.toml")}[command]
    before = set(tmp_path.rglob("*"))
    if command == "gate":
        write_gate(tmp_path / "gate.toml", 'metric = "budget.mse"\nmax = 1')
    code, out, err = swimlab(command, *words, "runs/run")
    assert (code, out) == (2, "")
    assert f"scores.json: {key} '../../evil' is no name, it leads to another folder; measure the run again" in err
    assert set(tmp_path.rglob("*")) == before


def test_a_run_from_elsewhere_leads_nowhere(tmp_path):
    record = Record({"name": "road"}, {}, HASH, None, resizes=False, provenance={}, techniques=["tsl"])
    record.write(tmp_path)
    assert Record.read(tmp_path) == record
    content = json.loads((tmp_path / "run.json").read_text(encoding="utf-8"))
    (tmp_path / "run.json").write_text(json.dumps(content | {"techniques": ["tsl", "../../evil"]}), encoding="utf-8")
    with pytest.raises(RunError, match=r"run\.json: is not a run description \(.* leads to another folder"):
        Record.read(tmp_path)
