"""Synthetic pictures with known answers, shared by the tests of the measures."""

from collections.abc import Callable

import numpy as np
import pytest
from numpy.typing import NDArray

from metrics import synthetic


@pytest.fixture(scope="session")
def texture() -> Callable[..., synthetic.Texture]:
    """texture(seed, limit=.3, waves=24, mean=0) -> Texture."""
    return synthetic.texture


@pytest.fixture(scope="session")
def centres() -> Callable[[int, int], tuple[NDArray[np.float64], NDArray[np.float64]]]:
    """centres(height, width) -> x, y of the pixel centres."""
    return synthetic.centres
