"""The report on other metrics: errors of one energy, judges that read what is known, and what the tables say."""

import json

import numpy as np
import pytest

from metrics import Clip
from metrics.synthetic import KINDS
from swimlab.scoring.peer import PeerError, displayed
from swimlab.studies.other_metrics import clips
from swimlab.studies.other_metrics import report as study
from swimlab.studies.other_metrics.judges import OTHERS, OURS, Judge
from swimlab.studies.trials import Variant

JUDGES = {judge.name: judge for judge in (*OTHERS, *OURS)}


@pytest.fixture
def small(monkeypatch):
    monkeypatch.setattr(clips, "SIZE", (80, 64))
    monkeypatch.setattr(clips, "COUNT", 6)


def energies(case):
    return [np.mean((np.asarray(case.test.frame(t)) - case.reference.frame(t)) ** 2) for t in range(case.test.count)]


def test_errors_of_a_comparison_have_one_energy(small, tolerance):
    five = clips.five_errors()
    assert [case.name for case in five] == list(KINDS)
    for case in five:
        rms = np.sqrt(np.mean(energies(case)))
        assert rms == pytest.approx(clips.LEVEL * clips.ERROR, rel=tolerance("equal rms"))
    for calm, wild in clips.pairs():
        shown = [JUDGES["PSNR, dB"].value(case.test, case.reference) for case in (calm, wild)]
        assert shown[0] == pytest.approx(shown[1], abs=tolerance("whole decibels"))
        assert np.mean(energies(wild)) > 0


def test_a_calm_error_of_a_pair_moves_with_the_disc(small, tolerance):
    """By its own motion it is the same in every frame; by the shift theorem its waves keep their energy."""
    calm, _ = clips.pairs()[0]
    errors = [np.asarray(calm.test.frame(t), float) - calm.reference.frame(t) for t in (0, 4)]
    waves = [np.abs(np.fft.fft2(error, axes=(0, 1)))[1:20, 1:20] for error in errors]
    assert waves[0] == pytest.approx(waves[1], rel=0, abs=tolerance("single precision") * waves[0].max())


def test_made_clips_are_shown_without_clipping(small):
    for case in (*clips.five_errors(), *(case for pair in clips.pairs() for case in pair)):
        pictures = np.array([clip.frame(t) for clip in (case.test, case.reference) for t in (0, 5)])
        assert pictures.min() > 0
        assert pictures.max() < 1


def flat(level, count=3):
    return Clip(lambda _: np.full((64, 64, 3), level, np.float32), count, motion=(0.0, 0.0))


def test_judges_read_what_is_known(tolerance):
    reference, test = flat(0.2), flat(0.3)
    apart = abs(float(displayed(test, 0)[0, 0, 0]) - float(displayed(reference, 0)[0, 0, 0]))
    psnr = JUDGES["PSNR, dB"]
    assert psnr.value(test, reference) == pytest.approx(-20 * np.log10(apart), rel=tolerance("float32"))
    assert psnr.worse(psnr.value(test, reference)) == pytest.approx(apart, rel=tolerance("float32"))
    blinks = Clip(lambda t: np.full((64, 64, 3), 0.3 if t % 2 else 0.2, np.float32), 3, motion=(0.0, 0.0))
    for name in ("frame difference", "change of the error"):
        assert JUDGES[name].value(test, reference) == 0
        assert JUDGES[name].value(blinks, reference) == pytest.approx(apart, rel=tolerance("float32"))


def test_warping_takes_motion_out_of_the_frame_difference(small):
    case = clips.five_errors()[0]
    warped, plain = (JUDGES[name].value(case.test, case.reference) for name in ("warping error", "frame difference"))
    assert 0 < warped < 0.8 * plain


def test_pairs_are_in_order_where_they_are_told_apart():
    judge = Judge("points", "", lambda *_: 0.0, lambda value: 10 - value)
    column = {"good": 9.0, "same": 8.99, "bad": 7.0, "perfect": 10.0, "absent": "is not installed"}
    assert study.in_order(judge, column, [("good", "bad"), ("good", "same"), ("bad", "good")]) == "1 of 3"
    assert study.in_order(judge, column, [("good", "absent")]) is None
    assert study.times(judge, column, "good", "bad") == 3
    assert study.times(judge, column, "perfect", "bad") == np.inf
    assert study.times(judge, column, "perfect", "perfect") is None
    assert study.times(judge, column, "absent", "bad") is None


def test_the_report_ranks_and_says_what_did_not_run(small, swimlab, monkeypatch, tmp_path):
    def lacking(*_):
        raise PeerError("--peers best: is not installed")

    absent = Judge("the best", "by magic", lacking)
    monkeypatch.setattr(study, "OTHERS", (JUDGES["PSNR, dB"], JUDGES["change of the error"], absent))
    monkeypatch.setattr(study, "OURS", (JUDGES["budget.flicker"], JUDGES["new.mse"]))
    monkeypatch.setattr(study, "OTHER_TECHNIQUES", ())
    monkeypatch.setattr(study, "LADDER", tuple(Variant(f"{n}", "supersample", {"samples": n}) for n in (1, 4)))
    code, out, err = swimlab("bench", "metrics", "-o", ".", "--size", "96x64", "--frames", "4", "--json", "-q")
    assert (code, err) == (0, "")
    tables = json.loads(out)["tables"]
    answer = {row["metric"]: row for row in tables["answer"]}
    assert answer["PSNR, dB"]["noise, times glued"] == pytest.approx(1, abs=0.05)
    assert answer["PSNR, dB"]["five errors in order"].startswith("0 of")
    assert answer["budget.flicker"]["noise, times glued"] == "> 1,000"
    assert answer["new.mse"]["ghost trail, times glued"] > study.TOLD  # it stands in pixels that have come into view
    assert {row["samples in order"] for name, row in answer.items() if name in ("PSNR, dB", "budget.flicker")} == {
        "1 of 1"
    }
    assert set(answer["the best"].values()) == {"the best", None}
    assert tables["ways"][2]["ran"] == "--peers best: is not installed"
    page = (tmp_path / "other-metrics.md").read_text(encoding="utf-8")
    assert "Blind to all of it, or more pleased by what flickers: PSNR, dB." in page
    assert [row["error"] for row in tables["made clips"]][:5] == list(KINDS)
