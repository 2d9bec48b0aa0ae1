"""Trials: variants of techniques rendered, scored and timed side by side, in memory."""

import time
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from functools import cached_property
from itertools import pairwise
from math import sqrt
from typing import Any

import numpy as np

from metrics import Alignment, Clip, Measurement, align, measure, measure_scales
from metrics.kernels.launch import Launcher
from sequences import Sequence as Scenery
from swimlab.render.catalogue import model_of, techniques
from swimlab.render.geometry import describe_geometry
from swimlab.render.material import Material, load_material
from swimlab.render.shot import Shot
from swimlab.render.technique import Picture
from swimlab.runs.clips import shared_coverage
from swimlab.runs.frames import Geometry, Image
from swimlab.runs.record import REFERENCE, RunError


@dataclass(frozen=True)
class Variant:
    """A technique and its settings that differ from the defaults; `label` names it in tables."""

    label: str
    technique: str
    settings: Mapping[str, Any] = field(default_factory=dict)

    def begin(self) -> Callable[[Shot], Picture]:
        """The renderer for shots of one sequence. Raises ValueError for settings that the technique does not have."""
        technique = techniques()[self.technique]
        settings = technique.settings.model_validate(dict(self.settings))
        render = technique.begin()
        return lambda shot: render(shot, settings)


@dataclass(frozen=True)
class Trial:
    """What a variant came to: its scores, and how many samples, texels or vertices it shaded a frame, on average."""

    variant: Variant
    measurement: Measurement
    shaded: float

    def rms(self, part: str = "mse", band: str | None = None) -> float | None:
        """Root of a part of the error budget, in a band of distance or on the whole; None where it is not available."""
        value = self.measurement.scores.get(_score(part, band))
        return None if value is None else sqrt(max(value, 0.0))

    def standard_error(self, part: str = "mse", band: str | None = None) -> float | None:
        """Standard error of `rms`."""
        error, root = self.measurement.errors.get(_score(part, band)), self.rms(part, band)
        return error / (2 * root) if error is not None and root else None


class Stage:
    """Frames of a sequence with their reference, on which variants are tried.

    samples: the reference's samples a pixel, a square number from 4. material: in place of the sequence's maps. The
    reference's pictures and the geometry are made when first asked for and held, 48 bytes a pixel and frame. Raises
    RunError for frames that do not follow each other, unless the sequence resizes, and MapError for unfit maps.
    """

    def __init__(
        self,
        sequence: Scenery,
        frames: Sequence[int],
        *,
        samples: int,
        launcher: Launcher,
        material: Material | None = None,
    ) -> None:
        if not frames or (not sequence.motion.resizes and any(b - a != 1 for a, b in pairwise(frames))):
            raise RunError(f"frames {list(frames)}: a trial needs frames that follow each other")
        self.sequence, self.frames, self.samples = sequence, list(frames), samples
        self._launcher, self._model = launcher, model_of(sequence)
        material = material or load_material(sequence, launcher, twisted=self._model.anisotropic)
        self._shot = Shot(sequence, self.frames[0], material, self._model, samples, launcher)

    def shot(self, frame: int) -> Shot:
        """A frame before any technique has touched it."""
        return self._shot.at(frame)

    def pictures(self, variant: Variant) -> list[Picture]:
        """All frames under a variant, rendered in turn."""
        render = variant.begin()
        return [render(self.shot(frame)) for frame in self.frames]

    @cached_property
    def reference(self) -> list[Picture]:
        """The reference of every frame, with its own standard error."""
        return self.pictures(Variant(REFERENCE, REFERENCE, self.sequence.techniques.get(REFERENCE, {})))

    @cached_property
    def geometry(self) -> list[Geometry]:
        """Coverage, motion and depth of every frame."""
        return [describe_geometry(self.shot(frame)) for frame in self.frames]

    def measure(
        self, variant: Variant, *, names: Sequence[str] | None = None, pictures: Sequence[Picture] | None = None
    ) -> Trial:
        """Render a variant's frames and score them against the reference in linear radiance.

        names: scores wanted, as `metrics.measure` takes them; a sequence that resizes has all of `scale.*`.
        pictures: the variant's pictures where they are there already.
        """
        tests = pictures or self.pictures(variant)
        shaded = float(np.mean([picture.shaded for picture in tests]))
        if self.sequence.motion.resizes:
            return Trial(variant, self._measure_scales(tests), shaded)
        found = measure(
            self.clip(tests),
            self.clip(self.reference),
            reference_error=self._reference_error,
            names=names,
            alignment=self._alignment,
        )
        return Trial(variant, found, shaded)

    def time(
        self, variants: Sequence[Variant], rounds: int, *, advance: Callable[[str], None] = lambda _: None
    ) -> dict[str, list[float]]:
        """Milliseconds of one frame in each round by the variants' labels; a sequence that resizes: of its first frame.

        Interleaved: a round is one frame of each variant in turn, after one that compiles and is not counted. What all
        techniques share, maps and the mesh on the screen, is made before. `advance` is called with each label.
        """
        renders = {variant.label: variant.begin() for variant in variants}
        times: dict[str, list[float]] = {label: [] for label in renders}
        for turn in range(rounds + 1):
            shot = self.shot(self.frames[0] + (0 if self.sequence.motion.resizes else turn))
            _ = shot.triangles
            for label, render in renders.items():
                started = time.perf_counter()
                render(shot)
                if turn:
                    times[label].append(1e3 * (time.perf_counter() - started))
                advance(label)
        return times

    @cached_property
    def _alignment(self) -> Alignment:
        return align(self.clip(self.reference))

    def _reference_error(self, t: int) -> Image:
        error = self.reference[t].error
        if error is None:
            raise RunError("the reference has no error of its own")
        return error[..., :3]

    def _measure_scales(self, tests: Sequence[Picture]) -> Measurement:
        def clips(pictures: Sequence[Picture]) -> list[Clip]:
            return [self.clip([picture], first=t) for t, picture in enumerate(pictures)]

        heights = [picture.rgba.shape[0] for picture in tests]
        return measure_scales(clips(tests), clips(self.reference), [height / heights[0] for height in heights])

    def clip(self, pictures: Sequence[Picture], first: int = 0) -> Clip:
        """Pictures as a clip, the geometry's from `first` on; what the reference does not wholly cover is left out."""

        def coverage(t: int) -> Image:
            return shared_coverage(self.geometry[first + t].coverage, self.reference[first + t].rgba[..., 3])

        return Clip(
            frame=lambda t: pictures[t].rgba[..., :3],
            count=len(pictures),
            fps=self.sequence.fps,
            motion=self.sequence.motion.uniform_velocity or (lambda t: self.geometry[first + t].motion),
            coverage=coverage,
            depth=lambda t: self.geometry[first + t].depth,
            pixels_per_degree=self.sequence.viewing.pixels_per_degree,
            luminance=self.sequence.viewing.luminance,
        )


def _score(part: str, band: str | None) -> str:
    return f"budget.{part}" if band is None else f"budget.{part}.{band}"
