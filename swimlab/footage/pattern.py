"""Which files a name stands for: one file, a folder, or a pattern with `####`, `%04d` and perhaps a range `1-48x2`."""

import re
from collections.abc import Iterable
from dataclasses import dataclass
from pathlib import Path, PurePath

from swimlab.runs.frames import FrameError

IMAGES = frozenset({".exr", ".png", ".tif", ".tiff", ".hdr", ".dpx", ".jpg", ".jpeg", ".webp", ".tga", ".bmp"})
VIDEOS = frozenset({".mp4", ".mov", ".mkv", ".avi", ".webm", ".m4v", ".nut"})

_TOKEN = re.compile(r"(?:(?<![^._])(?P<range>-?\d[-\d,x:]*[-,][-\d,x:]*))?(?P<padding>#+|%0?\d*d)")
_LISTED = 5


@dataclass(frozen=True)
class Files:
    """Files in the order of their frame numbers; those of `missing` numbers are not there."""

    name: str
    numbers: tuple[int, ...]
    paths: tuple[Path, ...]
    missing: tuple[int, ...] = ()

    @property
    def range(self) -> str:
        """The frame numbers in short, as 0-31 or 1-47x2."""
        return frame_range(self.numbers)


@dataclass(frozen=True)
class Pattern:
    """A path with a place for frame numbers in its last part."""

    folder: PurePath
    before: str
    after: str
    width: int
    range: str | None
    """Frame numbers that the pattern itself names, as 1-48x2."""

    def file_name(self, number: int) -> str:
        """The name of one frame's file."""
        return f"{self.before}{number:0{self.width}d}{self.after}"


def parse_pattern(path: PurePath) -> Pattern | None:
    """Read a path of any system as a pattern; None where its last part has no place for frame numbers.

    The file system is not asked. Only the last part is read: a `#`, `%` or `[` in a folder's name stands for itself.
    """
    token = next(reversed(list(_TOKEN.finditer(path.name))), None)
    if token is None:
        return None
    before, after = path.name[: token.start()], path.name[token.end() :]
    return Pattern(path.parent, before, after, _width(token["padding"]), token["range"])


def holds_frames(name: str) -> bool:
    """Whether a name is that of frames: a pattern, an image or video file, or a folder of them that is no run."""
    path = Path(name)
    if path.is_dir():
        return not (path / "run.json").exists() and bool(_patterns(path))
    return parse_pattern(path) is not None or path.suffix.lower() in IMAGES | VIDEOS


def is_video(name: str) -> bool:
    """Whether a name is that of a video file, by its ending."""
    return Path(name).suffix.lower() in VIDEOS


def find_files(name: str, *, frames: str | None = None) -> Files:
    """Find the files of a pattern, a folder that holds one sequence, or a single file (frame 0).

    A lone `#` stands for four digits, `##` and more for one each. The frames are those of the pattern's own range, else
    of `frames`, else all from the first file to the last, in steps of 1.
    Raises FrameError where there is no such file or a range cannot be read.
    """
    path = Path(name)
    if path.is_dir():
        name = _only_sequence(path)
        path = Path(name)
    pattern = parse_pattern(path)
    if pattern is None or path.is_file():  # a file may have a # in its name
        if not path.is_file():
            raise FrameError(f"{name}: no such file; write a frame's number in a pattern as ####, as in shot.####.exr")
        return Files(name, (0,), (path,))
    found = _numbers(path.parent, pattern.before, pattern.after, pattern.width)
    frames = pattern.range or frames
    if frames is not None:
        numbers = parse_range(frames, name)
    elif found:
        numbers = tuple(range(min(found), max(found) + 1))
    else:
        raise FrameError(f"{name}: no file matches{_others(path.parent)}")
    paths = tuple(path.parent / pattern.file_name(number) for number in numbers)
    missing = tuple(number for number in numbers if number not in found)
    if len(missing) == len(numbers):
        raise FrameError(f"{name}: none of the frames {frame_range(numbers)} is there{_others(path.parent)}")
    return Files(name, numbers, paths, missing)


def parse_range(text: str, name: str) -> tuple[int, ...]:
    """Frame numbers in order from 1-48, 1-48x2 or 3,5. Raises FrameError naming what it was given for."""
    from fileseq.frameset import FrameSet  # heavy

    try:
        return tuple(sorted({int(str(frame)) for frame in FrameSet(text)}))
    except ValueError as error:
        raise FrameError(f"{name}: {text} is no range of frames; write 1-48, 1-48x2 or 3,5") from error


def frame_range(numbers: Iterable[int]) -> str:
    """Frame numbers in short, as 0-31 or 1-47x2."""
    from fileseq.frameset import FrameSet  # heavy

    return str(FrameSet(list(numbers)))


def _width(padding: str) -> int:
    """Digits that a padding stands for: # 4, ## 2, %03d 3, %d 1."""
    if padding.startswith("#"):
        return 4 if padding == "#" else len(padding)
    return int(padding[1:-1] or "1")


def _numbers(folder: Path, before: str, after: str, width: int) -> set[int]:
    """Numbers of the files that are there: those that, written with `width` digits, give the file's name again."""
    shape = re.compile(re.escape(before) + r"(-?\d+)" + re.escape(after))
    names = (entry.name for entry in folder.iterdir()) if folder.is_dir() else ()
    texts = (match[1] for match in map(shape.fullmatch, names) if match)
    return {int(text) for text in texts if f"{int(text):0{width}d}" == text}


def _only_sequence(folder: Path) -> str:
    """The pattern of the one sequence, or the name of the one file, that a folder holds. Raises FrameError."""
    patterns = _patterns(folder)
    if len(patterns) != 1:
        several = f"several sequences ({', '.join(patterns[:_LISTED])}); name one" if patterns else "no image files"
        raise FrameError(f"{folder}: holds {several}")
    return str(folder / patterns[0])


def _patterns(folder: Path) -> list[str]:
    """File names in a folder with the last number of each as #: what sequences there are."""
    found: dict[str, None] = {}
    for path in sorted(folder.iterdir()) if folder.is_dir() else ():
        if path.suffix.lower() in IMAGES | VIDEOS and not path.name.startswith("."):
            digits = re.search(r"\d+(?=\D*$)", path.stem) if path.suffix.lower() in IMAGES else None
            found[_as_pattern(path.name, digits) if digits else path.name] = None
    return list(found)


def _as_pattern(name: str, digits: re.Match[str]) -> str:
    padding = f"%0{len(digits[0])}d" if len(digits[0]) == 1 else "#" * len(digits[0])
    return name[: digits.start()] + padding + name[digits.end() :]


def _others(folder: Path) -> str:
    """What else a folder holds, for an error message."""
    if not folder.is_dir():
        return f"; there is no folder {folder}"
    patterns = _patterns(folder)
    return f"; {folder} holds {', '.join(patterns[:_LISTED])}" if patterns else f"; {folder} holds no image files"
