"""What unwarping leaves: the flicker of a pattern that is glued to the surface by the clip's own motion."""

from dataclasses import dataclass, field
from threading import Lock

import numpy as np
from numpy.typing import NDArray

from metrics.correspondence import Correspondence
from metrics.kernels.launch import Launcher
from metrics.kernels.pattern import pattern_at
from metrics.synthetic import texture
from metrics.tiles import Level
from metrics.transform import Energy, TileTransform, energy

LIMIT = 1 / 8
"""The pattern's highest frequency in the anchor frame, cycles/px: a quarter of the pixel Nyquist."""

WAVES = 6


@dataclass(frozen=True)
class TileFloor:
    """Of the tiles of one size: their bands of distance [n], and the pattern's energy [n] and what of it flickers."""

    size: int
    bands: NDArray[np.intp] | None
    energy: Energy
    flicker: Energy


@dataclass(frozen=True)
class Glued:
    """A band-limited pattern on the anchor frame of a span, followed through frames start..stop-1.

    shape: [H, W] of the frames, px. levels, bands: of the span's tiles.
    """

    start: int
    stop: int
    shape: tuple[int, int]
    levels: list[Level] = field(repr=False)
    bands: list[NDArray[np.intp]] | None = field(repr=False)
    correspondence: Correspondence = field(repr=False)
    launcher: Launcher = field(repr=False)
    _floor: list[TileFloor] = field(default_factory=list, repr=False)
    _lock: Lock = field(default_factory=Lock, repr=False)

    def floor(self) -> list[TileFloor]:
        """Measure the pattern as any picture is; done once."""
        with self._lock:
            if not self._floor:
                self._floor.extend(self._measure())
        return self._floor

    def _measure(self) -> list[TileFloor]:
        whole = slice(0, self.shape[0])
        waves = texture(0, limit=LIMIT, waves=WAVES)
        transforms = [TileTransform(level, (0.0, 0.0)) for level in self.levels]
        # Differences to the first picture seen: their sum and energy give the variance without cancellation.
        first = [np.zeros((level.count, 1, *level.spectrum_shape), dtype=np.complex64) for level in self.levels]
        summed = [np.zeros_like(spectra) for spectra in first]
        squared, total = ([np.zeros(level.count) for level in self.levels] for _ in range(2))
        course = zip(self.correspondence.places(whole), self.correspondence.glue(), strict=True)
        for number, (place, there) in enumerate(course):
            pattern = pattern_at(self.launcher, waves.frequency, waves.phase, there)
            seen = self.correspondence.take(pattern[None], place, whole)
            for index, transform in enumerate(transforms):
                spectra, _ = transform.seen(seen)
                total[index] += energy(spectra)
                if number == 0:
                    first[index] = spectra
                away = spectra - first[index]
                summed[index] += away
                squared[index] += energy(away)
        count = self.stop - self.start
        return [
            TileFloor(
                level.size,
                None if self.bands is None else self.bands[index],
                total[index],
                np.maximum(0.0, squared[index] - energy(summed[index]) / count) * count / max(1, count - 1),
            )
            for index, level in enumerate(self.levels)
        ]
