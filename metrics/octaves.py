"""Octaves of spatial frequency."""

import numpy as np

OCTAVES = (0.0, 1 / 32, 1 / 16, 1 / 8, 1 / 4, 1 / 2)
"""Where octaves of |k| begin, cycles/px; the last one holds the corners beyond the pixel Nyquist."""

_AREAS = np.pi * np.square([*OCTAVES[1:], 0.0])
_AREAS[-1] = 1.0

WHITE = np.diff(_AREAS, prepend=0.0)
"""[octaves], share of a white noise's energy that each holds: its part of the square |kx|, |ky| < 1/2."""
