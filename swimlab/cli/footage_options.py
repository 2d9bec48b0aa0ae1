"""Options of the commands that read anyone's frames."""

from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import partial
from math import isfinite
from typing import Annotated, Literal

from cyclopts import Parameter

from metrics import Display
from sequences.names import check_name
from swimlab.footage.convention import PRESETS, Convention, Preset
from swimlab.footage.jitter import Side
from swimlab.footage.request import Request
from swimlab.footage.shot import check_build
from swimlab.footage.source import AlphaUse, Box, Look
from swimlab.runs.frames import FrameError

Hyphens = Parameter(allow_leading_hyphen=True)
Flag = Parameter(negative="")

VIEWING = ("pixels_per_degree", "luminance")
"""Options that run folders have too, there instead of the sequence's [viewing]."""


@Parameter(name="*")
@dataclass(frozen=True, kw_only=True)
class Footage:
    """Frames of your own.

    Parameters
    ----------
    test:
        Frames to measure: a pattern with ####, %04d or 1-48x2####, a folder, or a video.
    name:
        What to call the build that is measured.
    build:
        NAME=PATTERN, several times: builds to compare, in place of --test and --name.
    sequence:
        What to call the sequence (default: as the files are called).
    reference:
        What they should look like, frame by frame.
    motion:
        How far the picture moves: dx,dy in px a frame (right and down), files of motion vectors, or estimate.
    fps:
        Frames a second (default: the file's own, else 60).
    range_of_frames:
        Frames to measure, as 1-48, 1-48x2 or 3,5.
    channels:
        Three channels with commas, one channel, or a layer's name (default: R,G,B).
    colorspace:
        Colour space of the files: linear, srgb, or a name of OpenColorIO's configuration (swimlab list colorspaces);
        auto: as their metadata says; without a word floats are linear, 8 bit sRGB, 16 bit linear.
    alpha:
        Ignore alpha (default), measure only pixels of alpha 1, or divide premultiplied colours by it.
    part:
        Part of the files to look into, by name, view (left) or index.
    reference_channels:
        As --channels, of the reference; without these four, what its own files say counts, then the test's options.
    reference_colorspace:
        As --colorspace, of the reference.
    reference_alpha:
        As --alpha, of the reference.
    reference_part:
        As --part, of the reference.
    mask:
        Picture, or one a frame: measured where its first channel is above 0.5.
    mask_channels:
        Channel of the mask, in place of its first.
    mask_part:
        As --part, of the mask.
    depth:
        Files of depth along the camera's axis, m, by which scores are split into bands.
    depth_channels:
        Their channel (default: the only one, or as named Z).
    depth_part:
        As --part, of the files of depth.
    crop:
        Part of the picture to measure, x,y,width,height in px.
    motion_convention:
        What motion vectors mean (swimlab list conventions); the options below change single points of it.
    motion_channels:
        Their two channels, x,y.
    motion_part:
        As --part, of the files of motion vectors.
    motion_unit:
        Pixels, a picture 2 wide and high (ndc), or 1 wide and high (uv).
    motion_direction:
        Movement since the previous frame (backward), or until the next (forward).
    motion_y:
        Which way y is positive.
    motion_scale:
        A factor, or two as x,y; negative where vectors point to where the surface was.
    motion_offset:
        The stored value that means no motion, or two as x,y, as 0.5; subtracted before all else.
    motion_mask:
        Picture, or one a frame, of the vectors' size: they are valid where its first channel is above 0.5.
    motion_mask_channels:
        Channel of that mask, in place of its first.
    motion_mask_part:
        As --part, of that mask.
    motion_jitter:
        Text file of the frames' sub-pixel jitter, frame,x,y or x,y a line, px right and down (of the vectors' size), or
        estimate.
    motion_jitter_in:
        Who has that jitter alone: the vectors, so that it is taken out of them, or the frames, so that it is put in.
    motion_unverified:
        Measure even if the motion does not fit the frames.
    skip_bad_frames:
        Leave out frames that are missing, damaged, of another size, or hold NaN; recorded in the scores.
    pixels_per_degree:
        Pixels to a degree of visual angle, for visibility (also of a run folder, instead of its sequence's).
    luminance:
        What radiance 1 is shown with, cd/m^2, for visibility (also of a run folder, instead of its sequence's).
    exposure:
        Stops by which frames are brightened for the display domain (default: 0).
    tone_map:
        How bright light is brought under 1 for the display domain (default: none, it is clamped).
    display:
        DISPLAY/VIEW of OpenColorIO's configuration that the display domain sees, instead of --tone-map (swimlab list
        views).
    """

    test: str | None = None
    name: str = "test"
    build: Annotated[tuple[str, ...], Parameter(negative="")] = ()
    sequence: str | None = None
    reference: str | None = None
    motion: Annotated[str | None, Hyphens] = None
    fps: float | None = None
    range_of_frames: Annotated[str | None, Parameter(name="--frames")] = None
    channels: str | None = None
    colorspace: str | None = None
    alpha: AlphaUse | None = None
    part: str | None = None
    reference_channels: str | None = None
    reference_colorspace: str | None = None
    reference_alpha: AlphaUse | None = None
    reference_part: str | None = None
    mask: str | None = None
    mask_channels: str | None = None
    mask_part: str | None = None
    depth: str | None = None
    depth_channels: str | None = None
    depth_part: str | None = None
    crop: Annotated[str | None, Hyphens] = None
    motion_convention: Preset = "own"
    motion_channels: str | None = None
    motion_part: str | None = None
    motion_unit: Literal["px", "ndc", "uv"] | None = None
    motion_direction: Literal["backward", "forward"] | None = None
    motion_y: Literal["down", "up"] | None = None
    motion_scale: Annotated[str | None, Hyphens] = None
    motion_offset: Annotated[str | None, Hyphens] = None
    motion_mask: str | None = None
    motion_mask_channels: str | None = None
    motion_mask_part: str | None = None
    motion_jitter: str | None = None
    motion_jitter_in: Side = "vectors"
    motion_unverified: Annotated[bool, Flag] = False
    skip_bad_frames: Annotated[bool, Flag] = False
    pixels_per_degree: float | None = None
    luminance: float | None = None
    exposure: Annotated[float | None, Hyphens] = None
    tone_map: Literal["none", "reinhard", "aces"] | None = None
    display: str | None = None

    def requests(self, domain: Literal["linear", "display"]) -> dict[str, Request]:
        """What to measure of each build. Raises FrameError for an option that cannot be read."""
        if self.sequence is not None:
            _checked("--sequence", partial(check_name, of="a sequence"), self.sequence)
        if not self.build:
            return {_checked("--name", check_build, self.name): self._request(self.test, domain)}
        if self.test is not None or self.name != "test":
            raise FrameError("--build: names all builds; give --build NAME=PATTERN in place of --test and --name")
        found: dict[str, Request] = {}
        for text in self.build:
            name, _, pattern = text.partition("=")
            if not pattern:
                raise FrameError(f"--build {text}: give NAME=PATTERN, as main=main/f.####.exr")
            if name in found:
                raise FrameError(f"--build {text}: there is a build {name} already; name each build once")
            found[_checked("--build", check_build, name)] = self._request(pattern, domain)
        return found

    def _request(self, test: str | None, domain: Literal["linear", "display"]) -> Request:
        viewing = self.viewing()
        _check_positive("--fps", self.fps)
        for of in ("mask", "motion_mask", "depth"):
            given = [name for name in (f"{of}_channels", f"{of}_part") if getattr(self, name) is not None]
            if given and getattr(self, of) is None:
                option, needed = (name.replace("_", "-") for name in (given[0], of))
                raise FrameError(f"--{option}: is for an input that is not given; give --{needed}, or leave it out")
        if test is None:
            raise FrameError("--test: is missing; name the frames to measure, or a run folder")
        return Request(
            test=test,
            reference=self.reference,
            motion=self.motion,
            mask=self.mask,
            mask_channels=self.mask_channels,
            mask_part=self.mask_part,
            depth=self.depth,
            depth_channels=self.depth_channels,
            depth_part=self.depth_part,
            fps=self.fps,
            frames=self.range_of_frames,
            look=Look(self.channels, self.colorspace, self.alpha, self.part, _crop(self.crop)),
            reference_look=self._reference_look(),
            motion_part=self.motion_part,
            convention=self._convention(),
            motion_mask=self.motion_mask,
            motion_mask_channels=self.motion_mask_channels,
            motion_mask_part=self.motion_mask_part,
            motion_jitter=self.motion_jitter,
            motion_jitter_in=self.motion_jitter_in,
            domain=domain,
            display=self._display(domain),
            skip_bad_frames=self.skip_bad_frames,
            unverified=self.motion_unverified,
            pixels_per_degree=viewing.get("pixels_per_degree"),
            luminance=viewing.get("luminance"),
        )

    def _reference_look(self) -> Look:
        options = {name: getattr(self, f"reference_{name}") for name in ("channels", "colorspace", "alpha", "part")}
        given = [f"--reference-{name} {value}" for name, value in options.items() if value is not None]
        if self.reference is None and given:
            raise FrameError(f"{given[0]}: is for a reference; give --reference, or leave it out")
        return Look(*options.values())

    def viewing(self) -> dict[str, float]:
        """What is given of pixels_per_degree and luminance. Raises FrameError where one is not above 0."""
        given = {name: getattr(self, name) for name in VIEWING}
        for name, value in given.items():
            _check_positive(f"--{name.replace('_', '-')}", value)
        return {name: value for name, value in given.items() if value is not None}

    def _display(self, domain: Literal["linear", "display"]) -> Display:
        options = (("--exposure", self.exposure), ("--tone-map", self.tone_map), ("--display", self.display))
        for option, value in options:
            if value is not None and domain != "display":
                raise FrameError(f"{option} {value}: is for --domain display")
        try:
            return Display(exposure=self.exposure or 0.0, tone_map=self.tone_map or "none", view=self.display)
        except ValueError as error:
            raise FrameError(f"{'--exposure' if self.display is None else '--display'}: {error}") from error

    def _convention(self) -> Convention:
        preset = PRESETS[self.motion_convention]
        pairs = preset.channels
        if self.motion_channels is not None:
            names = tuple(name.strip() for name in self.motion_channels.split(","))
            if len(names) != 2 or not all(names):
                raise FrameError(f"--motion-channels {self.motion_channels}: give two, x,y")
            pairs = ((names[0], names[1]),)
        return replace(
            preset,
            channels=pairs,
            unit=self.motion_unit or preset.unit,
            direction=self.motion_direction or preset.direction,
            y=self.motion_y or preset.y,
            scale=preset.scale if self.motion_scale is None else _scale(self.motion_scale),
            offset=preset.offset if self.motion_offset is None else _pair("--motion-offset", self.motion_offset),
        )


def _checked(option: str, check: Callable[[str], str], name: str) -> str:
    try:
        return check(name)
    except ValueError as error:
        raise FrameError(f"{option}: {error}") from error


def _check_positive(option: str, value: float | None) -> None:
    if value is not None and not 0 < value < float("inf"):
        raise FrameError(f"{option} {value:g}: must be above 0")


def _crop(text: str | None) -> "Box | None":
    if text is None:
        return None
    try:
        x, y, width, height = (int(side) for side in text.split(","))
    except ValueError as error:
        raise FrameError(f"--crop {text}: give x,y,width,height in px, as 0,0,640,360") from error
    return Box(x, y, width, height)


def _scale(text: str) -> tuple[float, float]:
    factors = _pair("--motion-scale", text)
    if 0 in factors:
        raise FrameError(f"--motion-scale {text}: give a factor other than 0, or two as x,y")
    return factors


def _pair(option: str, text: str) -> tuple[float, float]:
    """A number for x and y, or two with a comma."""
    try:
        numbers = [float(number) for number in text.split(",")]
    except ValueError:
        numbers = []
    if len(numbers) not in (1, 2) or not all(map(isfinite, numbers)):
        raise FrameError(f"{option} {text}: give a number, or two as x,y")
    return numbers[0], numbers[-1]
