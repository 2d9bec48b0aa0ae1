"""What every contender draws, as plain arrays, and how far a picture of it is from the reference."""

from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from metrics.kernels.launch import Launcher
from sequences import Sequence, load
from swimlab.render.catalogue import model_of
from swimlab.render.geometry import describe_geometry
from swimlab.render.inputs import BOX
from swimlab.render.material import load_material
from swimlab.render.shot import Shot
from swimlab.render.technique import render_samples
from swimlab.render.triangles import screen_projection

Image = NDArray[np.float32]

PITCH = -13.0
"""Degrees. The library's road-shift (-8) fills 51% of a wide frame; this fills 60%, with the horizon in view."""


class Contender(NamedTuple):
    """Something that draws frames of the road. Only `draw` is timed: the picture is complete when it returns.

    read: the last drawn picture, [H, W, 4], linear, premultiplied; row 0 on top.
    samples: the samples a covered pixel that it shades.
    """

    label: str
    draw: Callable[[int], None]
    read: Callable[[], Image]
    samples: int = 1


def road_sequence(size: tuple[int, int]) -> Sequence:
    """The road: road-shift with the camera tilted to fill 60% of the frame."""
    sequence = load("road-shift")
    camera = sequence.camera.model_dump() | {"pitch": PITCH}
    return sequence.with_changes(size=size, camera=camera)


@dataclass(frozen=True)
class Road:
    """The sequence with its maps in memory."""

    sequence: Sequence
    launcher: Launcher

    @cached_property
    def _material(self):
        return load_material(self.sequence, self.launcher)

    @cached_property
    def model(self):
        """The reflectance model: the deck's Blinn-Phong."""
        return model_of(self.sequence)

    def shot(self, frame: int, *, samples: int = 64) -> Shot:
        """A frame that nothing has been done for yet."""
        return Shot(self.sequence, frame, self._material, self.model, samples, self.launcher)

    @cached_property
    def levels(self) -> list[Image]:
        """The mip chain, from full size to 1x1: [h, w, 8] of albedo, normal, Ks, power."""
        chain = self._material.chain(BOX)
        texels, offsets = chain.texels.numpy(), chain.shape.offsets.numpy()
        sides = [max(1, chain.shape.width >> level) for level in range(chain.shape.levels)]
        return [texels[o : o + n * n].reshape(n, n, 8) for o, n in zip(offsets, sides, strict=True)]

    @cached_property
    def light(self) -> tuple[NDArray[np.float64], float]:
        """Unit vector to the sun, and the diffuse intensity."""
        sun = self.sequence.sun(0)
        return sun.direction, sun.diffuse

    def projection(self, frame: int) -> NDArray[np.float64]:
        """The 3x3 matrix from a position relative to the eye (m) to the frame's pixels (x w, y w, w)."""
        view = self.sequence.view(frame)
        projection = screen_projection(view.camera, view.height, view.width)
        shift = np.array([[1, 0, -view.origin[0]], [0, 1, -view.origin[1]], [0, 0, 1]])
        return np.asarray(shift @ projection)

    def visible_segments(self, frame: int) -> list[int]:
        """Segments that some pixel's centre sees, nearest first: of the road alone, in a scene with nothing else."""
        from swimlab.render.techniques.tsl import TslSettings, planned_alone

        screen, _ = planned_alone(self.shot(frame), TslSettings(size=16))
        segments: list[int] = screen.segments.tolist()
        return segments


@dataclass(frozen=True)
class ReferenceFrames:
    """The reference at many samples, on pixels that the road covers wholly."""

    picture: Image
    error: Image
    whole: NDArray[np.bool_]

    @staticmethod
    def of(road: Road, frame: int, *, samples: int = 256) -> "ReferenceFrames":
        """Render it."""
        from swimlab.render.kernels.texture_filter import FINEST

        shot = road.shot(frame)
        picture = render_samples(shot, FINEST, n=int(samples**0.5), jittered=True)
        assert picture.error is not None
        return ReferenceFrames(picture.rgba, picture.error, describe_geometry(shot).coverage == 1.0)

    def rms(self, picture: Image) -> float:
        """Root mean square error of RGB; pixels that the picture does not cover count as black."""
        return rms(picture, self.picture, self.whole)

    @property
    def floor(self) -> float:
        """The reference's own error."""
        return float(np.sqrt(np.mean(np.square(self.error[self.whole][:, :3], dtype=np.float64))))


def rms(a: Image, b: Image, where: NDArray[np.bool_]) -> float:
    """Root mean square difference of RGB over some pixels."""
    return float(np.sqrt(np.mean(np.square(a[where][:, :3].astype(np.float64) - b[where][:, :3]))))
