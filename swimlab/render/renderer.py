"""Rendering the frames of a plan into files, one at a time, for runs and sweeps."""

import time
from collections.abc import Callable
from pathlib import Path
from typing import NamedTuple

import numpy as np

from metrics.kernels.launch import Launcher
from sequences import Sequence
from swimlab.render.catalogue import model_of, techniques
from swimlab.render.geometry import describe_geometry
from swimlab.render.material import load_material
from swimlab.render.plan import Plan
from swimlab.render.shot import Shot
from swimlab.render.technique import Picture
from swimlab.runs.frames import COLOUR, Image, frame_path, write_channels, write_frame, write_geometry
from swimlab.runs.provenance import SWIMLAB
from swimlab.runs.record import ERROR, GEOMETRY, RunError


class Rendered(NamedTuple):
    """A picture that was written.

    ms: time to render it. shaded: samples, texels or vertices. rms_error: its own standard error, where known.
    """

    ms: float
    shaded: int
    rms_error: float | None


class Renderer:
    """Renders a plan's frames and writes them below a folder; the files carry `digest`."""

    def __init__(self, plan: Plan, launcher: Launcher, *, digest: str) -> None:
        """Raises MapError for unfit maps."""
        self._plan = plan
        model = model_of(plan.sequence)
        material = load_material(plan.sequence, launcher, twisted=model.anisotropic)
        self._shot = Shot(plan.sequence, 0, material, model, plan.samples, launcher)
        self._renders = {name: _begin(plan.sequence, name) for name in plan.techniques}
        self._metadata = {"swimlab:hash": digest, "swimlab:version": SWIMLAB}

    def shot(self, frame: int) -> Shot:
        """A frame, for all of the techniques."""
        return self._shot.at(frame)

    def write_geometry(self, shot: Shot, folder: Path) -> None:
        """Write FOLDER/geometry/FRAME.exr."""
        write_geometry(frame_path(folder, GEOMETRY, shot.frame), describe_geometry(shot), metadata=self._metadata)

    def write_picture(self, shot: Shot, name: str, folder: Path) -> Rendered:
        """Render a technique and write FOLDER/NAME/FRAME.exr; before that its standard error, where it is known.

        Raises RunError for what is no picture of the frame, and for a picture that the file cannot hold.
        """
        started = time.perf_counter()
        picture = self._renders[name](shot)
        ms = 1e3 * (time.perf_counter() - started)
        check_form(picture, name, shot.frame, (shot.view.height, shot.view.width, len(COLOUR)))
        check_range(picture, name, shot.frame, half=self._plan.half)
        error = None
        if picture.error is not None:
            path = frame_path(folder, ERROR, shot.frame)
            write_channels(path, picture.error, COLOUR, half=self._plan.half, metadata=self._metadata)
            error = rms_error(picture.rgba, picture.error)
        path = frame_path(folder, name, shot.frame)
        write_frame(path, picture.rgba, half=self._plan.half, metadata=self._metadata)
        return Rendered(ms, picture.shaded, error)


def rms_error(rgba: Image, error: Image) -> float:
    """Root of the mean squared standard error over RGB and the wholly covered pixels; 0 where there is none."""
    covered = rgba[..., 3] == 1.0
    return float(np.sqrt(np.mean(np.square(error[covered][:, :3], dtype=np.float64)))) if covered.any() else 0.0


def check_form(picture: object, name: str, frame: int, shape: tuple[int, int, int]) -> None:
    """Raise RunError for what a technique gives other than a picture of floats of this shape, as its error is too."""
    told = f"{name}, frame {frame}: the technique should give a Picture"
    if not isinstance(picture, Picture):
        raise RunError(f"{told}, and gave {type(picture).__name__}; mend its file")
    for what, pixels in (("rgba", picture.rgba), ("error", picture.error)):
        if what == "error" and pixels is None:
            continue
        if not isinstance(pixels, np.ndarray) or pixels.shape != shape or pixels.dtype.kind != "f":
            given = f"{pixels.dtype} {list(pixels.shape)}" if isinstance(pixels, np.ndarray) else type(pixels).__name__
            raise RunError(f"{told} whose {what} is an array of floats {list(shape)}, and gave {given}; mend its file")
    if not isinstance(picture.shaded, int | np.integer):
        raise RunError(f"{told} whose shaded is a whole number, and gave {picture.shaded!r}; mend its file")


def check_range(picture: Picture, name: str, frame: int, *, half: bool) -> None:
    """Raise RunError for a picture that holds a NaN or Inf, or, with `half`, more than a 16-bit float does."""
    brightest = max(float(np.abs(pixels).max()) for pixels in (picture.rgba, picture.error) if pixels is not None)
    if not np.isfinite(brightest):
        raise RunError(f"{name}, frame {frame}: came out with a NaN or Inf; look for extreme values in the maps")
    if half and brightest > float(np.finfo(np.float16).max):
        raise RunError(f"{name}, frame {frame}: is too bright for 16-bit floats (over 65504); render with --float")


def _begin(sequence: Sequence, name: str) -> Callable[[Shot], Picture]:
    """The function that renders shots under a technique, with the settings that the sequence gives it."""
    technique = techniques()[name]
    settings = technique.settings.model_validate(sequence.techniques.get(name, {}))
    render = technique.begin()
    return lambda shot: render(shot, settings)
