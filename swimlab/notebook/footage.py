"""Your own frames, measured from Python."""

from collections.abc import Mapping, Sequence
from html import escape
from os import PathLike, fspath
from typing import Any

from metrics.display import STANDARD, Display, Domain
from swimlab.footage.convention import PRESETS, Convention
from swimlab.footage.jitter import Side
from swimlab.footage.request import Request
from swimlab.footage.source import AlphaUse, Box, Look
from swimlab.footage.subject import Subject
from swimlab.notebook.scores import Scores
from swimlab.runs.frames import FrameError
from swimlab.scoring.footage import measure_builds

Name = str | PathLike[str]
"""A pattern with #### or %04d, a folder, a file or a video."""


class Measured:
    """What was measured of frames. content: as scores.json holds it."""

    def __init__(self, content: Mapping[str, Any]) -> None:
        self.content = content
        self._entry = content["sequences"][0]

    @property
    def scores(self) -> Scores:
        """The scores, of the one technique "test"."""
        return Scores(self.content["sequences"])

    @property
    def notes(self) -> list[str]:
        """What a reader should know beside the scores: how the motion was verified, what was left out."""
        return list(self._entry["notes"])

    @property
    def curves(self) -> dict[str, dict[str, list[Any]]]:
        """Name -> axis -> values."""
        return dict(self._entry["curves"])

    def __repr__(self) -> str:
        return "\n".join([repr(self.scores), *self.notes])

    def _repr_html_(self) -> str:
        notes = "".join(f"<li>{escape(note)}</li>" for note in self.notes)
        return f"{self.scores._repr_html_()}<ul>{notes}</ul>"


def measure_frames(
    test: Name,
    *,
    reference: Name | None = None,
    motion: Name | tuple[float, float] | None = None,
    convention: str | Convention = "own",
    motion_mask: Name | None = None,
    motion_mask_channels: str | None = None,
    motion_mask_part: str | None = None,
    motion_jitter: Name | None = None,
    motion_jitter_in: Side = "vectors",
    fps: float | None = None,
    frames: str | None = None,
    mask: Name | None = None,
    mask_channels: str | None = None,
    mask_part: str | None = None,
    depth: Name | None = None,
    depth_channels: str | None = None,
    depth_part: str | None = None,
    channels: str | None = None,
    colour_space: str | None = None,
    alpha: AlphaUse | None = None,
    part: str | None = None,
    reference_look: Look | None = None,
    motion_part: str | None = None,
    crop: tuple[int, int, int, int] | None = None,
    domain: Domain = "linear",
    display: Display = STANDARD,
    skip_bad_frames: bool = False,
    unverified: bool = False,
    pixels_per_degree: float | None = None,
    luminance: float | None = None,
    peers: Sequence[str] = (),
) -> Measured:
    """Measure anyone's frames; the options are the same as of `swimlab measure --test`.

    reference: what they should look like, frame by frame. motion: (dx, dy) px a frame right and down, files of motion
    vectors, "estimate", or None where nothing moves. convention: what the vectors mean: a name of
    `swimlab list conventions`, or a Convention. motion_mask: where vectors are valid, above 0.5. motion_jitter: text
    file of the frames' jitter, which the vectors alone or the frames alone have. fps: None: the file's own, else 60.
    frames: range as "1-48". channels, colour_space, alpha, part: how the test is read; reference_look: the same of the
    reference, where it differs. depth: files of depth, m, which split scores into bands. Masks and depth have their own
    channel and part. crop: x, y, width, height, px. unverified: measure though the motion does not fit the
    frames.
    The notes say where the motion cannot be verified. Raises FrameError naming the file, frame or setting that is
    wrong, and how to mend it.
    """
    request = Request(
        test=fspath(test),
        reference=None if reference is None else fspath(reference),
        motion=_motion(motion),
        mask=None if mask is None else fspath(mask),
        mask_channels=mask_channels,
        mask_part=mask_part,
        depth=None if depth is None else fspath(depth),
        depth_channels=depth_channels,
        depth_part=depth_part,
        fps=fps,
        frames=frames,
        look=Look(channels, colour_space, alpha, part, None if crop is None else Box(*crop)),
        reference_look=reference_look or Look(),
        motion_part=motion_part,
        convention=_convention(convention),
        motion_mask=None if motion_mask is None else fspath(motion_mask),
        motion_mask_channels=motion_mask_channels,
        motion_mask_part=motion_mask_part,
        motion_jitter=None if motion_jitter is None else fspath(motion_jitter),
        motion_jitter_in=motion_jitter_in,
        domain=domain,
        display=display,
        skip_bad_frames=skip_bad_frames,
        unverified=unverified,
        pixels_per_degree=pixels_per_degree,
        luminance=luminance,
    )
    subject = Subject(request, lambda _: None, lambda _: None)
    return Measured(measure_builds({"test": subject}, peers=peers, command="swimlab.measure_frames"))


def _motion(motion: Name | tuple[float, float] | None) -> str | None:
    if motion is None:
        return None
    if isinstance(motion, str | PathLike):
        return fspath(motion)
    if len(motion) != 2:
        raise FrameError(f"motion {motion}: give (dx, dy), px a frame right and down, or files of motion vectors")
    dx, dy = map(float, motion)
    return f"{dx!r},{dy!r}"


def _convention(convention: str | Convention) -> Convention:
    if isinstance(convention, Convention):
        return convention
    if convention not in PRESETS:
        raise FrameError(
            f"convention {convention!r}: is not known; there are {', '.join(PRESETS)}, or make a Convention"
        )
    return PRESETS[convention]
