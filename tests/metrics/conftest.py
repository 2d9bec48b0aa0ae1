"""Synthetic pictures with known answers, shared by the tests of the measures."""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
import pytest
from numpy.typing import NDArray


@dataclass(frozen=True)
class Texture:
    """A sum of sinusoids at random frequencies (x, y cycles/px) below a limit: non-periodic and band-limited."""

    frequency: NDArray[np.float64]
    phase: NDArray[np.float64]
    mean: float = 0.0

    def at(self, x: NDArray[np.float64], y: NDArray[np.float64]) -> NDArray[np.float64]:
        """Values at points (px), the same in three channels up to a phase: [..., 3], of unit variance."""
        angle = 2 * np.pi * (x[..., None] * self.frequency[:, 0] + y[..., None] * self.frequency[:, 1])
        waves = [np.cos(angle + self.phase + channel).sum(axis=-1) for channel in range(3)]
        return self.mean + np.stack(waves, axis=-1) * np.sqrt(2 / len(self.phase))


def _texture(seed: int, *, limit: float = 0.3, waves: int = 24, mean: float = 0.0) -> Texture:
    random = np.random.default_rng(seed)
    radius = limit * np.sqrt(random.uniform(0.01, 1.0, waves))
    direction = random.uniform(0, 2 * np.pi, waves)
    frequency = radius[:, None] * np.stack([np.cos(direction), np.sin(direction)], axis=1)
    return Texture(frequency, random.uniform(0, 2 * np.pi, waves), mean)


@pytest.fixture(scope="session")
def texture() -> Callable[..., Texture]:
    """texture(seed, limit=.3, waves=24, mean=0) -> Texture."""
    return _texture


def _centres(height: int, width: int) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    return np.meshgrid(np.arange(width) + 0.5, np.arange(height) + 0.5)


@pytest.fixture(scope="session")
def centres() -> Callable[[int, int], tuple[NDArray[np.float64], NDArray[np.float64]]]:
    """centres(height, width) -> x, y of the pixel centres."""
    return _centres
