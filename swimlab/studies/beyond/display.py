"""What a display makes of error and flicker: clamping, gamma, bloom, tone maps and quantisation, one at a time."""

from collections.abc import Callable
from dataclasses import dataclass, replace
from math import sqrt
from pathlib import Path

from metrics import Bloom, Display, align, measure
from swimlab.runs.clips import check_complete, display_of, read_clip, reference_error
from swimlab.runs.record import GEOMETRY, REFERENCE, Record, RunError

LINEAR = "linear"
"""The row of radiance as it was rendered."""

VARIANTS = {
    "sRGB": Display(),
    "sqrt": Display(gamma="sqrt"),
    "bloom": Display(bloom=Bloom(strength=0.5)),
    "Reinhard": Display(tone_map="reinhard"),
    "Reinhard, bloom": Display(tone_map="reinhard", bloom=Bloom(strength=0.5)),
    "ACES": Display(tone_map="aces"),
    "8 bit": Display(bits=8),
    "8 bit, dithered": Display(bits=8, dither=True),
}
"""Ways to show radiance; what is not said is as in sRGB."""


@dataclass(frozen=True)
class Row:
    """A technique in one way of showing it: rms of error and flicker, and of the reference's own error.

    In radiance for `LINEAR`, else in codes of 0..1, which do not compare across ways: `flicker / error` does.
    """

    settings: str
    technique: str
    error: float
    flicker: float
    floor: float


def display_study(run: Path, *, advance: Callable[[str], None] = lambda _: None) -> list[Row]:
    """Measure the techniques of a run as they are shown in each of `VARIANTS`, at the exposure of the run's sequence.

    `advance` is called with the name of each way when it is done. Raises RunError where the run has no reference, no
    technique beside it, or frames of different sizes; FrameError and ClipError for frames that cannot be measured.
    """
    record = Record.read(run)
    tests = [name for name in record.techniques if name != REFERENCE]
    if record.resizes or not tests or tests == record.techniques:
        raise RunError(f"{run}: the display study needs frames of one size, a technique and the reference")
    check_complete(run, [*record.techniques, GEOMETRY], record.frames)
    reference = read_clip(run, record, REFERENCE, record.frames)
    alignment = align(reference)
    own = display_of(record)
    rows = []
    for settings, variant in {LINEAR: None, **VARIANTS}.items():
        for technique in tests:
            found = measure(
                read_clip(run, record, technique, record.frames),
                reference,
                domain="linear" if variant is None else "display",
                display=own if variant is None else replace(variant, exposure=own.exposure, seed=own.seed),
                reference_error=reference_error(run, record.frames),
                names=["budget"],
                alignment=alignment,
            )
            missing = found.absent.get("budget.flicker")
            if missing is not None:
                raise RunError(f"{run}: no flicker to compare: {missing}")
            error, flicker, floor = (sqrt(found.scores[f"budget.{part}"]) for part in ("mse", "flicker", "floor"))
            rows.append(Row(settings, technique, error, flicker, floor))
        advance(settings)
    return rows
