"""What the order of filtering and shading does to each reflectance model: error and flicker on `road-shift`."""

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np

from metrics.kernels.launch import Launcher
from sequences import load
from swimlab.render.inputs import Maps
from swimlab.render.material import Material, read_maps
from swimlab.studies.brdfs.cost import FORMS, Form
from swimlab.studies.trials import Stage, Trial, Variant

SIZE, FRAMES, SAMPLES = (320, 180), 8, 64
"""Size of the pictures, how many, and samples a pixel of the reference."""
TECHNIQUES = (Variant("pixel-aniso", "pixel-aniso"), Variant("tsl", "tsl", {"size": 512}))
"""TSL's targets are half of what the sequence's own pictures have, as these pictures are."""
CHAINS = ("clean", "lean", "toksvig", "vmf")
"""Moment chains, of which the one with the least error is reported."""
FACTORS = ("banks", "lafortune")
"""Models to which Ks is a factor with no unit: it is scaled until the highlights are as bright as Blinn-Phong's."""


@dataclass(frozen=True)
class Quality:
    """rms of error and flicker over wholly covered pixels, as fractions of the form's mean radiance."""

    technique: str
    error: float
    flicker: float


@dataclass(frozen=True)
class Row:
    """A form's results: the factor on Ks, its mean radiance, the reference's own error as a fraction of that, and the
    techniques, the best moment chain last."""

    form: str
    strength: float
    mean: float
    floor: float
    techniques: list[Quality]


def brdf_study(launcher: Launcher, *, advance: Callable[[str], None] = lambda _: None) -> list[Row]:
    """Render and measure every form; `advance` is called with each one's label when it is done.

    Anisotropic forms have the map of twist `made:brushed`.
    """
    sequence = load("road-shift").with_changes(size=SIZE, frames=FRAMES)
    scene = sequence.scene.model_dump()

    def dressed(**changes: Any) -> dict[str, Any]:
        return scene | {"material": scene["material"] | changes}

    maps = read_maps(sequence.with_changes(scene=dressed(twist="made:brushed")))

    def stage(form: Form, strength: float, *, frames: int = FRAMES, samples: int = SAMPLES) -> Stage:
        scenery = sequence.with_changes(scene=dressed(brdf=form.brdf, parameters=form.parameters))
        material = Material(launcher, _scaled(maps, strength, twisted=form.model.anisotropic))
        return Stage(scenery, range(frames), samples=samples, launcher=launcher, material=material)

    def highlight(form: Form) -> float:
        """What the highlight adds to the mean radiance of the first frame at Ks as it is, by few samples."""
        lit, dark = (_mean(stage(form, strength, frames=1, samples=16)) for strength in (1.0, 0.0))
        return lit - dark

    rows = []
    for form in FORMS:
        free = form.brdf.removesuffix("-factored") in FACTORS
        strength = float(f"{highlight(FORMS[0]) / highlight(form):.3g}") if free else 1.0
        rows.append(_row(form, strength, stage(form, strength)))
        advance(form.label)
    return rows


def _row(form: Form, strength: float, stage: Stage) -> Row:
    """Measure a form under every technique."""
    mean = _mean(stage)

    def share(trial: Trial, part: str) -> float:
        rms = trial.rms(part)
        return float("nan") if rms is None else rms / mean

    chains = [Variant(name, name) for name in CHAINS if name != "lean" or form.model.slopes_are_gaussian]
    direct, moments = (
        [stage.measure(variant, names=["budget"]) for variant in variants] for variants in (TECHNIQUES, chains)
    )
    trials = [*direct, min(moments, key=lambda trial: share(trial, "mse"))]
    return Row(
        form=form.label,
        strength=strength,
        mean=mean,
        floor=share(trials[0], "floor"),
        techniques=[Quality(t.variant.label, share(t, "mse"), share(t, "flicker")) for t in trials],
    )


def _mean(stage: Stage) -> float:
    """Mean radiance over wholly covered pixels."""
    pictures = [picture.rgba[picture.rgba[..., 3] == 1, :3] for picture in stage.reference]
    return float(np.concatenate(pictures).mean())


def _scaled(maps: Maps, strength: float, *, twisted: bool) -> Maps:
    """Maps with a factor on Ks, and with their twist only where a model needs it."""
    factors = np.array([strength, 1.0], np.float32)
    return maps._replace(gloss=maps.gloss * factors, twist=maps.twist if twisted else None)
