"""Light that is kept from frame to frame: of which frame the light of a tile is.

Light depends on the eye and on the sun, not on where the camera looks. A tile's light is made anew in turn, every
`reuse` frames, and between these where at its middle the half vector has turned too far for the lobe of the maps'
highest power: (N.H)^p is exp(-p angle^2 / 2), which changes by at most sqrt(p/e) of its peak a radian; or where the sun
has turned by as much. That frame follows from the sequence alone, so that what was rendered before changes no bit.
"""

from math import e, sqrt
from typing import NamedTuple

import numpy as np
import warp as wp
from numpy.typing import NDArray

from swimlab.render.atlas import Ints, Layout
from swimlab.render.kernels.epochs import follow
from swimlab.render.shot import Shot

UNKNOWN = -(1 << 40)
"""A frame that is older than any that matters."""


class Pose(NamedTuple):
    """What light depends on. eye: m, in the world. direction, diffuse: of the sun. Frames of one number are alike."""

    eye: tuple[float, ...]
    direction: tuple[float, ...]
    diffuse: float
    number: int


class Epochs:
    """Finds the frame whose light tiles have. reuse: frames that light is kept at most. tolerance: see above."""

    def __init__(self, reuse: int, tolerance: float) -> None:
        self._reuse, self._tolerance = reuse, tolerance
        self._shots: dict[int, Shot] = {}
        self._whole: dict[int, Ints] = {}
        self._poses: dict[int, Pose] = {}
        self._numbers: dict[object, int] = {}

    def look(self, shot: Shot) -> None:
        """Make `shot` the present, and forget frames that are too old to matter."""
        self._now = shot
        near = range(shot.frame - self._reuse + 1, shot.frame)
        self._shots = {frame: old for frame, old in self._shots.items() if frame in near} | {shot.frame: shot}
        self._whole = {frame: old for frame, old in self._whole.items() if frame in near}
        self._poses = {frame: old for frame, old in self._poses.items() if frame in near}

    def shot(self, frame: int) -> Shot:
        """Another frame of the sequence."""
        if frame not in self._shots:
            self._shots[frame] = self._now.at(frame)
        return self._shots[frame]

    def poses(self, frames: Ints) -> Ints:
        """A number for each frame, the same where eye and sun are the same."""
        unique, inverse = np.unique(frames, return_inverse=True)
        return np.array([self._pose(frame).number for frame in unique.tolist()], np.int64)[inverse]

    def _pose(self, frame: int) -> Pose:
        if frame not in self._poses:
            sequence = self._now.sequence
            light = sequence.sun(frame)
            eye = sequence.view(frame).camera.eye(sequence.scene.road)
            content = tuple(eye.tolist()), tuple(light.direction.tolist()), light.diffuse
            self._poses[frame] = Pose(*content, self._numbers.setdefault(content, len(self._numbers)))
        return self._poses[frame]

    def epochs(self, layout: Layout, wanted: NDArray[np.bool_], before: Ints) -> Ints:
        """The frame whose light each wanted entry has now. before: what it was one frame ago, or UNKNOWN."""
        now = self._now.frame
        found = np.full(layout.entries, now)
        oldest = now - self._reuse + 1
        frames = range(oldest, now + 1)
        poses = [self._pose(frame) for frame in frames]
        if self._tolerance == 0 or len({pose.number for pose in poses}) == 1:
            return found
        entries = np.flatnonzero(wanted & layout.is_tile)
        targets = layout.owners[entries]
        row, column = np.divmod(entries - layout.firsts[targets], layout.across[targets])
        start = now - (now - column - 3 * row) % self._reuse
        known = before[entries] >= start
        launcher, road = self._now.launcher, self._now.sequence.scene.road
        u, v = ((index + 0.5) / layout.across[targets] for index in (column, row))
        y = (np.array(layout.segments)[targets] + v) * road.segment
        places = np.stack([(u - 0.5) * road.width, y, road.height_at(y)], axis=1)
        whole = np.stack([np.isin(layout.segments, self._whole_segments(frame)) for frame in frames])
        epochs = launcher.array(np.where(known, before[entries], start) - oldest, wp.int32)
        inputs = [
            sqrt(self._now.material.highest_power / e),
            self._tolerance,
            launcher.array([pose.eye for pose in poses], wp.vec3d),
            launcher.array([pose.direction for pose in poses], wp.vec3),
            launcher.array(whole, wp.int32),
            launcher.array(places, wp.vec3d),
            launcher.array(targets, wp.int32),
            launcher.array(np.where(known, now, start + 1) - oldest, wp.int32),
            epochs,
        ]
        launcher.over(len(entries), follow, (), inputs)
        found[entries] = epochs.numpy() + oldest
        return found

    def _whole_segments(self, frame: int) -> Ints:
        """Segments of the road that a frame draws to both ends, and that face the eye all over."""
        if frame not in self._whole:
            mesh = self.shot(frame).mesh
            road = ~mesh.loose
            segments, first = np.unique(mesh.segments[road], return_index=True)
            v = mesh.uv[mesh.triangles[road], 1]
            whole = np.minimum.reduceat(v.min(axis=1), first) == 0.0
            whole &= np.maximum.reduceat(v.max(axis=1), first) == 1.0
            whole &= np.minimum.reduceat(mesh.facing[road], first)
            self._whole[frame] = segments[whole]
        return self._whole[frame]
