"""Several builds of one shot, opened side by side: the same frames, one reference, one motion."""

from collections.abc import Callable, Mapping
from dataclasses import replace
from pathlib import Path

from swimlab.footage.opened import Opened
from swimlab.footage.pattern import frame_range
from swimlab.footage.request import Request
from swimlab.footage.subject import Subject
from swimlab.runs.frames import FrameError

Say = Callable[[str], None]


def of_same_frames(requests: Mapping[str, Request]) -> dict[str, Request]:
    """Requests of builds by name, each without the frames that are bad in another, where bad frames are left out.

    All frames are read for that. Raises FrameError as `Opened` does, naming the build.
    """
    if len(requests) == 1 or not any(request.skip_bad_frames for request in requests.values()):
        return dict(requests)
    bad: dict[str, frozenset[int]] = {}
    for name, request in requests.items():
        try:
            bad[name] = Opened(replace(request, left_out=()), lambda _: None, lambda _: None).bad
        except FrameError as error:
            raise FrameError(f"{name}: {error}") from error
    return {
        name: replace(
            request,
            left_out=tuple((other, tuple(sorted(more))) for other in bad if (more := bad[other] - bad[name])),
        )
        for name, request in requests.items()
    }


def open_builds(
    requests: Mapping[str, Request], say: Say, warn: Say, *, pictures: Path | None = None
) -> dict[str, Subject]:
    """The opened inputs of builds by name; what they share is found once. The rest as `Subject` takes it.

    Raises FrameError as `Subject` does, naming the build where there are several, and where two are of other frames.
    """
    opened: dict[str, Subject] = {}
    for name, request in requests.items():
        first = next(iter(opened.values()), None)

        def named(text: str, name: str = name) -> str:
            return f"{name}: {text}" if len(requests) > 1 else text

        try:
            subject = Subject(
                request,
                lambda text, named=named: say(named(text)),  # type: ignore[misc]
                lambda text, named=named: warn(named(text)),  # type: ignore[misc]
                pictures=pictures,
                like=first,
            )
        except FrameError as error:
            raise FrameError(named(str(error))) from error
        if first is not None:
            _match(name, subject, next(iter(opened)), first)
        opened[name] = subject
    return opened


def _match(name: str, subject: Subject, other: str, first: Subject) -> None:
    mine, theirs = subject.test, first.test
    if mine.shape != theirs.shape:
        sizes = (mine.shape[1], mine.shape[0], other, theirs.shape[1], theirs.shape[0])
        raise FrameError("{}: is {}x{} px, {} {}x{} px; builds of one shot have one size".format(name, *sizes))
    if mine.reader.numbers != theirs.reader.numbers:
        raise FrameError(
            f"{name}: has the frames {frame_range(mine.reader.numbers)}, {other} {frame_range(theirs.reader.numbers)}; "
            "builds of one shot have the same: choose them with frames, or rename the files"
        )
    if subject.fps != first.fps:
        raise FrameError(
            f"{name}: has {subject.fps:g} frames a second, {other} {first.fps:g}; say the shot's rate with fps"
        )
    read, reads = (each.reference.reading if each.reference else None for each in (subject, first))
    if read != reads:
        raise FrameError(
            f"{name}: reads the reference otherwise than {other} does, as the reference takes what it does not say "
            "from the build; say its channels, colorspace, alpha and part by the reference's own options"
        )
