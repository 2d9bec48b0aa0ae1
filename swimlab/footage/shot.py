"""Shot files: anyone's frames under several builds, with one reference and one motion, as plain data."""

from collections.abc import Collection, Mapping
from dataclasses import replace
from difflib import get_close_matches
from pathlib import Path
from typing import Annotated, Any, Literal, Self

from pydantic import AfterValidator, Field, ValidationError, field_validator, model_validator

from metrics.display import Domain
from sequences import Sequence
from sequences.display import Display
from sequences.names import LONGEST, NAME, check_name
from sequences.problems import SequenceError, describe
from sequences.table import Real, Table, Whole
from sequences.toml_file import TomlError, change, read_toml
from sequences.viewing import Viewing
from swimlab.footage.convention import PRESETS, Convention, Direction, Preset, Unit, Vertical
from swimlab.footage.jitter import Side
from swimlab.footage.pattern import parse_range
from swimlab.footage.request import ESTIMATE, Request
from swimlab.footage.source import AlphaUse, Box, Look
from swimlab.runs.clips import shown_by
from swimlab.runs.record import RESERVED, RunError

Pair = tuple[Real, Real]
Frames = Annotated[
    str, Field(min_length=1, description="pattern (f.####.exr), folder, file or video, relative to this file")
]


def check_build(name: str) -> str:
    """The name, which a build may have. Raises ValueError."""
    check_name(name, "a build")
    if name in RESERVED:
        raise ValueError(f"{name!r} is what a run calls a part of its own: name the build otherwise")
    return name


BuildName = Annotated[str, AfterValidator(check_build)]


class Pictures(Table):
    """Frames of colour, and how they are read."""

    frames: Frames
    channels: str | None = Field(None, description="three channels with commas, one channel, or a layer's name")
    colorspace: str | None = Field(
        None,
        description="linear, srgb, auto or a name of OpenColorIO's configuration; without it: what the files say, and "
        "where a reference's do not, what the builds say",
    )
    alpha: AlphaUse | None = Field(
        None, description="ignore alpha, measure where it is 1 (mask), or divide colours by it (unpremultiply)"
    )
    part: str | None = Field(None, description="part of the files, by name, view or index")


class Vectors(Table):
    """How the picture moves: by files of vectors, by one vector, or as estimated from the frames."""

    frames: Frames | None = None
    velocity: Pair | None = Field(None, description="[dx, dy] px a frame, right and down, of all of the picture")
    estimate: bool = Field(False, strict=True, description="find the motion from the frames, which hides flicker")
    convention: Preset = Field("own", description="what vectors mean (swimlab list conventions)")
    channels: tuple[str, str] | None = Field(None, description="the two channels of vectors, x and y")
    part: str | None = Field(None, description="part of the files of vectors, by name, view or index")
    unit: Unit | None = Field(None, description="px, ndc or uv, in place of the convention's")
    direction: Direction | None = Field(None, description="backward or forward, in place of the convention's")
    y: Vertical | None = Field(None, description="which way y is positive: down or up")
    scale: Pair | None = Field(None, description="factors of x and y")
    offset: Pair | None = Field(None, description="the stored values that mean no motion")
    mask: str | None = Field(None, description="picture, or one a frame: vectors are valid where it is above 0.5")
    mask_channels: str | None = Field(None, description="the channel of the mask; without it: the first")
    mask_part: str | None = Field(None, description="part of the mask's files, by name, view or index")
    jitter: str | None = Field(None, description="text file of the frames' jitter, px right and down, or estimate")
    jitter_in: Side = Field("vectors", description="what has the jitter alone: vectors or frames")
    unverified: bool = Field(False, strict=True, description="measure though the motion does not fit the frames")

    @field_validator("scale")
    @classmethod
    def _not_zero(cls, value: Pair | None) -> Pair | None:
        if value is not None and 0 in value:
            raise ValueError("a factor of 0 leaves no motion: give factors other than 0")
        return value

    @model_validator(mode="after")
    def _one_source(self) -> Self:
        given = [name for name in ("frames", "velocity", "estimate") if getattr(self, name)]
        if len(given) != 1:
            raise ValueError(f"give one of frames, velocity and estimate = true, not {' and '.join(given) or 'none'}")
        of_files = ("convention", "channels", "part", "unit", "direction", "y", "scale", "offset", "mask")
        stray = [name for name in of_files if name in self.model_fields_set]
        if stray and self.frames is None:
            raise ValueError(f"{', '.join(stray)}: is for files of vectors; give frames, or remove it")
        stray = [name for name in ("mask_channels", "mask_part") if name in self.model_fields_set]
        if stray and self.mask is None:
            raise ValueError(f"{', '.join(stray)}: is for a mask of vectors; give mask too, or remove it")
        if self.jitter is None and "jitter_in" in self.model_fields_set:
            raise ValueError("jitter_in: says what has the jitter; give jitter too, or remove it")
        return self

    def meaning(self) -> Convention:
        """The convention with what is said otherwise."""
        said = {name: getattr(self, name) for name in ("unit", "direction", "y", "scale", "offset")}
        changes: dict[str, Any] = {name: value for name, value in said.items() if value is not None}
        if self.channels is not None:
            changes["channels"] = (self.channels,)
        return replace(PRESETS[self.convention], **changes)


class Depth(Table):
    """Depth along the camera's axis, m, by which scores are split into bands."""

    frames: Frames
    channels: str | None = Field(None, description="the channel of depth; without it: the only one, or as named Z")
    part: str | None = Field(None, description="part of the files, by name, view or index")


class Mask(Table):
    """Where to measure: one picture, or one a frame."""

    frames: Frames
    channels: str | None = Field(None, description="the channel of the mask; without it: the first")
    part: str | None = Field(None, description="part of the files, by name, view or index")


class Shot(Table):
    """A shot file, version 1: anyone's frames under several builds."""

    version: Literal[1] = Field(description="version of the file format: 1")
    name: str = Field(
        pattern=NAME,
        max_length=LONGEST,
        description="name of the shot: letters, digits, dot, dash, underscore; the sequence's name in scores",
    )
    fps: Real | None = Field(None, gt=0, le=1e5, description="frames a second; without it: the files' own, else 60")
    frames: str | None = Field(None, description="frames to measure, as 1-48, 1-48x2 or 3,5; without it: all")
    crop: tuple[Whole, Whole, Whole, Whole] | None = Field(None, description="x, y, width and height to measure, px")
    skip_bad_frames: bool = Field(False, strict=True, description="leave out frames that cannot be measured")
    reference: Pictures | None = Field(None, description="what the builds should look like, frame by frame")
    motion: Vectors | None = Field(None, description="how the picture moves; without it: nothing moves")
    depth: Depth | None = Field(None, description="depth of each pixel, m")
    mask: Mask | None = Field(None, description="where to measure")
    viewing: Viewing | None = Field(None, description="how the frames are looked at, for visible.flicker")
    display: Display = Field(default=Display(), description="how radiance is shown, for the display domain")
    builds: dict[BuildName, Pictures] = Field(min_length=1, description="the builds to compare, each [builds.NAME]")

    @field_validator("frames")
    @classmethod
    def _is_range(cls, value: str | None) -> str | None:
        if value is not None:
            parse_range(value, "frames")
        return value

    def requests(self, folder: Path, domain: Domain, *, builds: Collection[str] | None = None) -> dict[str, Request]:
        """What to measure of each build, in the file's order; names are relative to the folder, that of the file.

        builds: the names of some; None: all. Raises RunError for one that is not there, and where none is named.
        """
        wanted = self.builds if builds is None else builds
        unknown = [name for name in wanted if name not in self.builds]
        if unknown or not wanted:
            raise RunError(f"build {next(iter(unknown), '')!r}: {self.name} has {', '.join(self.builds)}")

        def place(name: str | None) -> str | None:
            return None if name is None else str(folder / name)

        crop = None if self.crop is None else Box(*self.crop)
        reference, motion, depth = self.reference, self.motion, self.depth
        moving: dict[str, Any] = {}
        if motion is not None:
            jitter = motion.jitter if motion.jitter in (None, ESTIMATE) else place(motion.jitter)
            moving = {
                "motion": _motion(motion, place(motion.frames)),
                "convention": motion.meaning(),
                "motion_part": motion.part,
                "motion_mask": place(motion.mask),
                "motion_mask_channels": motion.mask_channels,
                "motion_mask_part": motion.mask_part,
                "motion_jitter": jitter,
                "motion_jitter_in": motion.jitter_in,
                "unverified": motion.unverified,
            }
        return {
            name: Request(
                test=str(folder / build.frames),
                reference=None if reference is None else place(reference.frames),
                mask=None if self.mask is None else place(self.mask.frames),
                mask_channels=None if self.mask is None else self.mask.channels,
                mask_part=None if self.mask is None else self.mask.part,
                fps=self.fps,
                frames=self.frames,
                look=_look(build, crop),
                reference_look=Look() if reference is None else _look(reference, None),
                depth=None if depth is None else place(depth.frames),
                depth_channels=None if depth is None else depth.channels,
                depth_part=None if depth is None else depth.part,
                domain=domain,
                display=shown_by(self.name, self.display.model_dump(), 0),
                skip_bad_frames=self.skip_bad_frames,
                pixels_per_degree=None if self.viewing is None else self.viewing.pixels_per_degree,
                luminance=None if self.viewing is None else self.viewing.luminance,
                **moving,
            )
            for name, build in self.builds.items()
            if name in wanted
        }


_TELLING = {"builds", "reference"}
"""Keys that only a shot file has."""


def is_shot(name: str | Path) -> bool:
    """Whether a name is that of a shot file: a .toml file with builds or a reference, which no sequence file has.

    A slip of the pen, as [build.a], makes it no sequence, unless there is a key that only those have.
    """
    path = Path(name)
    if path.suffix != ".toml" or not path.is_file():
        return False
    try:
        keys = set(read_toml(path, syntax="", unreadable=""))
    except TomlError:
        return False
    if keys & _TELLING:
        return True
    of_sequences = set(Sequence.model_fields)
    unknown = [key for key in keys - of_sequences if get_close_matches(key, _TELLING, n=1, cutoff=0.8)]
    return bool(unknown) and not keys & (of_sequences - set(Shot.model_fields))


def load_shot(path: Path, *, changes: Mapping[str, Any] | None = None) -> Shot:
    """The shot of a file; frames are not looked for. Raises SequenceError with every problem at once.

    changes: values that take the place of the file's, by dotted key, as {"builds.main.colorspace": "srgb"}.
    """
    try:
        data = read_toml(path, syntax="text needs quotes, a table is a [name] line", unreadable="")
        change(data, changes or {}, path)
    except TomlError as error:
        raise SequenceError([str(error)]) from None
    try:
        return Shot.model_validate(data)
    except ValidationError as error:
        raise SequenceError(f"{path}: {problem}" for problem in describe(error, Shot)) from None


def shot_schema() -> Mapping[str, Any]:
    """JSON schema (2020-12) of a shot file."""
    return {"$schema": "https://json-schema.org/draft/2020-12/schema", **Shot.model_json_schema()}


def _look(pictures: Pictures, crop: Box | None) -> Look:
    return Look(pictures.channels, pictures.colorspace, pictures.alpha, pictures.part, crop)


def _motion(motion: Vectors, frames: str | None) -> str | None:
    if motion.velocity is not None:
        dx, dy = motion.velocity
        return f"{dx!r},{dy!r}"
    return ESTIMATE if motion.estimate else frames
