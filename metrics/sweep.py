"""The sweep over a clip: frames are read and aligned by one thread while others transform those before."""

from collections import deque
from collections.abc import Callable, Iterator, Sequence
from concurrent.futures import ThreadPoolExecutor
from functools import partial
from itertools import islice
from types import TracebackType
from typing import Any, NamedTuple

from metrics.machine import cores
from metrics.measurement import Measure
from metrics.parts import Piece, parts, pieces
from metrics.spans import Placement, Span
from metrics.spectra import Batch, Course, Pictures, transforms
from metrics.tiles import Level
from metrics.transform import TileTransform

CHUNK = 4
"""Frames at most that a piece of tiles is followed through while it stays in the cache."""

# Share of the memory for two chunks of frames, and for those that need not be unwarped.
_FRAMES = 0.1
_FRAMES_AS_THEY_ARE = 0.3

# Bytes a pixel while a frame is read, and while it is unwarped.
_READING = 60.0
_UNWARPING = 120.0

# Bytes a pixel of the last frame of a chunk, which the next one follows.
_FOLLOWED = 12.0

# Share of the memory that spectra and places may take at least: less would have frames read too often.
_LEAST = 0.15

Read = Callable[[Placement], Pictures]


class Ready(NamedTuple):
    """Frame t, aligned, and what its tiles of every level are transformed with."""

    t: int
    pictures: Pictures
    transforms: list[TileTransform]

    def batch(self, course: Course, number: int, piece: Piece, before: Batch | None) -> Batch:
        """A piece of its tiles, and the same of the frame before."""
        transform = self.transforms[piece.level]
        return Batch(self.t, piece.level, number, piece.tiles, self.pictures, transform, course, before)


class Sweep:
    """Feeds measures with the spectra of spans, in no more memory than was given."""

    def __init__(
        self, measures: Sequence[Measure], read: Read, *, pictures: int, memory: float, threads: int | None
    ) -> None:
        """read: where a frame lies on a part of a span -> `pictures` pictures, aligned."""
        self._measures, self._read, self._memory = measures, read, memory
        self._frame, self._has_reference = 12.0 * pictures, pictures > 1
        count = threads or cores()
        self._pool = ThreadPoolExecutor(count) if count > 1 else None

    def __enter__(self) -> "Sweep":
        return self

    def __exit__(self, kind: type[BaseException] | None, *_: BaseException | TracebackType | None) -> None:
        if self._pool is not None:
            self._pool.shutdown(wait=True, cancel_futures=kind is not None)

    def run(self, span: Span, advance: Callable[[int], object], take: Callable[[list[Any]], object]) -> None:
        """Feed a span; `advance` is called with the number of the clip's frames that are done.

        take: called after each part with what every measure found in it.
        """
        height, width = span.shape
        frame = self._frame * height * width
        share, making = (_FRAMES_AS_THEY_ARE, _READING) if span.correspondence is None else (_FRAMES, _UNWARPING)
        chunk = int(min(CHUNK, max(1.0, share * self._memory / (2 * frame))))
        last = _FOLLOWED * height * width
        room = max(_LEAST * self._memory, self._memory - 2 * chunk * frame - last - making * height * width)
        some = deque(parts(span, self._held, room))
        total = len(some)
        for number in range(total):
            # A part holds its places until it is let go.
            part = some.popleft()
            for measure in self._measures:
                measure.begin(part)
            before = span.start * total + number * span.count
            for done in self._feed(part, chunk):
                advance((before + done) // total)
            take([measure.end() for measure in self._measures])

    def _held(self, level: Level) -> float:
        course = Course.held(level, has_reference=self._has_reference)
        return course + sum(measure.held(level) for measure in self._measures)

    def _feed(self, part: Span, chunk: int) -> Iterator[int]:
        """Feed a part of a span; yields how many of its frames are done."""
        course, placements = Course(part, has_reference=self._has_reference), part.placements()
        upcoming = [self._ready(place) for place in islice(placements, chunk)]
        last = None
        while upcoming:
            current = upcoming
            follow = partial(self._follow, current, last, course)
            ends = [self._start(partial(follow, *each)) for each in enumerate(pieces(part))]
            upcoming = [self._ready(place) for place in islice(placements, chunk)]
            for end in ends:
                end()
            yield from (ready.t + 1 - part.start for ready in current)
            last = current[-1]._replace(pictures=current[-1].pictures.followed())

    def _start(self, job: Callable[[], None]) -> Callable[[], None]:
        """Start a job in another thread, if there is to be one; what is returned waits for its end, or does it."""
        return job if self._pool is None else self._pool.submit(job).result

    def _ready(self, place: Placement) -> Ready:
        return Ready(place.t, self._read(place), transforms(place.span, place.t))

    def _follow(self, frames: Sequence[Ready], last: Ready | None, course: Course, number: int, piece: Piece) -> None:
        """Feed a piece of tiles frame by frame. last: the frame before the first."""
        before = None if last is None else last.batch(course, number, piece, None)
        for ready in frames:
            before = ready.batch(course, number, piece, before)
            for measure in self._measures:
                measure.add(before)
