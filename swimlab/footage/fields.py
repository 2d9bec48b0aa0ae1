"""Files of motion vectors, opened for the frames that they belong to."""

from collections.abc import Callable, Sequence

import numpy as np

from swimlab.footage.channels import find_pair
from swimlab.footage.colour import LEVELS
from swimlab.footage.convention import PRESETS, Convention
from swimlab.footage.motion import FieldMotion
from swimlab.footage.pattern import frame_range
from swimlab.footage.reader import Reader
from swimlab.footage.source import Box, Mask
from swimlab.runs.frames import FrameError

_COARSE = 0.05
"""Steps of the stored codes that are worth a word, px: half of one is about what an estimated motion is off."""


def open_fields(
    reader: Reader,
    convention: Convention,
    *,
    size: tuple[int, int],
    kept: list[int],
    crop: Box | None,
    mask: Mask | None,
    part: str | None,
    places: Sequence[int],
    note: Callable[[str], None],
    say: Callable[[str], None],
) -> FieldMotion:
    """The motion in files of vectors, one a frame.

    places: of the frames among the vectors, by index: more than one apart where frames are skipped.
    size: width and height of the frames. kept: indices of the frames that are measured. crop: in the frames' px. mask:
    where vectors are valid, None: everywhere. part: of the files, by name, view or index. note, say: called with what
    the scores should keep, and with what else there is to know. Raises FrameError where a file that is needed cannot be
    used, or the vectors are not of the frames' view.
    """
    convention = _of_files(convention, reader)
    _check_view(reader, size)
    if mask is not None and mask.reader.header.size != reader.header.size:
        sizes = "{}x{} px, the motion vectors {}x{} px".format(*mask.reader.header.size, *reader.header.size)
        raise FrameError(f"--motion-mask {mask.reader.name}: is {sizes}; give a mask of the vectors' size")
    index, channels = find_pair(reader.header, convention.channels, reader.name, part=part)
    offset = ", offset {:g},{:g}".format(*convention.offset) if any(convention.offset) else ""
    say(
        f"motion from {','.join(channels)}: {convention.unit}, {convention.direction}, +y {convention.y}, "
        f"scale {convention.scale[0]:g},{convention.scale[1]:g}{offset}"
    )
    needed = range(places[kept[0]], places[kept[-1]] + 1)
    needed = needed[1:] if convention.direction == "backward" else needed[:-1]
    problems = reader.problems(index, channels)
    for frame in needed:
        if frame in problems:
            fault = problems[frame].partition("; ")[0]
            raise FrameError(f"{fault}; write it anew: motion vectors of skipped frames are needed too")
    motion = FieldMotion(reader, index, channels, convention, crop, size=size, mask=mask, places=places)
    if size != reader.header.size:
        note("motion vectors of {}x{} px are resampled for frames of {}x{} px".format(*reader.header.size, *size))
    _note_steps(motion, reader, index, note)
    unknown = motion.vectors.survey(needed)
    if unknown:
        numbers = [reader.numbers[frame] for frame in unknown]
        most = max(unknown, key=lambda frame: unknown[frame])
        note(
            f"motion is unknown (vectors NaN, masked or not written) in {np.mean(list(unknown.values())):.2%} of the "
            f"pixels of motion frames {frame_range(numbers)}, at most in {reader.numbers[most]} ({unknown[most]:.2%}); "
            "they are not measured"
        )
    return motion


def _of_files(convention: Convention, reader: Reader) -> Convention:
    """The convention, or nuke's for forward channels where there are no backward ones."""
    if convention != PRESETS["nuke"]:
        return convention
    channels = {channel for part in reader.header.parts for channel in part.channels}
    backward = any(channel.endswith("backward.u") for channel in channels)
    return convention if backward else PRESETS["nuke-forward"]


def _check_view(reader: Reader, size: tuple[int, int]) -> None:
    """Raise FrameError where no scale makes vectors' and frames' sizes of one another, each side off by under 1 px.

    Where one side is the same, nothing was scaled, and the other must be so too.
    """
    (across, down), (width, height) = reader.header.size, size
    apart = max((across - 1) / width, (down - 1) / height) >= min((across + 1) / width, (down + 1) / height)
    if apart or (across == width) != (down == height):
        raise FrameError(
            f"--motion {reader.name}: is {across}x{down} px, the frames {width}x{height} px: more than rounding apart "
            "in shape, so they are not of the same view; cut or render the vectors to the view of the frames"
        )


def _note_steps(motion: FieldMotion, reader: Reader, part: int, note: Callable[[str], None]) -> None:
    """Say by how much a vector of about no motion can differ from the next one that its type can hold."""
    header = reader.header.parts[part]
    stored_as = header.types[header.channels.index(motion.channels[0])]
    if stored_as == "half":
        step = float(np.spacing(np.float16(abs(motion.convention.offset[0]))))
    elif stored_as in LEVELS:
        step = 1 / LEVELS[stored_as]
    else:
        return
    coarsest = step * float(np.abs(motion.factors).max())
    if coarsest > _COARSE:
        step_said = f"near no motion in steps of {coarsest:.2g} px"
        note(f"motion vectors are stored as {stored_as}, {step_said}; store 32-bit floats")
