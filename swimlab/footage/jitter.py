"""The sub-pixel jitter of a projection: read from a file, and taken out of a motion or put into it.

An engine that accumulates frames renders each one shifted by a part of a pixel. Its content then moves by the surface's
own motion and by the change of that shift. Where only the vectors have it, since the frames are accumulated or rendered
without, it is to be taken out of them; where only the frames have it, it is to be put in.
"""

import re
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Literal

import numpy as np
from numpy.typing import NDArray

from swimlab.footage.motion import FieldMotion, Motion, Points
from swimlab.footage.vectors import Known
from swimlab.runs.counting import counted
from swimlab.runs.frames import FrameError, Image

Side = Literal["vectors", "frames"]
Offsets = NDArray[np.float64]

_FORM = "give a line a frame: frame,x,y or x,y, in px right and down"
_OTHER: dict[Side, Side] = {"vectors": "frames", "frames": "vectors"}


class JitteredMotion:
    """A motion whose vectors, or whose frames, were rendered with a jitter that the other ones do not have.

    A vector is read where it stands, not where it would stand without jitter: they differ by half a pixel of the
    motion's gradient at most.
    """

    def __init__(self, motion: Motion, offsets: Offsets, side: Side) -> None:
        """offsets: [n, 2], by how much the content of each frame is shifted, px of the frames, right and down.

        side: "vectors": the jitter is taken out of the motion, "frames": put in.
        """
        self.motion = motion
        self.offsets = offsets
        self.side = side

    def back(self, points: Points, start: int, stop: int) -> Points:
        for index in range(start, stop, -1):
            points = self.motion.back(points, index, index - 1) - self._added(index, index - 1)[::-1, None]
        return points

    def moved(self, start: int, stop: int) -> Image:
        return np.asarray(self.motion.moved(start, stop) + self._added(start, stop), np.float32)

    def known(self, start: int, stop: int) -> Known | None:
        return self.motion.known(start, stop)

    def variants(self) -> dict[str, tuple[str, Motion]]:
        other = _OTHER[self.side]
        found: dict[str, tuple[str, Motion]] = {
            f"jitter in the {other}": (f"--motion-jitter-in {other}", JitteredMotion(self.motion, self.offsets, other)),
            "without jitter": ("no --motion-jitter", self.motion),
        }
        for name, (setting, motion) in self.motion.variants().items():
            found[name] = setting, JitteredMotion(motion, self.offsets, self.side)
        return found

    def _added(self, start: int, stop: int) -> NDArray[np.float64]:
        """(x, y) px that the motion gains by the jitter from frame `stop` to `start`."""
        change = self.offsets[start] - self.offsets[stop]
        return np.asarray(change if self.side == "frames" else -change)


def with_jitter_of_file(
    motion: Motion, path: Path, side: Side, numbers: Sequence[int], note: Callable[[str], None]
) -> JitteredMotion:
    """A motion without the jitter of its vectors, or with that of the frames, as a file has it.

    The file's px are those of the vectors where there are any. numbers: the frames' numbers. note: called with what was
    done. Raises FrameError naming the file and line, or where one vector for all frames is to have jitter in it.
    """
    if side == "vectors" and not isinstance(motion, FieldMotion):
        raise FrameError(
            "--motion-jitter: one vector for all frames has no jitter in it; give --motion-jitter-in frames"
        )
    offsets = read_offsets(path, numbers)
    done = "taken out of the motion vectors" if side == "vectors" else "put into the motion"
    note(f"jitter of up to {np.abs(offsets).max():.2g} px is {done}")
    return JitteredMotion(motion, offsets * motion.vectors.ratio if isinstance(motion, FieldMotion) else offsets, side)


def read_offsets(path: Path, numbers: Sequence[int]) -> Offsets:
    """[len(numbers), 2]: the jitter of each frame as a text file has it.

    Lines of frame,x,y, or of x,y in the order of the frames, separated by commas, semicolons or blanks; `#` starts a
    comment; a line of names may come first. numbers: the frames' numbers. Raises FrameError naming the file and line.
    """
    rows = _rows(path)
    if len(rows[0][1]) == 2:
        if len(rows) != len(numbers):
            has = f"has {counted(len(rows), 'line')} for {counted(len(numbers), 'frame')}"
            raise FrameError(f"--motion-jitter {path}: {has}; {_FORM}")
        return np.array([values for _, values in rows])
    found: dict[int, list[float]] = {}
    for line, (frame, *offset) in rows:
        if frame != int(frame) or int(frame) in found:
            fault = f"frame {frame:g} comes twice" if frame in found else f"{frame:g} is no frame number"
            raise FrameError(f"--motion-jitter {path}, line {line}: {fault}; {_FORM}")
        found[int(frame)] = offset
    missing = [number for number in numbers if number not in found]
    if missing:
        raise FrameError(f"--motion-jitter {path}: has no line for frame {missing[0]}, {len(missing)} missing; {_FORM}")
    return np.array([found[number] for number in numbers])


def _rows(path: Path) -> list[tuple[int, list[float]]]:
    """Line number and values of every line that has any, all as many: two or three."""
    try:
        text = path.read_text(encoding="utf-8-sig")
    except (OSError, UnicodeDecodeError) as error:
        raise FrameError(f"--motion-jitter {path}: cannot be read: {error}; name a text file") from error
    rows: list[tuple[int, list[float]]] = []
    named = False
    for line, content in enumerate(text.splitlines(), start=1):
        content = content.partition("#")[0].strip(" \t,;")
        if not content:
            continue
        words = re.split(r"\s*[,;]\s*" if re.search("[,;]", content) else r"\s+", content)
        where = f"--motion-jitter {path}, line {line}"
        if not rows and not named and not any(map(_is_number, words)):
            named = True
            if [word.lower()[-1] for word in words[-2:]] != ["x", "y"]:
                raise FrameError(f"{where}: its columns are {', '.join(words)}; {_FORM}")
            continue
        wrong = next((word for word in words if not _is_number(word)), None)
        if wrong is not None:
            raise FrameError(f"{where}: {wrong or 'an empty value'} is not a number; {_FORM}")
        if len(words) not in (2, 3) or (rows and len(words) != len(rows[0][1])):
            raise FrameError(f"{where}: has {counted(len(words), 'value')}; {_FORM}, all lines alike")
        rows.append((line, [float(word) for word in words]))
    if not rows:
        raise FrameError(f"--motion-jitter {path}: has no lines; {_FORM}")
    return rows


def _is_number(word: str) -> bool:
    """Whether a word is a finite number."""
    try:
        return bool(np.isfinite(float(word)))
    except ValueError:
        return False
