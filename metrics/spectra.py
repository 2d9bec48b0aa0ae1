"""The spectra of a clip's tiles, frame by frame, as measures take them in."""

from dataclasses import dataclass, field
from typing import NamedTuple

import numpy as np

from metrics.lazy import lazy
from metrics.spans import Span
from metrics.tiles import Level
from metrics.transform import Energy, Picture, Spectrum, TileTransform, follow, follow_both


@dataclass(frozen=True)
class Pictures:
    """One frame aligned to a span, each picture [3, H, W]: the test, and with a reference the test minus it.

    half_difference: (A - B)/2 of two halves of the reference's samples, if it is known. glued: [1, H, W], a pattern
    that is glued to the surface, in the span where it is looked at.
    """

    test: Picture
    error: Picture | None = None
    half_difference: Picture | None = None
    glued: Picture | None = None

    def followed(self) -> "Pictures":
        """What the next frame is compared with alone: the error, or without a reference the test."""
        return Pictures(self.test) if self.error is None else Pictures(self.error, self.error)


class Followed(NamedTuple):
    """Energies of a batch's tiles in one frame by octave, each [n, octaves].

    energy, change: of the error (of the test without a reference), and of its step since the frame before, which in the
    first frame is none. varied: "test", and with a reference "error" and "reference" -> what of its step from the mean
    so far adds to the energy of its variation (Welford 1962).
    """

    energy: Energy
    change: Energy
    varied: dict[str, Energy]


class Course:
    """How the spectra of a part's tiles go on in time: their running means."""

    def __init__(self, span: Span, *, has_reference: bool) -> None:
        self._start = span.start
        number = 2 if has_reference else 1
        shapes = [(number, level.count, 3, *level.spectrum_shape) for level in span.levels]
        self._means = [np.zeros(shape, dtype=np.complex64) for shape in shapes]

    @staticmethod
    def held(level: Level, *, has_reference: bool) -> float:
        """Bytes held for the tiles of a level."""
        return (2 if has_reference else 1) * level.held

    def follow(self, batch: "Batch") -> Followed:
        """Take in the next frame's spectra of the batch's tiles."""
        seen = batch.frame - self._start + 1
        means = [mean[batch.tiles] for mean in self._means[batch.level]]
        before = batch if batch.before is None else batch.before
        new = (seen - 1) / seen
        if batch.error is None or before.error is None:
            energy, change, varied = follow(batch.test, before.test, means[0], 1 / seen)
            return Followed(energy, change, {"test": new * varied})
        energy, change, *varied = follow_both(batch.error, before.error, means[0], batch.test, means[1], 1 / seen)
        names = ("error", "test", "reference")
        return Followed(energy, change, {name: new * each for name, each in zip(names, varied, strict=True)})


@dataclass(frozen=True)
class Batch:
    """Some tiles of one level in one frame.

    piece: which of the span's pieces. tiles: which of the level's tiles. before: the same tiles in the frame before;
    None in the first. What no measure asks for is not made.
    """

    frame: int
    level: int
    piece: int
    tiles: slice
    pictures: Pictures
    transform: TileTransform
    course: Course = field(repr=False)
    before: "Batch | None" = field(default=None, repr=False)

    @property
    def weight(self) -> float:
        """Sum of w^2 of one tile."""
        return self.transform.weight

    @property
    def level_spectrum(self) -> Spectrum:
        """[L, L/2 + 1], the spectrum of a constant picture of value 1."""
        return self.transform.constant

    @lazy
    def test(self) -> Spectrum:
        """[n, 3, L, L/2 + 1]."""
        return self._seen[0]

    @lazy
    def error(self) -> Spectrum | None:
        """The same of the test minus the reference, if there is one."""
        error = self.pictures.error
        return None if error is None else self.transform.seen(error, self.tiles)[0]

    @lazy
    def reference(self) -> Spectrum | None:
        return None if self.error is None else self.test - self.error

    @lazy
    def followed(self) -> Followed:
        """How the spectra go on from the frame before: to be asked for in every frame, or in none."""
        return self.course.follow(self)

    @property
    def mean(self) -> Picture:
        """[n, 3], mean level of the test's tiles under a Hann window, which shuts out what is not level best."""
        return self._seen[1]

    @property
    def floor_energy(self) -> Energy | None:
        """[n], sum of w^2 x^2 of the reference's half-difference from pixels, if it is known."""
        half = self.pictures.half_difference
        if half is None:
            return None
        blocks = self.transform.blocks(half, self.tiles).reshape(self.tiles.stop - self.tiles.start, -1)
        return np.asarray(np.vecdot(blocks, blocks), dtype=np.float64)

    @lazy
    def _seen(self) -> tuple[Spectrum, Picture]:
        return self.transform.seen(self.pictures.test, self.tiles)


def transforms(span: Span, t: int) -> list[TileTransform]:
    """What frame t's tiles are transformed with, for every level."""
    return [TileTransform(level, span.offsets[t - span.start], span.rows.start) for level in span.levels]


def split(energy: Energy, varied: Energy, span: Span, level: int) -> tuple[Energy, Energy]:
    """Of a level's energies over a span: what is static and what varies, each [n, octaves].

    They add up to the whole energy, and what unwarping took is given back. By Bessel's correction what varies
    independently from frame to frame, such as noise, has no static part on average (which may make a static energy
    negative by chance).
    """
    flicker = flickering(varied, span, level)
    return energy / _left(span, level) - flicker, flicker


def flickering(varied: Energy, span: Span, level: int) -> Energy:
    """The second of the two alone, from the sum of `Followed.varied` over a span."""
    return (varied + varied / max(1, span.count - 1)) / _left(span, level)


def _left(span: Span, level: int) -> Energy | float:
    """The share of a noise's energy that unwarping leaves."""
    return 1.0 if span.left is None else span.left[level]
