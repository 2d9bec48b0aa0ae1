"""Frames by index, from image files or a video: their header, their stored values, and what is wrong with them."""

from collections import Counter
from collections.abc import Sequence
from concurrent.futures import ThreadPoolExecutor
from typing import Protocol

from metrics.machine import cores
from swimlab.footage.header import Header, find_damage, read_header, read_stored
from swimlab.footage.pattern import Files, find_files, is_video
from swimlab.footage.video import VideoReader
from swimlab.runs.frames import FrameError, Image

LEAVE_OUT = "mend the frame, or leave it out with --skip-bad-frames"


class Reader(Protocol):
    """Frames 0..len(numbers)-1, read one at a time."""

    name: str
    numbers: tuple[int, ...]
    header: Header
    gaps: frozenset[int]
    """Indices without a frame, by the time stamps of a video: nothing was shown anew then."""

    def label(self, index: int) -> str:
        """What to call a frame in a message."""

    def problems(self, part: int, channels: Sequence[str]) -> dict[int, str]:
        """What is wrong with frames, by index, as far as headers tell: missing, another size, no such channels."""

    def damage(self) -> dict[int, str]:
        """What is wrong with the data of frames that are there and can be opened, by index: cut short, garbled."""

    def read(self, index: int, part: int, channels: Sequence[str]) -> Image:
        """Stored values [H, W, len(channels)], integers scaled to 0..1. Raises FrameError naming the frame."""


def open_frames(name: str, *, frames: str | None = None) -> Reader:
    """Open a pattern, a folder, a file or a video. Raises FrameError where there is nothing that can be read."""
    files = find_files(name, frames=frames)
    first = str(files.paths[0])
    return VideoReader(first, frames=frames) if is_video(first) else ImageReader(files)


class ImageReader:
    """Frames of image files."""

    def __init__(self, files: Files) -> None:
        """Raises FrameError where no file can be read."""
        self.name = files.name
        self.numbers = files.numbers
        self.gaps: frozenset[int] = frozenset()
        self._paths = files.paths
        self._missing = frozenset(files.missing)
        self._headers: dict[int, Header | str] = {}
        self.header = self._typical()

    def label(self, index: int) -> str:
        return str(self._paths[index])

    def problems(self, part: int, channels: Sequence[str]) -> dict[int, str]:
        found = {}
        for index, path in enumerate(self._paths):
            header = self._header(index)
            if isinstance(header, str):
                found[index] = header
            elif header.size != self.header.size:
                sizes = "{}x{} px, but most frames are {}x{} px".format(*header.size, *self.header.size)
                found[index] = f"{path}: is {sizes}; all need one size: {LEAVE_OUT}"
            elif part >= len(header.parts) or not set(channels) <= set(header.parts[part].channels):
                names = ", ".join(name for each in header.parts for name in each.channels)
                found[index] = (
                    f"{path}: has no channels {', '.join(channels)} as the others have; it has {names}; {LEAVE_OUT}"
                )
            elif header.parts[part].colour_space != self.header.parts[part].colour_space:
                said, most = (each.parts[part].colour_space or "no colour space" for each in (header, self.header))
                found[index] = f"{path}: says that it is in {said}, the first frame {most}; all need one: {LEAVE_OUT}"
        return found

    def damage(self) -> dict[int, str]:
        opened = [index for index in range(len(self._paths)) if isinstance(self._header(index), Header)]
        with ThreadPoolExecutor(cores()) as pool:
            found = dict(zip(opened, pool.map(lambda index: find_damage(self._paths[index]), opened), strict=True))
        return {index: fault for index, fault in found.items() if fault}

    def read(self, index: int, part: int, channels: Sequence[str]) -> Image:
        if self.numbers[index] in self._missing:
            raise FrameError(self._gone(index))
        return read_stored(self._paths[index], part, channels)

    def _header(self, index: int) -> Header | str:
        """A frame's header, or what is wrong with it."""
        if index not in self._headers:
            if self.numbers[index] in self._missing:
                self._headers[index] = self._gone(index)
            else:
                try:
                    self._headers[index] = read_header(self._paths[index])
                except FrameError as error:
                    self._headers[index] = f"{error}; {LEAVE_OUT}"
        return self._headers[index]

    def _typical(self) -> Header:
        """The header of the first frame of the size that most frames have. Raises FrameError if none can be read."""
        headers = [self._header(index) for index in range(len(self._paths))]
        good = [header for header in headers if isinstance(header, Header)]
        if not good:
            raise FrameError(next(header for header in headers if isinstance(header, str)))
        size = Counter(header.size for header in good).most_common(1)[0][0]
        return next(header for header in good if header.size == size)

    def _gone(self, index: int) -> str:
        missing = len(self._missing)
        return (
            f"{self._paths[index]}: is missing, frame {self.numbers[index]} of {self.numbers[0]} to {self.numbers[-1]} "
            f"({missing} missing in all); complete the range, or leave the frame out with --skip-bad-frames"
        )
