"""A shot file drafted from the frames that a folder holds: what they are is told by their names and channels."""

import json
import re
from collections.abc import Mapping
from pathlib import Path

from swimlab.footage.convention import guess
from swimlab.footage.pattern import frame_range, parse_pattern, patterns
from swimlab.footage.reader import Reader, open_frames
from swimlab.runs.frames import FrameError
from swimlab.runs.record import RESERVED

ROLES = {
    "reference": ("ref", "reference", "truth", "gt", "groundtruth", "offline"),
    "motion": ("mv", "motion", "velocity", "vector", "vectors", "flow", "motionvectors"),
    "depth": ("depth", "z"),
    "mask": ("mask", "matte"),
}
"""Table of a shot file -> words by which its frames are told; all others are builds."""


def draft_shot(folder: Path) -> str:
    """The text of a shot file, to be saved in the folder.

    Frames are looked for in the folder and in the folders in it. Raises FrameError where there are none to compare.
    """
    found = [each for place in (folder, *_folders(folder)) for each in _frames(folder, place)]
    roles: dict[str, str] = {}
    others: dict[str, list[str]] = {}
    builds: dict[str, str] = {}
    for frames in found:
        role = _role(frames)
        if role is None:
            builds[_build(frames, builds)] = frames
        elif roles.setdefault(role, frames) != frames:
            others.setdefault(role, []).append(frames)
    if not builds:
        raise FrameError(f"{folder}: holds no frames of a build; name the folder that holds the builds' frames")
    opened = {frames: open_frames(str(folder / frames)) for frames in found}
    name = re.sub(r"[^A-Za-z0-9._-]+", "-", folder.absolute().name).strip("-._") or "shot"
    return "\n".join([*_head(name, opened[next(iter(builds.values()))]), *_tables(roles, others, builds, opened), ""])


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
    lines: list[str] = []
    for role in ROLES:
        if role == "motion":
            lines += _motion(roles, builds, opened)
        elif role in roles:
            lines += ["", f"[{role}]  # {said[role]}", _said(roles[role], opened)]
        elif role == "reference":
            lines += ["", f"# [reference]  # {said[role]}", '# frames = "reference/f.####.exr"']
        lines += [f"# {_said(frames, opened)}; as likely, choose one" for frames in others.get(role, [])]
    lines += ["", "# [viewing]  # for visible.flicker", "# pixels_per_degree = 40.0"]
    for name, frames in builds.items():
        lines += ["", f"[builds.{_quoted(name) if '.' in name else name}]", _said(frames, opened)]
    return [*lines, "# every input may have its own channels, colorspace, alpha and part"]


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
    return f"frames = {_quoted(frames)}  # {len(reader.numbers)} frames, {size}"


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


def _role(frames: str) -> str | None:
    words = _words(frames)
    return next((role for role, known in ROLES.items() if any(word in known for word in words)), None)


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
