"""Triangles thinner than a pixel: what it costs to draw them, and what to leave them out."""

from collections.abc import Sequence

from swimlab.studies.page import Section, Table
from swimlab.studies.trials import Stage, Trial, Variant

PLAIN = Variant("pixel-aniso, all drawn", "pixel-aniso")
WITHOUT = Variant("pixel-aniso, none under 1 px", "pixel-aniso", {"thinnest": 1.0})
COMPARED = (
    PLAIN,
    Variant("pixel-aniso, none under 1/2 px", "pixel-aniso", {"thinnest": 0.5}),
    WITHOUT,
    Variant("supersample, 4", "supersample"),
    Variant("supersample, 16", "supersample", {"samples": 16}),
    Variant("taa", "taa"),
    Variant("tsl", "tsl"),
)


def sliver_study(stage: Stage) -> list[Trial]:
    """Measure ways to draw slivers."""
    return [stage.measure(variant, names=["budget", "visible"]) for variant in COMPARED]


def section(trials: Sequence[Trial]) -> Section:
    """What the study shows."""
    rows = [
        [
            trial.variant.label,
            round(trial.shaded),
            *(trial.rms(part) for part in ("mse", "bias", "detail", "flicker")),
            trial.measurement.scores.get("visible.flicker"),
        ]
        for trial in trials
    ]
    by_label = {trial.variant.label: trial for trial in trials}
    return Section(
        "Slivers",
        [
            "A triangle thinner than a pixel covers a sample now and then: it twinkles. The deck: do not draw them, "
            "which trades flicker for a pattern that is missing from the picture. `road-sliver` has wires of 1 cm over "
            f"the road; leaving out triangles under a pixel {_changed(by_label, 'flicker', 'flicker')}, "
            f"{_changed(by_label, 'detail', 'lost detail')} and {_changed(by_label, 'mse', 'the whole error')}.",
            Table("slivers", ["how", "shaded a frame", "error", "bias", "detail", "flicker", "visible flicker"], rows),
        ],
    )


def _changed(trials: dict[str, Trial], part: str, name: str) -> str:
    before, after = (trials[variant.label].rms(part) for variant in (PLAIN, WITHOUT))
    if not before or after is None:
        return f"changes {name} by an unknown amount"
    if abs(after / before - 1) < 0.005:
        return f"leaves {name} as it is"
    return f"{'lowers' if after < before else 'raises'} {name} by {abs(1 - after / before):.0%}"
