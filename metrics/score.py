"""Measure a clip: one pass over the frames feeds every measure."""

from collections.abc import Callable, Mapping, Sequence

import numpy as np
from numpy.typing import NDArray

from metrics import registry
from metrics.clip import Clip, ClipError, FrameSource, Image
from metrics.display import STANDARD, Display, Domain, to_domain
from metrics.kernels.launch import Launcher
from metrics.measurement import Context, Measurement
from metrics.reference_frames import ReferenceFrames
from metrics.spans import Alignment, Placement, align
from metrics.spectra import Pictures
from metrics.sweep import Sweep
from metrics.tiles import SIZES
from metrics.whole_frame import SCORES as WHOLE_FRAME
from metrics.whole_frame import WholeFrame

# A screen-fixed error must travel this far against the surface to read as flicker for more than .9, px.
TRAVEL = 25.0

HALF_THE_PICTURE = 0.5
"""Below this share of measured pixels there is a note."""

MEMORY, MEMORY_PER_PIXEL = 1.2e9, 290.0
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
    memory: bytes that may be taken beside what `alignment` holds (None: MEMORY, or MEMORY_PER_PIXEL for frames above
        4 megapixels); where that is not enough for all tiles at once,
        frames are read again for some at a time. At least two frames and a few tiles are held.
    threads: how many work at a time; None: one a core. Scores are the same bits for any number and any memory.
    device: where frames are followed and unwarped, and pixels compared: "cpu", or a GPU as "cuda:0".
    Frames are read one at a time, by one thread, and once where the memory allows. Raises ClipError for frames that
    cannot be measured and ValueError for an unknown name or device.
    """
    registry.check_names(names)
    exact = reference if isinstance(reference, ReferenceFrames) else None
    if isinstance(reference, Clip):
        exact = ReferenceFrames(reference, error=reference_error, domain=domain, display=display)
    elif reference_error is not None:
        raise ValueError("reference_error: needs a clip as reference; leave it out: ReferenceFrames have their own")
    if exact is not None and (exact.domain, exact.display) != (domain, display):
        raise ValueError(f"the test is measured in the domain {domain}, the reference is of another domain or display")
    geometry = _geometry(test, exact.reference if exact else None)
    height, width = geometry.shape
    memory = memory or max(MEMORY, MEMORY_PER_PIXEL * height * width)
    launcher = Launcher(threads=threads, device=device)
    alignment = alignment or align(geometry, keep=False, room=memory / 4, launcher=launcher)
    steps = alignment.steps
    context = Context(
        count=test.count,
        has_reference=exact is not None,
        has_floor=exact is not None and exact.has_floor,
        has_depth=geometry.depth is not None,
        velocity=_velocity(geometry, steps),
        fps=test.fps,
        pixels_per_degree=test.pixels_per_degree if domain == "linear" else None,
        luminance=test.luminance,
    )
    every_pixel = any(registry.selected(name, names) for name in WHOLE_FRAME)
    measures = [measure_type(context) for measure_type in registry.measures(names)]

    whole = WholeFrame(alignment.geometry, exact is not None, launcher)

    def shown(t: int) -> Image:
        return to_domain(test.planes(t), domain, display, t)

    def read(place: Placement) -> Pictures:
        picture, t = shown(place.t), place.t
        found = None if exact is None else exact.exact(t)
        off = None if found is None else picture - found[0]
        if every_pixel and place.span.part == 0:
            span = place.span
            whole.add(t, off, place if span.rows == slice(0, span.shape[0]) else None)
        seen = place.align(picture)
        if exact is None or found is None or off is None:
            return Pictures(seen)
        if place.away is None:
            half = found[1]
            return Pictures(seen, place.align(off), None if half is None else place.align(half))
        # Unwarping is linear, and most of the work: the difference is taken after it.
        reference, half = exact.aligned(place, found)
        return Pictures(seen, seen - reference, half)

    notes = []
    longest = 0
    pictures = 1 + context.has_reference + context.has_floor
    with launcher, Sweep(measures, read, pictures=pictures, memory=memory, threads=threads) as sweep:
        for span in alignment.spans:
            whole.begin(span)
            if measures:
                sweep.run(span, lambda done: progress and progress(done, test.count))
            elif every_pixel:
                for t in range(span.start, span.stop):
                    whole.add(t, None if exact is None else shown(t) - exact.exact(t)[0])
                    if progress:
                        progress(t + 1, test.count)
            longest = max(longest, span.count)
            if not span.levels:
                notes.append(f"frames {span.start} to {span.stop - 1}: no tile of {SIZES[-1]} px stays wholly covered")
    if longest < test.count:
        notes.append(f"frames are aligned in spans of {longest} at most: slower changes read as static")
    found = Measurement(notes=notes + (_travel_note(steps) if exact is not None else []))
    for each in measures:
        found.merge(each.finish())
    if every_pixel:
        found.merge(whole.finish())
    found.notes += _extent_note(found.scores) + (whole.glints.notes() if domain == "linear" else [])
    found.scores = {name: found.scores[name] for name in sorted(found.scores) if registry.selected(name, names)}
    found.errors = {name: found.errors[name] for name in found.scores if name in found.errors}
    found.replicates = {name: found.replicates[name] for name in found.scores if name in found.replicates}
    found.absent = {name: found.absent[name] for name in sorted(found.absent) if registry.selected(name, names)}
    found.note_unknown_errors()
    return found


def _geometry(test: Clip, reference: Clip | None) -> Clip:
    """The test with what the reference knows of coverage and depth. Raises ClipError if they do not match."""
    if reference is None:
        return test
    if reference.count != test.count:
        raise ClipError(f"the test has {test.count} frames and the reference {reference.count}; they must match")
    if reference.shape != test.shape:
        raise ClipError(
            f"the test is {test.shape[1]}x{test.shape[0]} px and the reference "
            f"{reference.shape[1]}x{reference.shape[0]} px; they must match"
        )
    return test.with_geometry(reference)


def _velocity(clip: Clip, steps: NDArray[np.float64] | None) -> tuple[float, float] | None:
    """(dx, dy) px a frame, if all steps within a shot are the same to a thousandth of a pixel over the clip."""
    if not callable(clip.motion):
        return clip.motion
    within = [t for t in range(1, clip.count) if t not in clip.cuts]
    if steps is None or not within:
        return None
    mean = steps[within].mean(axis=0)
    strayed = np.cumsum(steps[within] - mean, axis=0)
    return (float(mean[1]), float(mean[0])) if np.max(np.abs(strayed)) < 1e-3 else None


def _extent_note(scores: Mapping[str, float]) -> list[str]:
    """A warning where the budget speaks for less than half of the picture."""
    share = scores.get("measured.fraction", 1.0)
    if share >= HALF_THE_PICTURE:
        return []
    return [
        f"tiles reach {share:.0%} of the picture, and budget, residual and plane speak of these pixels alone; "
        f"edges.* ({scores['edges.fraction']:.0%}) and new.* ({scores['new.fraction']:.0%}) speak of the rest"
    ]


def _travel_note(steps: NDArray[np.float64] | None) -> list[str]:
    """A warning where an error fixed to the screen would not show as one; where nothing moves it is none."""
    if steps is None or len(steps) < 2:
        return []
    travelled = float(np.hypot(*steps[1:].sum(axis=0)))
    if travelled == 0 or travelled >= TRAVEL:
        return []
    return [
        f"the surface travels {travelled:.1f} px: an error fixed to the screen reads as flicker only in part "
        f"below {TRAVEL:g} px"
    ]
