"""The self-test: clips whose scores are known in closed form, through the same measures as anyone's frames."""

from collections.abc import Iterator
from dataclasses import dataclass
from math import radians

from metrics import measure
from metrics.synthetic import KINDS, Rotation, Waves, alias, error_clips, flicker_share, texture, zone_plate

COUNT = 32
MOTION = (23 / 32, 19 / 32)
"""Frames and px a frame of the clips that move uniformly: 29.8 px in all."""


@dataclass(frozen=True)
class Check:
    """One score of one clip. value is None where the score was refused; expected is None where it should be."""

    clip: str
    score: str
    value: float | None
    expected: float | None
    tolerance: float

    @property
    def good(self) -> bool:
        """Whether the value is within the tolerance of what is expected."""
        if self.value is None or self.expected is None:
            return self.value is self.expected
        return abs(self.value - self.expected) <= self.tolerance


def checks() -> Iterator[Check]:
    """Every check, clip by clip."""
    yield from _five_errors()
    yield from _rotation()
    yield from _zone_plates()
    yield from _orders()


def _five_errors() -> Iterator[Check]:
    """Errors of one size, which frame-by-frame measures cannot distinguish.

    Waves of different kinds meet under one window, so shares stray by some thousandths; a glued one has none.
    """
    for kind in KINDS:
        test, reference = error_clips(kind, count=COUNT, motion=MOTION, rms=0.1)
        found = measure(test, reference, names=["budget"]).scores
        total = found["budget.mse"]
        parts = sum(found[f"budget.{part}"] for part in ("bias", "detail", "flicker"))
        exact = kind in ("glued", "blinking")
        yield Check(f"{kind} error", "rms error", total**0.5, 0.1, 0.003)
        yield Check(f"{kind} error", "sum of parts / mse", parts / total, 1.0, 1e-12)
        share = flicker_share(kind, count=COUNT, motion=MOTION)
        yield Check(f"{kind} error", "flicker / mse", found["budget.flicker"] / total, share, 1e-6 if exact else 0.005)


def _rotation() -> Iterator[Check]:
    turn = Rotation(3.0, (150, 150))
    found = measure(turn.clip(texture(3).at, 24), names=["residual"]).scores
    yield Check("texture turning 3 degrees a frame", "residual flicker", found["residual.flicker"], 0.0, 0.03)


def _zone_plates() -> Iterator[Check]:
    """The moving zone plate, point sampled where it is above the pixel Nyquist, and where it is not."""
    angle, size = radians(20), (160, 128)
    for frequency in (0.62, 0.85, 1.2):
        test, reference = (
            zone_plate(frequency, angle, samples=samples, count=COUNT, size=size, motion=MOTION) for samples in (1, 12)
        )
        found = measure(test, reference, names=["moire", "plane"]).scores
        name = f"zone plate, {frequency:g} cycles/px"
        peak = alias(frequency, angle)
        yield Check(name, "peak, cycles/px", found.get("moire.peak_frequency"), peak, 0.02 * peak)
        yield Check(name, "order 1", found.get("plane.order1"), 1.0, 1e-4)
    plate = zone_plate(0.3, angle, samples=1, count=COUNT, size=size, motion=MOTION)
    found = measure(plate, plate, names=["moire", "plane"]).scores
    yield Check("zone plate, 0.3 cycles/px", "peak, cycles/px", found.get("moire.peak_frequency"), None, 0.0)
    yield Check("zone plate, 0.3 cycles/px", "on the plane", found.get("plane.on"), 1.0, 1e-4)


def _orders() -> Iterator[Check]:
    """Drifting sinusoids above and below the pixel Nyquist; motions that hide their aliases are refused."""
    waves = Waves()
    for samples in (1, 4, 16):
        found = measure(waves.clip(samples, 0.375), names=["plane"]).scores
        for name, share in zip(("plane.on", "plane.order1"), waves.shares(samples), strict=False):
            yield Check(f"drifting waves, {samples} samples a pixel", name, found.get(name), share, 1e-4)
    for velocity in (1.0, 0.5):
        found = measure(waves.clip(1, velocity), names=["plane"]).scores
        yield Check(f"drifting waves, {velocity:g} px a frame", "plane.on", found.get("plane.on"), None, 0.0)
