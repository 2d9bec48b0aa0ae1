"""The self-test passes, and says so when a measure is off."""

import json

import pytest

from swimlab.cli.selftest_command import selftest_command
from swimlab.studies.selftest import Check


def test_everything_is_as_expected(capsys):
    assert selftest_command(json_output=True) == 0
    found = json.loads(capsys.readouterr().out)
    assert all(check["ok"] for check in found)
    clips = " ".join(check["clip"] for check in found)
    for name in ("glued", "screen-fixed", "swimming", "noise", "blinking", "zone plate", "16 samples", "turning"):
        assert name in clips


@pytest.mark.parametrize(("value", "expected"), [(0.2, 0.1), (None, 0.1), (0.1, None)])
def test_one_that_is_off_is_shown_and_exits_1(value, expected, monkeypatch, capsys):
    wrong = [Check("a clip", "a score", 0.1, 0.1, 0.0), Check("a clip", "another", value, expected, 0.01)]
    monkeypatch.setattr("swimlab.cli.selftest_command.checks", lambda: iter(wrong))
    assert selftest_command() == 1
    shown = capsys.readouterr().out
    assert "OFF" in shown
    assert "2 checks, 1 OFF" in shown


def test_a_refused_score_that_should_be_is_good():
    assert Check("a clip", "a score", None, None, 0.0).good
