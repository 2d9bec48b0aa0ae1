"""The reference as measures take it: in the domain, aligned, and held for the next test of the same geometry."""

from collections.abc import Callable, Hashable
from threading import Lock

import numpy as np

from metrics.clip import Clip, ClipError, FrameSource, Image
from metrics.display import STANDARD, Display, Domain, to_domain
from metrics.memory import unset
from metrics.spans import Placement

Exact = tuple[Image, Image | None]


class ReferenceFrames:
    """A reference, and the half-difference (A - B)/2 of two halves of its samples where it is known."""

    def __init__(
        self,
        reference: Clip,
        *,
        error: FrameSource | None = None,
        domain: Domain = "linear",
        display: Display = STANDARD,
        room: float = 0.0,
    ) -> None:
        """error: t -> [H, W, 3], the half-difference. room: bytes of frames to hold; the others are made again."""
        self.reference, self.domain, self.display = reference, domain, display
        self._error, self._room = error, room
        self._held: dict[Hashable, Exact] = {}
        self._lock = Lock()

    @property
    def has_floor(self) -> bool:
        """Whether the reference's own error is known."""
        return self._error is not None

    def exact(self, t: int) -> Exact:
        """Frame t [3, H, W] in the domain, and its half-difference where it is known."""
        return self._hold(t, lambda: self._planes(t))

    def difference(self, place: Placement, picture: Image, exact: Exact) -> Exact:
        """An unwarped picture minus the frame, which is given as it is, and the frame's half-difference, unwarped too.

        Unwarping is linear, and most of the work: the difference is taken after it.
        """
        span, (shown, half) = place.span, exact
        key = (span.start, span.rows.start, span.rows.stop, place.t)

        def align() -> Exact:
            return place.align(shown), None if half is None else place.align(half)

        aligned, aligned_half = self._hold(key, align)
        # What is held for the next test stays as it is.
        into = unset(aligned.shape, aligned.dtype) if key in self._held else aligned
        return np.subtract(picture, aligned, out=into), aligned_half

    def _planes(self, t: int) -> Exact:
        exact = self.reference.planes(t)
        shown = to_domain(exact, self.domain, self.display, t)
        if self._error is None:
            return shown, None
        half = Clip(self._error, self.reference.count).planes(t)
        if half.shape != exact.shape:
            raise ClipError(f"the reference's error of frame {t} has another size than the reference")
        if self.domain == "display":
            half = (self.display.show(exact + half, t) - self.display.show(exact - half, t)) / 2
        return shown, half

    def _hold(self, key: Hashable, make: Callable[[], Exact]) -> Exact:
        found = self._held.get(key)
        if found is not None:
            return found
        with self._lock:
            if key not in self._held:
                made = make()
                self._room -= sum(part.nbytes for part in made if part is not None)
                if self._room < 0:
                    return made
                self._held[key] = made
            return self._held[key]
