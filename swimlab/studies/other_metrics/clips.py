"""Clips whose errors have one energy and differ only in how they move: a metric of flicker must tell them apart."""

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from metrics import Clip
from metrics.display import encode
from metrics.synthetic import KINDS, centres, error_clips, flicker_share, texture

SIZE = (160, 120)
COUNT = 16
MOTION = (23 / 32, 19 / 32)
"""px a frame of the five errors' surface."""
LEVEL = 0.08
"""Rms contrast of the surface, radiance, about MIDDLE: a display shows it without clipping."""
MIDDLE = 0.5
ERROR = 0.3
"""Rms error of the five, as a share of the contrast."""

STILL, CRAWLING = "a crawling silhouette's error, glued", "a crawling silhouette"
GLUED, GHOST = "a ghost trail's error, glued", "a ghost trail"

DISC, GROUND = (2.1, -0.3), (-1.3, 0.4)
"""px a frame of a disc and of what is behind it."""
SAMPLES = 8
_RADIUS = 36.0
_INWARDS = 20.0
"""px by which the glued error of a trail lies further right, on the disc."""

Array = NDArray[np.float64]


@dataclass(frozen=True)
class Case:
    """A test and its reference. share: of the error's energy that flickers, where it is known."""

    name: str
    test: Clip
    reference: Clip
    share: float | None = None


def five_errors() -> list[Case]:
    """The errors of `metrics.synthetic`: of one spectrum and one energy, they differ only in how they move."""
    cases = []
    for kind in KINDS:
        clips = error_clips(kind, count=COUNT, size=SIZE, motion=MOTION, rms=ERROR)
        test, reference = (_dimmed(clip) for clip in clips)
        cases.append(Case(kind, test, reference, flicker_share(kind, count=COUNT, motion=MOTION)))
    return cases


def pairs() -> list[tuple[Case, Case]]:
    """An error that flickers or trails, at a silhouette and behind it, and its first frame glued to the disc before it.

    Both have one spectrum, about, and one energy as displayed.
    """
    scene = _Scene()
    crawling = [scene.point_sampled(t) - scene.exact[t] for t in range(COUNT)]
    trail = [scene.trail(t) for t in range(COUNT)]
    return [
        (scene.case(STILL, scene.glued(crawling)), scene.case(CRAWLING, crawling)),
        (scene.case(GLUED, scene.glued(trail, _INWARDS)), scene.case(GHOST, trail)),
    ]


def _moved(picture: Array, dx: float, dy: float) -> Array:
    """A picture [H, W, n] moved right and down, px, by the shift theorem: no energy of any wave is lost."""
    fy, fx = (np.fft.fftfreq(length) for length in picture.shape[:2])
    turn = np.exp(-2j * np.pi * (dy * fy[:, None] + dx * fx))[..., None]
    return np.asarray(np.fft.ifft2(turn * np.fft.fft2(picture, axes=(0, 1)), axes=(0, 1)).real)


def _dimmed(clip: Clip) -> Clip:
    """With the mean of the surface, 3, at MIDDLE."""
    return replace(clip, frame=lambda t: MIDDLE + LEVEL * (np.asarray(clip.frame(t)) - 3))


class _Scene:
    """A textured disc that moves over a textured ground which moves otherwise."""

    def __init__(self) -> None:
        self._x, self._y = np.broadcast_arrays(*centres(SIZE[1], SIZE[0]))
        self._textures = (texture(1), texture(2))
        self.exact = [self._covered(t) for t in range(COUNT)]

    def case(self, name: str, error: list[Array]) -> Case:
        """The exact pictures with an error [H, W, 3] a frame."""
        test = Clip(lambda t: (self.exact[t] + error[t]).astype(np.float32), COUNT, motion=self._motion)
        return Case(name, test, Clip(lambda t: self.exact[t].astype(np.float32), COUNT, motion=self._motion))

    def _covered(self, t: int) -> Array:
        """[H, W, 3]: each pixel has as much of the disc as it covers, by SAMPLES x SAMPLES points."""
        offsets = (np.arange(SAMPLES) + 0.5) / SAMPLES - 0.5
        covered = np.mean([self._away(t, dx, dy) < 0 for dx in offsets for dy in offsets], axis=0)
        return self._blended(t, covered[..., None])

    def point_sampled(self, t: int) -> Array:
        """The same with one point a pixel."""
        return self._blended(t, (self._away(t) < 0).astype(np.float64)[..., None])

    def trail(self, t: int) -> Array:
        """Half of the disc that was there in the frame before, where it is no more."""
        left = (self._away(t - 1) < 0) & (self._away(t) >= 0)
        before = 0.5 * (self._surfaces(t - 1)[0] - self._surfaces(t)[1])
        return np.where(left[..., None], before, 0.0)

    def glued(self, other: list[Array], right: float = 0.0) -> list[Array]:
        """The first frame of an error, so much further right, moving with the disc; of the same energy as displayed."""
        ours = [_moved(other[0], right + DISC[0] * t, DISC[1] * t) for t in range(len(other))]
        for _ in range(2):  # codes are no linear function of radiance
            factor = np.sqrt(self._displayed(other) / self._displayed(ours))
            ours = [factor * each for each in ours]
        return ours

    def _displayed(self, errors: list[Array]) -> float:
        """Mean squared error of sRGB codes."""
        pairs = zip(self.exact, errors, strict=True)
        return float(np.mean([np.mean((encode(exact + error) - encode(exact)) ** 2) for exact, error in pairs]))

    def _away(self, t: int, dx: float = 0.0, dy: float = 0.0) -> Array:
        """px to the disc's edge, negative inside."""
        x, y = SIZE[0] * 0.3 + DISC[0] * t, SIZE[1] * 0.5 + DISC[1] * t
        return np.asarray(np.hypot(self._x + dx - x, self._y + dy - y) - _RADIUS * SIZE[1] / 144)

    def _surfaces(self, t: int) -> tuple[Array, Array]:
        disc, ground = (
            LEVEL * each.at(self._x - dx * t, self._y - dy * t)
            for each, (dx, dy) in zip(self._textures, (DISC, GROUND), strict=True)
        )
        return MIDDLE + LEVEL + disc, MIDDLE - LEVEL + ground

    def _blended(self, t: int, covered: Array) -> Array:
        disc, ground = self._surfaces(t)
        return covered * disc + (1 - covered) * ground

    def _motion(self, t: int) -> NDArray[np.float32]:
        return np.where((self._away(t) < 0)[..., None], np.array(DISC, np.float32), np.array(GROUND, np.float32))
