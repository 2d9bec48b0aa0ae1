"""Pictures of energy as text: a row of whole decibels, small enough for every technique to have one in scores.json."""

import numpy as np
from numpy.typing import NDArray

FAINTEST = -120
"""Decibels of what is fainter, or nothing."""


def rows_of(power: NDArray[np.float64]) -> list[str]:
    """[rows, columns] of power as one text a row, decibels to the power 1 between spaces."""
    level = 10 * np.log10(np.maximum(power, 10.0 ** (FAINTEST / 10)))
    return [" ".join(map(str, row)) for row in np.rint(level).astype(int).tolist()]


def levels_of(rows: list[str]) -> NDArray[np.float64]:
    """[rows, columns] in decibels, of texts by `rows_of`. Raises ValueError for any other text."""
    return np.array([[float(word) for word in row.split()] for row in rows])
