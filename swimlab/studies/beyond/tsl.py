"""Texture-space lighting at lower cost: smaller targets, moment chains inside, and only the texels that are seen."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from math import inf

import numpy as np

from metrics.bands import BANDS, describe
from swimlab.render.techniques.tsl import INPUTS
from swimlab.report.charts import Axis, Line
from swimlab.studies.page import Cell, Figure, Section, Table, chart
from swimlab.studies.sheet import contact_sheet
from swimlab.studies.trials import Stage, Trial, Variant

SIZES = (1024, 512, 256, 128)
COARSER = (-1, 0, 1, 2)
MOMENTS = "vmf"
"""The moment chain inside targets that are chosen by footprint."""

SHARES = (4, 16, 64)
"""A part of the full texels that may be shaded."""
WANTED = 1.1
"""Times full targets' error that a saving may cost."""


def fixed(size: int, inputs: str) -> Variant:
    """All targets of one size."""
    return Variant(f"{size} {inputs}", "tsl", {"size": size, "inputs": inputs})


def needed(size: int, inputs: str) -> Variant:
    """Targets of one size, of which only texels under footprints are shaded, at the level these need."""
    return Variant(f"needed of {size}, {inputs}", "tsl", {"size": size, "inputs": inputs, "texels": "needed"})


def fitted(coarser: int) -> Variant:
    """Targets as large as the segment's footprints need, or some levels coarser."""
    settings = {"inputs": MOMENTS, "sizes": "fitted", "coarser": coarser}
    return Variant(f"fitted, {MOMENTS}, {coarser:+d} levels" if coarser else f"fitted, {MOMENTS}", "tsl", settings)


FULL = fixed(SIZES[0], "box")
FIXED = tuple(fixed(size, inputs) for inputs in ("box", MOMENTS) for size in SIZES[1:])
NEEDED = {inputs: tuple(needed(size, inputs) for size in SIZES[:3]) for inputs in ("box", MOMENTS)}
FITTED = tuple(fitted(coarser) for coarser in COARSER)
CHOSEN = (*NEEDED["box"], *NEEDED[MOMENTS], *FITTED)
SHOWN = (*FIXED[::-1], fitted(1), fitted(0), needed(SIZES[0], MOMENTS), FULL)
SHOWN_FRAMES = 2


@dataclass(frozen=True)
class Saving:
    """Texels shaded a frame, all and only the visible, and the largest difference of a value of the pictures."""

    everything: int
    visible: int
    difference: float


@dataclass(frozen=True)
class Costs:
    """Trials of full and cheaper targets by label, and their median milliseconds a frame."""

    trials: Mapping[str, Trial]
    ms: Mapping[str, float]


def sizes_study(stage: Stage) -> dict[str, Trial]:
    """Fixed targets of every size under every kind of inputs, by label."""
    variants = [fixed(size, inputs) for size in SIZES for inputs in INPUTS]
    return {variant.label: stage.measure(variant, names=["budget"]) for variant in variants}


def cost_study(stage: Stage, *, rounds: int, known: Mapping[str, Trial] | None = None) -> Costs:
    """Full targets, smaller targets, and targets chosen by footprints. known: trials that this stage has made
    already."""
    variants = [FULL, *FIXED, *CHOSEN]
    times = stage.time(variants, rounds)
    ms = {label: float(np.median(values)) for label, values in times.items()}
    found = known or {}
    trials = {v.label: found.get(v.label) or stage.measure(v, names=["budget"]) for v in variants}
    return Costs(trials, ms)


def saving(stage: Stage) -> Saving:
    """What shading the visible texels alone saves, and changes."""
    every, visible = (stage.pictures(Variant(way, "tsl", {"texels": way})) for way in ("all", "visible"))
    difference = max(float(np.abs(a.rgba - b.rgba).max()) for a, b in zip(every, visible, strict=True))
    count = [round(float(np.mean([picture.shaded for picture in each]))) for each in (every, visible)]
    return Saving(count[0], count[1], difference)


def sheet(stage: Stage) -> Figure:
    """The settings in pictures."""
    shown = {variant.label: [picture.rgba for picture in stage.pictures(variant)[:SHOWN_FRAMES]] for variant in SHOWN}
    shown["reference"] = [picture.rgba for picture in stage.reference[:SHOWN_FRAMES]]
    return Figure(
        "tsl.png",
        "Texture-space lighting under several settings, two details in consecutive frames, full targets and the "
        "reference last. Near the eye a small target is magnified; far from it, what its inputs lost on the way shows.",
        contact_sheet(shown, stage.geometry[0].depth),
    )


def section(
    sizes: Mapping[str, Mapping[str, Trial]],
    savings: Mapping[str, Saving],
    costs: Mapping[str, Costs],
    picture: Figure,
) -> Section:
    """What the studies show; `sizes` by size of the picture, `savings` and `costs` by sequence."""
    near, mid, far = (describe(band) for band in BANDS)
    parts: list[str | Table | Figure] = [
        "Texture-space lighting shades a target of 1024x1024 texels for each 8 m of road in sight and filters the "
        "light. That is close to the reference and shades far more texels than there are pixels. What of it can be "
        "saved? Three ways: smaller targets for all, with inputs filtered as they are (`box`) or as moments that keep "
        "the roughness; shading only texels under some pixel's footprint; and shading these at the level the footprint "
        "needs. All ratios are of rms errors to full targets'.",
        "### Smaller targets for all",
        f"To see: the split by distance (near is {near}, mid {mid}, far {far}). Where a pixel holds many texels, "
        "moments can make up for what a smaller target loses. Where a texel of a smaller target spans several pixels, "
        "as it does near the eye, resolution is lost, which no chain of moments brings back. A texel of a target of "
        "1024 is one of the map's: there inputs differ by the shape of their highlight alone.",
    ]
    for size, trials in sizes.items():
        parts += [f"Pictures of {size}:", _sizes_table(f"tsl sizes {size}", trials)]
    parts += [
        "### Only what is seen",
        'Leaving out texels under no footprint (`texels = "visible"`) must not change the picture; the difference is '
        "the largest of any value.",
        _savings_table(savings),
        "### Only what is needed",
        "`needed` shades each tile of texels at the finest level that a footprint over it reads; `fitted` gives each "
        "segment the smallest target that its footprints do not magnify, or one some levels coarser.",
    ]
    for sequence, cost in costs.items():
        parts += [f"`{sequence}`:", _costs_table(sequence, cost), _frontier(sequence, cost)]
        parts.append(_verdict(sequence, cost))
    parts += ["How near to full targets one comes with a part of their texels:", _targets(costs), picture]
    return Section("Affordable texture-space lighting", parts)


def answers(costs: Mapping[str, Costs]) -> list[str]:
    """What can be saved, in words, a line a sequence."""
    return [f"**What texture-space lighting can save** on `{name}`: {_saved(cost)}." for name, cost in costs.items()]


def _saved(costs: Costs) -> str:
    full = costs.trials[FULL.label]
    said = []
    for share in SHARES[:2]:
        chosen, plain = best(costs, CHOSEN, share), best(costs, FIXED, share)
        if chosen is None or plain is None:
            continue
        worst = max(BANDS, key=lambda band: ratio(plain, full, "mse", band) or 0.0)
        said.append(
            f"with at most 1/{share} of the texels, chosen by footprint, the error is {ratio(chosen, full):.2f} times "
            f"that of full targets (`{chosen.variant.label}`, {_within(chosen, full)}), with smaller targets for all "
            f"{ratio(plain, full):.2f} times (`{plain.variant.label}`, {_within(plain, full)}; worst is {worst}, "
            f"{ratio(plain, full, 'mse', worst):.2f} times)"
        )
    return "; ".join(said) or "nothing"


def _within(trial: Trial, full: Trial) -> str:
    return f"{'within' if (ratio(trial, full) or inf) <= WANTED else 'beyond'} {WANTED:g}"


def ratio(trial: Trial, full: Trial, part: str = "mse", band: str | None = None) -> float | None:
    """Rms of a part of the error over that of full targets."""
    mine, whole = trial.rms(part, band), full.rms(part, band)
    return None if mine is None or not whole else mine / whole


def best(costs: Costs, variants: Sequence[Variant], share: int) -> Trial | None:
    """The closest of some variants that shade at most a part of full targets' texels."""
    full = costs.trials[FULL.label]
    able = [costs.trials[variant.label] for variant in variants]
    able = [trial for trial in able if trial.shaded <= full.shaded / share]
    return min(able, key=lambda trial: trial.rms() or 0.0, default=None)


def _ratios(trial: Trial, full: Trial) -> list[Cell]:
    bands = [ratio(trial, full, "mse", band) for band in BANDS]
    return [trial.rms(), ratio(trial, full), *bands, ratio(trial, full, "flicker")]


RATIO_HEADINGS = ("error", "of full", *BANDS, "flicker of full")


def _sizes_table(name: str, trials: Mapping[str, Trial]) -> Table:
    full = trials[FULL.label]
    rows: list[list[Cell]] = []
    for label, trial in trials.items():
        size, inputs = label.split()
        rows.append([size, inputs, round(trial.shaded), *_ratios(trial, full)])
    return Table(name, ["target", "inputs", "texels a frame", *RATIO_HEADINGS], rows)


def _savings_table(savings: Mapping[str, Saving]) -> Table:
    rows: list[list[Cell]] = [
        [f"`{sequence}`", found.everything, found.visible, found.everything / max(found.visible, 1), found.difference]
        for sequence, found in savings.items()
    ]
    return Table("tsl visible", ["sequence", "all texels", "visible", "times fewer", "largest difference"], rows)


def _costs_table(sequence: str, costs: Costs) -> Table:
    full = costs.trials[FULL.label]
    rows: list[list[Cell]] = [
        [label, round(trial.shaded), full.shaded / max(trial.shaded, 1.0), costs.ms[label], *_ratios(trial, full)]
        for label, trial in costs.trials.items()
    ]
    return Table(f"tsl cost {sequence}", ["targets", "texels a frame", "times fewer", "ms", *RATIO_HEADINGS], rows)


def _frontier(sequence: str, costs: Costs) -> Figure:
    groups = {
        "fixed, box": ([FULL, *FIXED[:3]], "#ee6677", ""),
        f"fixed, {MOMENTS}": ([FULL, *FIXED[3:]], "#ccbb44", ""),
        "needed, box": (NEEDED["box"], "#66ccee", "6 3"),
        f"needed, {MOMENTS}": (NEEDED[MOMENTS], "#4477aa", ""),
        f"fitted, {MOMENTS}": (FITTED, "#228833", ""),
    }
    lines = []
    for label, (variants, colour, dash) in groups.items():
        trials = sorted((costs.trials[variant.label] for variant in variants), key=lambda trial: trial.shaded)
        lines.append(Line(label, [t.shaded for t in trials], [t.rms() for t in trials], colour, dash))
    return chart(
        f"tsl-{sequence}.svg",
        f"{sequence}: error against texels shaded a frame; lower left is better",
        lines,
        x=Axis("texels shaded a frame", "log"),
        y=Axis("rms error", "log"),
    )


def _verdict(sequence: str, costs: Costs) -> str:
    """Which fixed targets are beaten, in words."""
    chosen = [costs.trials[variant.label] for variant in CHOSEN]

    def beaten(trial: Trial) -> bool:
        error = trial.rms() or 0.0
        return any(other.shaded <= trial.shaded and (other.rms() or 0.0) <= error for other in chosen)

    lost = [variant.label for variant in FIXED if beaten(costs.trials[variant.label])]
    kept = [variant.label for variant in FIXED if variant.label not in lost]
    text = f"Of the {len(FIXED)} smaller fixed targets {len(lost)} are beaten on `{sequence}` by one chosen by "
    text += "footprint, with no more texels and no more error"
    return text + (f"; not beaten: {', '.join(kept)}." if kept else ".")


def _targets(costs: Mapping[str, Costs]) -> Table:
    rows: list[list[Cell]] = []
    for sequence, cost in costs.items():
        full = cost.trials[FULL.label]
        for share in SHARES:
            row: list[Cell] = [f"`{sequence}`", f"1/{share}"]
            for variants in (FIXED, CHOSEN):
                trial = best(cost, variants, share)
                row += ["–", None] if trial is None else [trial.variant.label, ratio(trial, full)]
            rows.append(row)
    headings = [
        "sequence",
        "texels at most",
        "closest fixed",
        "fixed, of full",
        "closest by footprint",
        "by footprint, of full",
    ]
    return Table("tsl targets", headings, rows)
