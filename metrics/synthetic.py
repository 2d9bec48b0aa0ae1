"""Clips with known answers, made in memory: for the self-test, and for anyone who doubts a measure.

Everything is a sum of sinusoids evaluated at exact places, so that nothing is interpolated; coordinates are px,
+x right and +y down, pixel (i, j) with its centre at (j + .5, i + .5).
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from typing import Literal, get_args

import numpy as np
from numpy.typing import NDArray

from metrics.clip import Clip
from metrics.octaves import OCTAVES

Array = NDArray[np.float64]
Kind = Literal["glued", "screen-fixed", "swimming", "noise", "blinking"]
KINDS: tuple[Kind, ...] = get_args(Kind)
Motion = tuple[float, float]


@dataclass(frozen=True)
class Texture:
    """A sum of sinusoids of one amplitude, of unit variance in each of three channels, on a mean level.

    frequency: [waves, 2] (x, y), cycles/px; none is a multiple of another, so nothing repeats. phase: [waves], rad.
    """

    frequency: Array
    phase: Array
    mean: float = 0.0

    def at(self, x: Array, y: Array) -> Array:
        """Values [..., 3] at points (px), x and y broadcast; channels differ in phase only."""
        waves = np.zeros(np.broadcast_shapes(x.shape, y.shape), dtype=np.complex128)
        for (fx, fy), phase in zip(2 * np.pi * self.frequency, self.phase, strict=True):
            if x.shape == y.shape:
                waves += np.exp(1j * (x * fx + y * fy + phase))
            else:
                waves += np.exp(1j * (x * fx + phase)) * np.exp(1j * y * fy)
        channels = [np.real(waves * np.exp(1j * channel)) for channel in range(3)]
        return np.asarray(self.mean + np.stack(channels, axis=-1) * np.sqrt(2 / len(self.phase)))


def texture(seed: int, *, limit: float = 0.3, waves: int = 24, mean: float = 0.0) -> Texture:
    """A texture of random waves between a tenth of `limit` and `limit`, cycles/px, spread evenly over the area."""
    random = np.random.default_rng(seed)
    radius = limit * np.sqrt(random.uniform(0.01, 1.0, waves))
    direction = random.uniform(0, 2 * np.pi, waves)
    frequency = radius[:, None] * np.stack([np.cos(direction), np.sin(direction)], axis=1)
    return Texture(frequency, random.uniform(0, 2 * np.pi, waves), mean)


def centres(height: int, width: int) -> tuple[Array, Array]:
    """x, [1, width], and y, [height, 1], of the pixel centres."""
    return np.arange(0.5, width)[None, :], np.arange(0.5, height)[:, None]


def error_frame(kind: Kind, wrong: Texture, t: int, place: tuple[Array, Array], motion: Motion) -> Array:
    """Frame t, [H, W, 3], of an error of one kind: all have the same spectrum and, about, rms 1.

    glued to the surface; screen-fixed; swimming, against the surface at its own speed on the screen; noise, with new
    phases every frame; blinking, glued but of the other sign every second frame.
    """
    (x, y), (dx, dy) = place, motion
    if kind == "screen-fixed":
        return wrong.at(x, y)
    if kind == "swimming":
        return wrong.at(x + t * dx, y + t * dy)
    if kind == "noise":
        random = np.random.default_rng(t)
        return replace(wrong, phase=random.uniform(0, 2 * np.pi, len(wrong.phase))).at(x, y)
    glued = wrong.at(x - t * dx, y - t * dy)
    return glued * (-1.0) ** t if kind == "blinking" else glued


def error_clips(
    kind: Kind,
    *,
    count: int = 32,
    size: tuple[int, int] = (140, 120),
    motion: Motion = (23 / 32, 19 / 32),
    rms: float = 0.1,
    seed: int = 1,
) -> tuple[Clip, Clip]:
    """Test and reference, float32: a texture that moves uniformly, and an error of one kind and size.

    size: width and height, px. motion: px a frame.
    """
    picture, wrong, place = texture(seed, mean=3.0), texture(seed + 1), centres(size[1], size[0])

    def reference(t: int) -> NDArray[np.float32]:
        return picture.at(place[0] - t * motion[0], place[1] - t * motion[1]).astype(np.float32)

    def test(t: int) -> NDArray[np.float32]:
        return reference(t) + (rms * error_frame(kind, wrong, t, place, motion)).astype(np.float32)

    return Clip(test, count, motion=motion), Clip(reference, count, motion=motion)


def flicker_share(kind: Kind, *, count: int, motion: Motion, seed: int = 1) -> float:
    """The share of `error_clips`' error that is flicker, in closed form.

    A wave k that slides by u px a frame against the surface leaves |sin(pi T k.u) / (T sin(pi k.u))|^2 of its energy
    static over T frames; by Bessel's correction the rest counts T / (T - 1) times, so that noise leaves nothing,
    but no octave of |k| leaves less.
    """
    if kind in ("noise", "blinking"):
        return 1.0
    against = {"glued": 0.0, "screen-fixed": 1.0, "swimming": 2.0}[kind]
    waves = texture(seed + 1).frequency
    slides = waves @ np.multiply(motion, against)
    mean = np.abs(np.exp(2j * np.pi * slides[:, None] * np.arange(count)).mean(axis=1)) ** 2
    octave = np.digitize(np.hypot(*waves.T), OCTAVES)
    static = np.bincount(octave, mean - (1 - mean) / (count - 1))
    return float(1 - np.maximum(0.0, static).sum() / len(waves))


CHIRP = 1 / 9000
"""Change of a zone plate's frequency, cycles/px per px."""


def zone_plate(
    frequency: float, angle: float, *, samples: int, count: int, size: tuple[int, int], motion: Motion
) -> Clip:
    """A crop of the moving zone plate 2 + cos(pi CHIRP r^2) where its local frequency is as given.

    frequency: cycles/px at the crop's middle in the middle frame. angle: its direction, rad, from +x to +y.
    samples: the picture is the mean of samples x samples points a pixel; 1 is point sampling.
    """
    centre = frequency / CHIRP * np.array([np.cos(angle), np.sin(angle)]) - np.array(size) / 2
    parts = (np.arange(samples) + 0.5) / samples - 0.5
    x, y = centres(size[1], size[0])

    def frame(t: int) -> Array:
        right, down = ((count - 1) / 2 - t) * np.array(motion) + centre
        across = [np.exp(1j * np.pi * CHIRP * (x[0] + right + a) ** 2) for a in parts]
        along = [np.exp(1j * np.pi * CHIRP * (y[:, 0] + down + b) ** 2) for b in parts]
        plate = np.real(np.mean(along, axis=0)[:, None] * np.mean(across, axis=0)[None, :])
        return np.repeat(2 + plate[..., None], 3, axis=2)

    return Clip(frame, count, motion=motion)


def alias(frequency: float, angle: float) -> float:
    """|k| at which point samples one px apart show a frequency, cycles/px."""
    k = frequency * np.array([np.cos(angle), np.sin(angle)])
    return float(np.hypot(*(k - np.round(k))))


@dataclass(frozen=True)
class Waves:
    """Sinusoids along x: frequency, cycles/px, amplitude and phase, rad; each a sequence [n]."""

    frequency: Sequence[float] = (0.06, 0.21, 0.38, 0.58, 0.77, 0.93)
    amplitude: Sequence[float] = (1.0, 0.7, 0.5, 0.8, 0.6, 0.9)
    phase: Sequence[float] = (0.3, 1.1, 2.9, 4.0, 5.3, 0.9)

    def clip(
        self, samples: int, velocity: float, *, count: int = 24, size: tuple[int, int] = (144, 64), mean: float = 5.0
    ) -> Clip:
        """The waves drifting by `velocity` px a frame; a pixel is the mean of so many samples along x."""
        place = np.arange(size[0])[:, None] + (np.arange(samples) + 0.5) / samples

        def frame(t: int) -> Array:
            angle = 2 * np.pi * np.multiply(place[..., None] - t * velocity, self.frequency) + np.array(self.phase)
            row = mean + (np.array(self.amplitude) * np.cos(angle)).sum(axis=-1).mean(axis=-1)
            return np.broadcast_to(row[None, :, None], (size[1], size[0], 3))

        return Clip(frame, count, motion=(velocity, 0.0))

    def shares(self, samples: int) -> list[float]:
        """Fractions of the energy of order 0, 1 and 2: a wave f has order round(f) and gain sinc(f)/sinc(f/n)."""
        f = np.array(self.frequency)
        gain = np.sinc(f) / np.sinc(f / samples) if samples > 1 else np.ones(len(f))
        energy = (np.array(self.amplitude) * gain) ** 2
        return [float(energy[np.rint(f) == order].sum() / energy.sum()) for order in (0, 1, 2)]


@dataclass(frozen=True)
class Rotation:
    """A picture that turns clockwise by `degrees` a frame about a point, px (None: its middle)."""

    degrees: float
    size: tuple[int, int]
    about: tuple[float, float] | None = None

    def surface(self, t: int) -> tuple[Array, Array]:
        """x and y on the surface, px, that each pixel of frame t sees."""
        middle = self.about or (self.size[0] / 2, self.size[1] / 2)
        x, y = (place - origin for place, origin in zip(centres(self.size[1], self.size[0]), middle, strict=True))
        cos, sin = np.cos(np.radians(self.degrees) * t), np.sin(np.radians(self.degrees) * t)
        return x * cos + y * sin, y * cos - x * sin

    def motion(self, t: int) -> NDArray[np.float32]:
        """[H, W, 2] px since frame t - 1, float32."""
        del t  # the same in every frame
        now, before = self.surface(0), self.surface(1)
        return np.stack([now[0] - before[0], now[1] - before[1]], axis=-1).astype(np.float32)

    def clip(self, picture: Callable[[Array, Array], Array], count: int) -> Clip:
        """Frames of a picture, (x, y) on the surface -> [..., 3]."""
        return Clip(lambda t: picture(*self.surface(t)).astype(np.float32), count, motion=self.motion)
