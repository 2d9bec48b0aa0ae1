"""How the picture moves, as a request says: not at all, by one vector, by files of vectors, or as the frames tell."""

from collections.abc import Callable
from pathlib import Path
from typing import NamedTuple, Protocol

from swimlab.footage.between import lacking_between, with_between
from swimlab.footage.fields import open_fields
from swimlab.footage.jitter import with_jitter_of_file
from swimlab.footage.motion import EstimatedMotion, Motion, UniformMotion
from swimlab.footage.pattern import is_video
from swimlab.footage.reader import Reader, open_frames
from swimlab.footage.request import ESTIMATE, Request
from swimlab.footage.source import Mask, Source
from swimlab.runs.frames import FrameError

Say = Callable[[str], None]


class Moving(NamedTuple):
    """A motion, what to call it, and width and height of its files of vectors if it has any.

    lacking: what its files lack, which may be why it does not fit.
    """

    kind: str
    motion: Motion
    size: list[int] | None = None
    lacking: str = ""


class Match(Protocol):
    """Raises FrameError where an input, which is called `what`, has another number of frames than the test."""

    def __call__(self, reader: Reader, what: str, *, still: bool = False) -> None: ...


def open_motion(
    request: Request, test: Source, reference: Source | None, kept: list[int], *, match: Match, note: Say, say: Say
) -> Moving:
    """The motion, without the jitter that a file tells of.

    kept: the indices of the frames that are measured. note, say: called with what a reader of the scores should know.
    """
    _refuse_parts_of_files(request)
    if request.motion is None:
        note("no motion given: nothing is taken to move; if the camera moves, give --motion or --motion estimate")
        return Moving("none", UniformMotion((0.0, 0.0), test.shape))
    if request.motion == ESTIMATE:
        note("the motion is estimated from the frames, which hides part of their flicker and swimming")
        return Moving("estimated", EstimatedMotion((reference or test).picture))
    velocity = request.velocity
    if velocity is not None:
        moving = Moving("uniform", UniformMotion(velocity, test.shape, test.reader.numbers))
    else:
        moving = _open_files(request, request.motion, test, kept, match, note, say)
    if request.motion_jitter in (None, ESTIMATE):
        return moving
    side, numbers = request.motion_jitter_in, test.reader.numbers
    motion = with_jitter_of_file(moving.motion, Path(request.motion_jitter or ""), side, numbers, note)
    return moving._replace(motion=motion)


def _refuse_parts_of_files(request: Request) -> None:
    """Raise FrameError where options of motion vectors come with a motion that has none, or without one another."""
    motion, mask, jitter = request.motion, request.motion_mask, request.motion_jitter
    if motion in (None, ESTIMATE) and (mask or jitter):
        option = "--motion-mask" if mask else "--motion-jitter"
        raise FrameError(f"{option}: is for a motion that is given; give --motion, or leave it out")
    if motion is None and request.motion_part is not None:
        raise FrameError(f"--motion-part {request.motion_part}: is for files of motion vectors; give --motion")
    if jitter is None and request.motion_jitter_in != "vectors":
        raise FrameError("--motion-jitter-in: says what has the jitter; give --motion-jitter FILE or estimate too")
    if motion is not None and mask and request.velocity is not None:
        raise FrameError(f"--motion-mask {mask}: is for files of motion vectors, not for one vector; leave it out")


def _open_files(
    request: Request, name: str, test: Source, kept: list[int], match: Match, note: Say, say: Say
) -> Moving:
    if is_video(name):
        raise FrameError(f"--motion {name}: a video holds no motion vectors; give EXR files")
    numbers = test.reader.numbers
    reader = open_frames(name, frames=request.frames)
    match(reader, "motion")
    reader, places = with_between(reader, numbers, frames=request.frames)
    lacking = lacking_between(numbers, places)
    if lacking:
        note(lacking)
    mask = None
    if request.motion_mask is not None:
        masks = open_frames(request.motion_mask, frames=request.frames)
        match(masks, "motion-mask", still=True)
        if len(masks.numbers) > 1:
            masks, theirs = with_between(masks, numbers, frames=request.frames)
            if theirs != places:
                raise FrameError(
                    f"--motion-mask {masks.name}: frames are skipped, and the motion vectors of these are there, but "
                    "not their masks, or the other way round; give both or none"
                )
        channel, part = request.motion_mask_channels, request.motion_mask_part
        mask = Mask(masks, None, channel=channel, part=part, prefix="motion-mask-")
    motion = open_fields(
        reader,
        request.convention,
        size=test.reader.header.size,
        kept=kept,
        crop=request.look.crop,
        part=request.motion_part,
        mask=mask,
        places=places,
        note=note,
        say=say,
    )
    return Moving("fields", motion, list(reader.header.size), lacking)
