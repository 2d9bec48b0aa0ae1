"""Measure a clip: one pass over the frames feeds every measure; at once, or its spans by parts."""

from collections.abc import Callable, Iterable, Sequence

import numpy as np
from numpy.typing import NDArray

from metrics import registry
from metrics.alignment_floor import AlignmentFloor
from metrics.clip import Clip, ClipError, FrameSource, Image
from metrics.display import STANDARD, Display, Domain, to_domain
from metrics.glued import GluedPattern
from metrics.kernels.launch import Launcher, Strip
from metrics.measurement import Context, Measurement
from metrics.memory import unset
from metrics.pixels import Pixels
from metrics.plan import Plan, velocity_of
from metrics.reference_frames import ReferenceFrames
from metrics.spans import Alignment, Placement, align, plan_spans
from metrics.spectra import Pictures
from metrics.sweep import Sweep
from metrics.totals import Found, PartFound, SpanFound, Totals, every_pixel

MEMORY, MEMORY_PER_PIXEL = 1.2e9, 330.0
"""Bytes that measuring may take, if nothing else is said, and for each pixel of a large frame."""

Progress = Callable[[int, int], None]


def measure(
    test: Clip,
    reference: Clip | ReferenceFrames | None = None,
    *,
    domain: Domain = "linear",
    display: Display = STANDARD,
    reference_error: FrameSource | None = None,
    names: Sequence[str] | None = None,
    alignment: Alignment | None = None,
    progress: Progress | None = None,
    memory: float | None = None,
    threads: int | None = None,
    device: str = "cpu",
) -> Measurement:
    """Measure a test clip, against a reference if there is one.

    Motion, coverage and depth are the test's; where it has no coverage or depth, the reference's.
    reference: a clip; or `ReferenceFrames` of the same domain and display, which several tests share and which know
        their own reference_error.
    domain: "linear" radiance, or "display": codes in 0..1 as `display` makes them, of both clips.
    reference_error: t -> [H, W, 3], (A - B)/2 of two independent halves of the reference's samples, whose mean
        (A + B)/2 is the reference.
    names: scores to measure, by name or beginning ("budget"); None: all.
    alignment: from `align`, of a clip with the same motion, coverage and depth; None: made here.
    progress: called with frames done and frames in all.
    memory: bytes that may be taken beside what `alignment` holds (None: MEMORY, or MEMORY_PER_PIXEL if that is more);
        where that is not enough for all tiles at once, frames are read again for some at a time, which changes scores
        by rounding alone. At least two frames and a few tiles are held.
    threads: how many work at a time; None: one a core. Scores are the same bits for any number.
    device: where frames are followed and unwarped, and pixels compared: "cpu", or a GPU as "cuda:0".
    Frames are read one at a time, by one thread, and once where the memory allows. Raises ClipError for frames that
    cannot be measured and ValueError for an unknown name or device.
    """
    measuring = Measuring(
        test,
        reference,
        domain=domain,
        display=display,
        reference_error=reference_error,
        names=names,
        memory=memory,
        threads=threads,
        device=device,
    )
    return measuring.measure(alignment, progress)


class Measuring:
    """A clip that is to be measured.

    In one process: `measure`. In several: one makes the `plan`, others `look` at some of its spans each, and one, which
    reads no frame but the first, for its size, can `join` what they found: the same additions in the same order, and so
    the same bits.
    """

    def __init__(
        self,
        test: Clip,
        reference: Clip | ReferenceFrames | None = None,
        *,
        domain: Domain = "linear",
        display: Display = STANDARD,
        reference_error: FrameSource | None = None,
        names: Sequence[str] | None = None,
        memory: float | None = None,
        threads: int | None = None,
        device: str = "cpu",
    ) -> None:
        """As `metrics.measure` takes it, and raises."""
        registry.check_names(names)
        exact = reference if isinstance(reference, ReferenceFrames) else None
        if isinstance(reference, Clip):
            exact = ReferenceFrames(reference, error=reference_error, domain=domain, display=display)
        elif reference_error is not None:
            raise ValueError("reference_error: needs a clip as reference; leave it out: ReferenceFrames have their own")
        if exact is not None and (exact.domain, exact.display) != (domain, display):
            raise ValueError(
                f"the test is measured in the domain {domain}, the reference is of another domain or display"
            )
        self._test, self._exact, self._names = test, exact, names
        self._domain, self._display = domain, display
        self._clip = _geometry(test, exact.reference if exact else None)
        height, width = self._clip.shape
        self._memory = memory or max(MEMORY, MEMORY_PER_PIXEL * height * width)
        self._threads, self._device = threads, device

    def measure(self, alignment: Alignment | None = None, progress: Progress | None = None) -> Measurement:
        """Measure all spans here. alignment, progress: as `metrics.measure` takes them."""
        with self._launcher() as launcher:
            alignment = alignment or align(self._clip, keep=False, room=self._room, launcher=launcher)
            totals = self._totals(alignment.steps)
            self._look(alignment, launcher, totals.take, progress)
        return totals.finish()

    def plan(self) -> Plan:
        """The spans that the clip is measured in."""
        with self._launcher() as launcher:
            return plan_spans(self._clip, room=self._room, launcher=launcher)

    def look(self, plan: Plan, some: slice) -> list[Found]:
        """What there is in some of the plan's spans, which follow each other."""
        found: list[Found] = []
        with self._launcher() as launcher:
            alignment = align(self._clip, plan=plan, some=some, keep=False, room=self._room, launcher=launcher)
            self._look(alignment, launcher, found.append, None)
        return found

    def join(self, plan: Plan, found: Iterable[Found]) -> Measurement:
        """The scores of what was found in all of the plan's spans, in their order."""
        totals = self._totals(plan.steps)
        for each in found:
            totals.take(each)
        return totals.finish()

    @property
    def _room(self) -> float:
        """Bytes that motion and coverage may take: no more for large frames, of which a span's would not fit anyway."""
        return min(self._memory, MEMORY) / 4

    def _launcher(self) -> Launcher:
        return Launcher(threads=self._threads, device=self._device)

    def _context(self, steps: NDArray[np.float64] | None) -> Context:
        test, exact = self._test, self._exact
        return Context(
            count=test.count,
            has_reference=exact is not None,
            has_floor=exact is not None and exact.has_floor,
            has_depth=self._clip.depth is not None,
            velocity=velocity_of(self._clip, steps),
            fps=test.fps,
            pixels_per_degree=test.pixels_per_degree if self._domain == "linear" else None,
            luminance=test.luminance,
        )

    def _totals(self, steps: NDArray[np.float64] | None) -> Totals:
        context = self._context(steps)
        return Totals(context, self._clip.shape, steps=steps, names=self._names, domain=self._domain)

    def _look(
        self, alignment: Alignment, launcher: Launcher, take: Callable[[Found], None], progress: Progress | None
    ) -> None:
        """Look at every frame of an alignment. take: called with each piece of what is found."""
        exact, context = self._exact, self._context(alignment.steps)
        measures = [measure(context) for measure in registry.measures(self._names)]
        whole = every_pixel(self._names)
        pixels = Pixels(alignment.geometry, launcher, has_reference=context.has_reference)

        floor = GluedPattern(launcher, context.count // 2) if AlignmentFloor in map(type, measures) else None

        def read(place: Placement) -> Pictures:
            t, span = place.t, place.span
            glued = None if floor is None else floor.seen(place)
            paired = None
            if whole and span.part == 0:
                paired = pixels.pair(t, place if span.rows == slice(0, span.shape[0]) else None)
            picture = self._shown(t)
            found = None if exact is None else exact.exact(t)
            off = None if found is None else _minus(picture, found[0], launcher)
            if paired is not None:
                take(pixels.look(t, off, paired))
                paired = None
            # What is not needed any more goes, here as above: large frames are most of the memory.
            picture = place.align(picture)
            if exact is None or found is None or off is None:
                aligned = Pictures(picture, glued=glued)
            elif place.away is None:
                half, found = found[1], None
                aligned = Pictures(picture, place.align(off), None if half is None else place.align(half))
            else:
                aligned = Pictures(picture, *exact.difference(place, picture, found), glued)
            return aligned

        def advance(done: int) -> None:
            if progress is not None:
                progress(done, context.count)

        pictures = 1 + context.has_reference + context.has_floor
        followed = 0
        with Sweep(measures, read, pictures=pictures, memory=self._memory, threads=self._threads) as sweep:
            for span in alignment.spans:
                if whole and span.start not in (followed, *self._clip.cuts):
                    pixels.lead(self._error(span.start - 1, launcher))
                followed = span.stop
                pixels.begin(span)
                if measures:
                    sweep.run(span, advance, lambda found: take(PartFound(found)))
                elif whole:
                    for t in range(span.start, span.stop):
                        take(pixels.look(t, self._error(t, launcher), pixels.pair(t)))
                        advance(t + 1)
                take(SpanFound(span.start, span.stop, bool(span.levels)))

    def _shown(self, t: int) -> Image:
        return to_domain(self._test.planes(t), self._domain, self._display, t)

    def _error(self, t: int, launcher: Launcher) -> Image | None:
        """Frame t of the test minus that of the reference, [3, H, W]; None without one."""
        return None if self._exact is None else _minus(self._shown(t), self._exact.exact(t)[0], launcher)


def _minus(test: Image, reference: Image, launcher: Launcher) -> Image:
    difference = unset(test.shape, np.result_type(test, reference))

    def subtract(strip: Strip) -> None:
        rows = slice(strip.first, strip.first + strip.rows)
        np.subtract(test[:, rows], reference[:, rows], out=difference[:, rows])

    launcher.each(launcher.strips(test.shape[1]), subtract)
    return difference


def _geometry(test: Clip, reference: Clip | None) -> Clip:
    """The test with what the reference knows of coverage and depth. Raises ClipError if they do not match."""
    if reference is None:
        return test
    if reference.count != test.count:
        raise ClipError(f"the test has {test.count}, the reference {reference.count} frames; they must match")
    if reference.shape != test.shape:
        raise ClipError(
            f"the test is {test.shape[1]}x{test.shape[0]} px and the reference "
            f"{reference.shape[1]}x{reference.shape[0]} px; they must match"
        )
    return test.with_geometry(reference)
