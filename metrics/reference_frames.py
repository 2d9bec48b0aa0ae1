"""The reference as measures take it: in the domain, aligned, and held for the next test of the same geometry."""

from collections.abc import Callable, Hashable
from threading import Lock

from metrics.clip import Clip, ClipError, FrameSource, Image
from metrics.display import STANDARD, Display, Domain, to_domain
from metrics.spans import Span
from metrics.spectra import Pictures

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

    def against(self, span: Span, test: Image, t: int) -> Pictures:
        """Frame t of a test [3, H, W], in the domain, and what it is off by, aligned to a span."""
        if span.correspondence is None:
            exact, half = self._hold(t, lambda: self._planes(t))
            off = span.align(test - exact, t)
            return Pictures(span.align(test, t), off, None if half is None else span.align(half, t))
        # Unwarping is linear, and most of the work: the difference is taken after it.
        exact, half = self._hold((span.start, span.rows.start, span.rows.stop, t), lambda: self._aligned(span, t))
        seen = span.align(test, t)
        return Pictures(seen, seen - exact, half)

    def off(self, test: Image, t: int) -> Image:
        """What frame t of a test [3, H, W], in the domain, is off by, as it lies on the screen."""
        return test - self._hold(t, lambda: self._planes(t))[0]

    def _aligned(self, span: Span, t: int) -> Exact:
        exact, half = self._planes(t)
        return span.align(exact, t), None if half is None else span.align(half, t)

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
