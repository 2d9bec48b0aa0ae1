"""Which files a name stands for: one file, a folder, or a pattern with `####`, `%04d` and perhaps a range `1-48x2`."""

import re
from collections.abc import Iterable
from dataclasses import dataclass
from functools import lru_cache
from pathlib import Path, PurePath

from swimlab.footage.numbering import NUMBER, common_width, is_written, sign_counts
from swimlab.runs.frames import FrameError

VIDEOS = frozenset(
    {".mp4", ".mov", ".mkv", ".avi", ".webm", ".m4v", ".nut", ".y4m", ".mpg", ".mpeg", ".mts", ".m2ts", ".mxf", ".gif"}
)
_NO_IMAGES = frozenset({".null", ".nul", ".term", ".gif"})
"""What OpenImageIO opens that is no picture, or a video."""

_FRAMES = r"-?\d+(?:--?\d+(?:[x:y]-?\d+)?)?"
_TOKEN = re.compile(
    rf"(?:(?<![^._])(?P<range>(?={_FRAMES}[,]|-?\d+-){_FRAMES}(?:,{_FRAMES})*))?(?P<padding>#+|%0?\d*d)"
)
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


def without_range(name: str) -> str:
    """The name of a pattern without the frame numbers that it names itself: f.1-48x2####.exr as f.####.exr."""
    pattern = None if Path(name).is_file() else parse_pattern(Path(name))
    if pattern is None or pattern.range is None:
        return name
    return str(Path(pattern.folder) / f"{pattern.before}%0{pattern.width}d{pattern.after}")


def holds_frames(name: str) -> bool:
    """Whether a name is that of frames: a pattern, an image or video file, or a folder of them that is no run."""
    path = Path(name)
    if path.is_dir():
        return not (path / "run.json").exists() and bool(patterns(path))
    return parse_pattern(path) is not None or _is_frames(path)


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
    found = _numbers(path.parent, pattern)
    frames = pattern.range or frames
    if frames is None:
        _refuse_part(name, path.parent, pattern, found)
    if frames is not None:
        numbers = parse_range(frames, name)
    elif found:
        numbers = tuple(range(min(found), max(found) + 1))
    else:
        raise FrameError(f"{name}: no file matches{_others(path.parent)}")
    paths = tuple(path.parent / found.get(number, pattern.file_name(number)) for number in numbers)
    missing = tuple(number for number in numbers if number not in found)
    if len(missing) == len(numbers):
        raise FrameError(f"{name}: none of the frames {frame_range(numbers)} is there{_others(path.parent)}")
    return Files(name, numbers, paths, missing)


def parse_range(text: str, name: str) -> tuple[int, ...]:
    """Frame numbers in order from 1-48, 1-48x2 or 3,5. Raises FrameError naming what it was given for."""
    from fileseq.frameset import FrameSet  # heavy

    for first, last in re.findall(r"(?<![\dx:y-])(-?\d+)-(-?\d+)", text):
        if int(last) < int(first):
            raise FrameError(f"{name}: {text} runs backwards; write {last}-{first}")
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


def _texts(folder: Path, pattern: Pattern) -> dict[str, str]:
    """Name -> number as it is written, of the files that the pattern fits but for the number of digits."""
    shape = re.compile(re.escape(pattern.before) + f"({NUMBER})" + re.escape(pattern.after))
    names = (entry.name for entry in folder.iterdir()) if folder.is_dir() else ()
    return {match[0]: match[1] for match in map(shape.fullmatch, names) if match}


def _numbers(folder: Path, pattern: Pattern) -> dict[int, str]:
    """Number -> name of the files that are there. Raises FrameError where two are of one number."""
    found: dict[int, str] = {}
    for name, text in sorted(_texts(folder, pattern).items()):
        if is_written(text, pattern.width, before=pattern.before):
            if int(text) in found:
                raise FrameError(f"{folder}: {found[int(text)]} and {name} are both frame {int(text)}; remove one")
            found[int(text)] = name
    return found


def _refuse_part(name: str, folder: Path, pattern: Pattern, found: dict[int, str]) -> None:
    """Raise FrameError where a pattern takes a part of a sequence, whose other numbers have other digits."""
    texts = _texts(folder, pattern)
    left = sorted(each for each, text in texts.items() if int(text) not in found)
    width = common_width(texts.values(), before=pattern.before) if found and left else None
    if width is not None:
        whole = f"{pattern.before}%0{width}d{pattern.after}"
        raise FrameError(
            f"{name}: leaves out {len(left)} of {len(texts)} files of one sequence, as {left[0]}, whose numbers have "
            f"other digits; write {whole}, or say which with --frames"
        )


def _only_sequence(folder: Path) -> str:
    """The pattern of the one sequence, or the name of the one file, that a folder holds. Raises FrameError."""
    found = patterns(folder)
    if len(found) != 1:
        several = f"several sequences ({', '.join(found[:_LISTED])}); name one" if found else "no image files"
        raise FrameError(f"{folder}: holds {several}")
    return str(folder / found[0])


def patterns(folder: Path) -> list[str]:
    """File names in a folder with the last number of each as #: what sequences there are."""
    groups: dict[tuple[str, str], list[str]] = {}
    single: dict[str, None] = {}
    for path in sorted(folder.iterdir()) if folder.is_dir() else ():
        if path.name.startswith(".") or not _is_frames(path):
            continue
        match = None if is_video(path.name) else re.search(r"-?\d+(?=\D*$)", path.stem)
        if match is None:
            single[path.name] = None
            continue
        start = match.start() + (match[0].startswith("-") and not sign_counts(path.name[: match.start()]))
        groups.setdefault((path.name[:start], path.name[match.end() :]), []).append(path.name[start : match.end()])
    found = []
    for (before, after), texts in groups.items():
        width = common_width(texts, before=before)
        widths = sorted({len(text.removeprefix("-")) for text in texts}) if width is None else [width]
        found += [f"{before}{'%01d' if each == 1 else '#' * each}{after}" for each in widths]
    return sorted([*found, *single])


def _is_frames(path: Path) -> bool:
    """Whether a path is that of an image or video file, by its ending."""
    suffix = path.suffix.lower()
    return suffix in VIDEOS or (suffix != "" and suffix in _images())


@lru_cache
def _images() -> frozenset[str]:
    """Endings of the image files that OpenImageIO knows."""
    import OpenImageIO as oiio  # noqa: N813, heavy

    formats = oiio.get_string_attribute("extension_list").split(";")
    return frozenset(f".{each}" for one in formats for each in one.partition(":")[2].split(",")) - _NO_IMAGES


def _others(folder: Path) -> str:
    """What else a folder holds, for an error message."""
    if not folder.is_dir():
        return f"; there is no folder {folder}"
    found = patterns(folder)
    return f"; {folder} holds {', '.join(found[:_LISTED])}" if found else f"; {folder} holds no image files"
