"""A shot file drafted from the frames that a folder holds: what they are is told by their names and channels."""

import json
import re
from collections import defaultdict
from collections.abc import Mapping
from pathlib import Path

from swimlab.footage.convention import guess
from swimlab.footage.header import Header
from swimlab.footage.pattern import frame_range, parse_pattern, patterns
from swimlab.footage.reader import Reader, open_frames
from swimlab.runs.counting import counted
from swimlab.runs.frames import FrameError
from swimlab.runs.record import ERROR, RESERVED

ROLES = {
    "reference": ("ref", "reference", "truth", "gt", "groundtruth", "offline"),
    "motion": ("mv", "motion", "velocity", "vector", "vectors", "flow", "motionvectors"),
    "depth": ("depth", "z"),
    "mask": ("mask", "matte"),
}
"""Table of a shot file -> words by which its frames are told; all others are builds."""


_COLOUR = ({"r", "g", "b"}, {"red", "green", "blue"})
_ALPHA = {"a", "alpha"}


def draft_shot(folder: Path) -> str:
    """The text of a shot file, to be saved in the folder.

    Frames are looked for in the folder and in the folders in it. Raises FrameError where there are none to compare.
    """
    found = [each for place in (folder, *_folders(folder)) for each in _frames(folder, place)]
    opened = {frames: open_frames(str(folder / frames)) for frames in found}
    rendered = (folder / "run.json").exists()
    roles: dict[str, str] = {}
    others: dict[str, list[str]] = {}
    builds: dict[str, str] = {}
    left: dict[str, str] = {}
    for frames in found:
        header = opened[frames].header
        role = _role(frames, header)
        if role is not None:
            if roles.setdefault(role, frames) != frames:
                others.setdefault(role, []).append(frames)
        elif rendered and Path(frames).parts[0] == ERROR:
            left[frames] = "the standard error of the run's reference"
        elif not _has_colour(header):
            left[frames] = "they have no channels of colour"
        else:
            builds[_build(frames, builds)] = frames
    if not builds:
        raise FrameError(f"{folder}: holds no frames of a build; name the folder that holds the builds' frames")
    name = re.sub(r"[^A-Za-z0-9._-]+", "-", folder.absolute().name).strip("-._") or "shot"
    lines = [*_head(name, opened[next(iter(builds.values()))]), *_tables(roles, others, builds, opened)]
    return "\n".join([*lines, *(f"# {_said(frames, opened)}; no build: {why}" for frames, why in left.items()), ""])


def _head(name: str, first: Reader) -> list[str]:
    fps = first.header.fps
    return [
        "version = 1",
        f"name = {_quoted(name)}  # the sequence's name in scores, reports and gates",
        f"fps = {fps:g}  # the files' own" if fps else "fps = 60  # the files do not say: set it",
        f"# frames = {_quoted(frame_range(first.numbers))}  # without this line: all that are there",
    ]


def _tables(
    roles: Mapping[str, str],
    others: Mapping[str, list[str]],
    builds: Mapping[str, str],
    opened: Mapping[str, Reader],
) -> list[str]:
    said = {
        "reference": "what the builds should look like, frame by frame; without it there is no error, only change",
        "depth": "m along the camera's axis: splits scores into bands of distance",
        "mask": "measured where it is above 0.5",
    }
    size = _size(roles, builds, opened)
    lines: list[str] = []
    for role in ROLES:
        if role == "motion":
            lines += _motion(roles, builds, opened)
        elif role in roles:
            table = [f"[{role}]  # {said[role]}", _said(roles[role], opened)]
            hint = _alpha(opened[roles[role]].header) if role == "reference" else []
            lines += ["", *_fitting([*table, *hint], opened[roles[role]], size)]
        elif role == "reference":
            lines += ["", f"# [reference]  # {said[role]}", '# frames = "reference/f.####.exr"']
        lines += [f"# {_said(frames, opened)}; as likely, choose one" for frames in others.get(role, [])]
    lines += ["", "# [viewing]  # for visible.flicker", "# pixels_per_degree = 40.0"]
    for name, frames in builds.items():
        table = [f"[builds.{_quoted(name) if '.' in name else name}]", _said(frames, opened)]
        lines += ["", *_fitting([*table, *_alpha(opened[frames].header)], opened[frames], size)]
    return [*lines, "# every input may have its own channels, colorspace, alpha and part"]


def _size(roles: Mapping[str, str], builds: Mapping[str, str], opened: Mapping[str, Reader]) -> tuple[int, int]:
    """Width and height of the shot: the reference's if a build has it, else the first build's."""
    sizes = [opened[frames].header.size for frames in builds.values()]
    wanted = opened[roles["reference"]].header.size if "reference" in roles else sizes[0]
    return wanted if wanted in sizes else sizes[0]


def _fitting(table: list[str], reader: Reader, size: tuple[int, int]) -> list[str]:
    """A table's lines, commented out with the reason where its frames are of another size than the shot's."""
    if reader.header.size == size:
        return table
    sizes = "{}x{} px, the shot is of {}x{}".format(*reader.header.size, *size)
    return [f"# left out: its frames are of {sizes}", *(f"# {line.removeprefix('# ')}" for line in table)]


def _alpha(header: Header) -> list[str]:
    """A hint where frames have alpha."""
    has = any(names & _ALPHA for names in _layers(header).values())
    return ['# alpha = "mask"  # measures only where alpha is 1'] if has else []


def _motion(roles: Mapping[str, str], builds: Mapping[str, str], opened: Mapping[str, Reader]) -> list[str]:
    """The motion's table: files of vectors, those of a build or reference, or none."""
    likely = [roles[role] for role in ("motion", "reference") if role in roles] + list(builds.values())
    for frames in likely:
        presets = [guess(part.channels) for part in opened[frames].header.parts]
        preset = next(filter(None, presets), None)
        if preset is not None:
            return ["", "[motion]  # verified against the frames when they are measured", *_vectors(frames, preset)]
    if "motion" in roles:
        return ["", "[motion]  # verified against the frames when they are measured", *_vectors(roles["motion"], None)]
    return [
        "",
        "# [motion]  # without it nothing is taken to move",
        "# velocity = [1.0, 0.0]  # px a frame, right and down; or estimate = true; or",
        '# frames = "motion/f.####.exr"',
    ]


def _vectors(frames: str, preset: str | None) -> list[str]:
    known = "by the names of their channels" if preset else "not told by the files: swimlab list conventions"
    preset = (preset or "own").removesuffix("-forward")
    return [f"frames = {_quoted(frames)}", f"convention = {_quoted(preset)}  # {known}"]


def _said(frames: str, opened: Mapping[str, Reader]) -> str:
    reader = opened[frames]
    size = "{}x{}".format(*reader.header.size)
    return f"frames = {_quoted(frames)}  # {counted(len(reader.numbers), 'frame')}, {size}"


def _quoted(text: str) -> str:
    """A string of TOML, in which JSON's pairs of surrogates are no characters."""
    return json.dumps(text, ensure_ascii=False)


def _folders(folder: Path) -> list[Path]:
    return [path for path in sorted(folder.iterdir()) if path.is_dir() and not (path / "run.json").exists()]


def _frames(folder: Path, place: Path) -> list[str]:
    """The sequences of several frames in a place, relative to the folder."""
    return [
        (place / each).relative_to(folder).as_posix()
        for each in patterns(place)
        if parse_pattern(Path(each)) is not None or place != folder
    ]


def _words(frames: str) -> list[str]:
    """The words of a name, small: of its folder, then of its file."""
    path = Path(frames)
    pattern = parse_pattern(path)
    return [word for text in (*path.parts[:-1], pattern.before if pattern else path.stem) for word in _split(text)]


def _split(text: str) -> list[str]:
    return [word.lower() for word in re.split(r"[^A-Za-z0-9]+", text) if word]


def _role(frames: str, header: Header) -> str | None:
    """What frames are by their name, or motion, where their channels are vectors and no colour; None: a build."""
    words = _words(frames)
    named = next((role for role, known in ROLES.items() if any(word in known for word in words)), None)
    if named is None and not _has_colour(header) and any(guess(part.channels) for part in header.parts):
        return "motion"
    return named


def _layers(header: Header) -> dict[tuple[int, str], set[str]]:
    """The channels' own names, small, by part and layer, but for layers of vectors."""
    layers: dict[tuple[int, str], list[str]] = defaultdict(list)
    for index, part in enumerate(header.parts):
        for channel in () if part.deep else part.channels:
            layers[index, channel.rpartition(".")[0]].append(channel)
    return {
        place: {channel.rpartition(".")[2].lower() for channel in channels}
        for place, channels in layers.items()
        if guess(tuple(channels)) is None
    }


def _has_colour(header: Header) -> bool:
    """Whether frames have red, green and blue, or one channel alone, which is grey."""
    layers = list(_layers(header).values())
    return any(colour <= names for names in layers for colour in _COLOUR) or sum(len(n - _ALPHA) for n in layers) == 1


def _build(frames: str, taken: Mapping[str, str]) -> str:
    """A name for a build that none has: its folder's, else its file's."""
    path = Path(frames)
    pattern = parse_pattern(path)
    file = pattern.before if pattern else path.stem
    folder = "-".join(path.parts[:-1])
    for name in (folder, file, f"{folder}-{file}", f"build-{len(taken) + 1}"):
        name = re.sub(r"[^A-Za-z0-9._-]+", "-", name).strip("-._")
        if name and name not in {*taken, *RESERVED}:
            return name
    return f"build-{len(taken) + 1}"
