"""A pattern that is glued to the surface by the clip's own motion: what unwarping makes of it is the measure's own."""

from collections.abc import Iterator

import numpy as np
from numpy.typing import NDArray

from metrics.geometry import Field
from metrics.kernels.launch import Launcher
from metrics.kernels.pattern import pattern_at
from metrics.spans import Placement
from metrics.synthetic import texture

LIMIT = 1 / 8
"""The pattern's highest frequency in the anchor frame, cycles/px: a quarter of the pixel Nyquist."""

WAVES = 6


class GluedPattern:
    """A band-limited pattern on the anchor frame of one span, which is followed through the span's frames in order."""

    def __init__(self, launcher: Launcher, frame: int) -> None:
        """frame: of which the span is."""
        self._launcher, self._frame = launcher, frame
        self._waves = texture(0, limit=LIMIT, waves=WAVES)
        self._course: Iterator[Field] | None = None

    def seen(self, place: Placement) -> NDArray[np.float32] | None:
        """The pattern [1, rows, W] in the grid in which tiles lie; None where nothing is unwarped, in other spans, and
        where it is known already in the first frame what comes of it."""
        span, correspondence = place.span, place.span.correspondence
        if correspondence is None or not span.start <= self._frame < span.stop:
            return None
        if place.t == span.start:
            # Another clip of the same alignment may find it meanwhile: a pattern that is begun is followed to the end.
            self._course = None if span.tiles in span.floors else correspondence.glue()
        if self._course is None:
            return None
        pattern = pattern_at(self._launcher, self._waves.frequency, self._waves.phase, next(self._course))
        if place.t == span.stop - 1:
            self._course = None  # It holds the span's places.
        return place.align(pattern[None])
