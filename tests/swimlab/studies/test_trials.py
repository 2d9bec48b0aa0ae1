"""Trials in memory: the scores of a run folder, counted samples and times in turns."""

import pytest

from metrics import Measurement
from sequences import load
from swimlab.render.plan import Plan
from swimlab.render.run import render_run
from swimlab.runs.record import RunError
from swimlab.scoring.measure import measure_run
from swimlab.studies.trials import Stage, Trial, Variant

SHORT = {"road": {"length": 24.0}}
SHIFT = load("road-shift").with_changes(size=(96, 64), frames=3, scene=SHORT)
DRIVE = load("road-drive").with_changes(size=(96, 64), frames=3, scene=SHORT)
SCALE = load("road-scale").with_changes(size=(96, 64), frames=3, motion={"kind": "scale", "to": 0.5}, scene=SHORT)


@pytest.mark.parametrize(
    ("sequence", "technique", "settings"),
    [
        (SHIFT, "pixel-aniso", {"anisotropy": 2}),
        (SHIFT, "tsl", {"size": 128, "texels": "needed", "inputs": "vmf"}),
        (DRIVE, "taa", {"preroll": 2}),
        (SCALE, "pixel-point", {}),
    ],
)
def test_a_trial_has_the_scores_of_a_run_folder(launcher, tmp_path, sequence, technique, settings):
    set_up = sequence.with_changes(techniques={technique: settings})
    render_run(Plan(set_up, (technique, "reference"), (0, 1, 2), samples=4, half=False), tmp_path)
    expected = measure_run(tmp_path)["sequences"][0]
    trial = Stage(sequence, range(3), samples=4, launcher=launcher).measure(Variant("mine", technique, settings))
    scores = {name: value for name, value in expected["scores"].items() if name != "quantisation.floor"}
    assert trial.measurement.scores == scores
    assert any(name.startswith(("budget.mse", "scale.rmse")) for name in scores)
    assert trial.measurement.errors == {k: v for k, v in expected["errors"].items() if k in scores}
    assert trial.measurement.curves == expected["curves"]


def test_settings_reach_the_technique_and_samples_are_counted(launcher):
    stage = Stage(SHIFT, range(2), samples=4, launcher=launcher)
    one, four = (stage.measure(Variant(str(n), "supersample", {"samples": n}), names=["budget"]) for n in (1, 4))
    assert one.shaded == sum(picture.shaded for picture in stage.pictures(one.variant)) / 2 > 0
    assert four.shaded == pytest.approx(4 * one.shaded, rel=0.1)
    assert four.rms() < one.rms()
    assert set(one.measurement.scores) == {name for name in one.measurement.scores if name.startswith("budget")}


def test_pictures_that_are_there_are_not_rendered_again(launcher, monkeypatch):
    stage = Stage(SHIFT, range(2), samples=4, launcher=launcher)
    variant = Variant("point", "pixel-point")
    pictures = stage.pictures(variant)
    expected = stage.measure(variant).measurement
    monkeypatch.setattr(stage, "pictures", None)
    assert stage.measure(variant, pictures=pictures).measurement == expected


@pytest.mark.parametrize(("sequence", "frames"), [(SHIFT, [1, 2, 3]), (SCALE, [0, 0, 0])])
def test_times_are_taken_in_turns(launcher, monkeypatch, sequence, frames):
    """A first round that compiles, then as many as asked, each a frame of every variant."""
    asked = []
    begin = Variant.begin

    def begun(variant):
        render = begin(variant)

        def rendered(shot):
            asked.append((variant.label, shot.frame))
            return render(shot)

        return rendered

    monkeypatch.setattr(Variant, "begin", begun)
    variants = [Variant("a", "pixel-point"), Variant("b", "taa", {"preroll": 1})]
    times = Stage(sequence, range(2), samples=4, launcher=launcher).time(variants, 3)
    assert {label: len(each) for label, each in times.items()} == {"a": 3, "b": 3}
    assert min(min(each) for each in times.values()) > 0
    assert asked == [(label, frame) for frame in [0, *frames] for label in "ab"]


def test_what_cannot_be_tried_is_refused(launcher):
    with pytest.raises(RunError, match="follow each other"):
        Stage(SHIFT, [0, 2], samples=4, launcher=launcher)
    with pytest.raises(RunError, match="follow each other"):
        Stage(SHIFT, [], samples=4, launcher=launcher)
    with pytest.raises(ValueError, match="anisotrop"):
        Variant("x", "pixel-aniso", {"anisotrop": 2}).begin()


def test_roots_of_the_budget(tolerance):
    found = Measurement(scores={"budget.mse": 0.04, "budget.mse.far": 0.09}, errors={"budget.mse": 0.004})
    trial = Trial(Variant("x", "tsl"), found, 1.0)
    assert trial.rms() == pytest.approx(0.2, rel=tolerance("closed form"))
    assert trial.rms("mse", "far") == pytest.approx(0.3, rel=tolerance("closed form"))
    assert trial.rms("flicker") is None
    # d sqrt(m) = dm / (2 sqrt(m))
    assert trial.standard_error() == pytest.approx(0.01, rel=tolerance("closed form"))
    assert trial.standard_error("mse", "far") is None
