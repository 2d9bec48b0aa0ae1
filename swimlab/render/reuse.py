"""Light that is kept from frame to frame: of which frame the light of a tile is.

Light depends on the eye and on the sun, not on where the camera looks. A tile is lit when it comes into sight, when it
is shaded at another level or finer ones are wanted of it, where its segment of the road was cut one frame ago; and anew
in turn, every `reuse` frames. Between these it is lit where at its middle the half vector has turned too far for the
lobe of the maps' highest power: (N.H)^p is exp(-p angle^2 / 2), which changes by at most sqrt(p/e) of its peak a
radian; or where the sun has changed by as much. As every tile has its turn within `reuse` frames, its light follows
from these, and a frame that is rendered by itself begins with them.
"""

from collections.abc import Callable
from math import e, sqrt
from typing import NamedTuple

import numpy as np
import warp as wp
from numpy.typing import NDArray

from sequences import Road
from swimlab.render.atlas import Held, Tiles
from swimlab.render.kernels.epochs import CUT, OTHER, WHOLE, follow
from swimlab.render.layout import Ints, Layout, placed
from swimlab.render.mesh import Mesh, charts_in
from swimlab.render.shot import Kept, Shot


class Pose(NamedTuple):
    """What light depends on. eye: m, in the world. direction, diffuse: of the sun."""

    eye: tuple[float, ...]
    direction: tuple[float, ...]
    diffuse: float


class Epochs:
    """Finds the frame whose light tiles have. reuse: frames that light is kept at most. tolerance: see above."""

    def __init__(self, reuse: int, tolerance: float) -> None:
        self._reuse, self._tolerance = reuse, tolerance
        self._poses: dict[int, Pose] = {}
        self._numbers: dict[Pose, int] = {}
        self._roads: dict[int, Roads] = {}
        self._rows = Kept()

    def look(self, shot: Shot) -> None:
        """Make `shot` the present, and forget frames that are too old to matter."""
        self._now = shot
        self._roads = {frame: road for frame, road in self._roads.items() if shot.frame - frame in (0, 1)}
        frames = range(self.oldest, shot.frame + 1) if self._reuse > 1 else ()
        self._poses = {frame: self._poses.get(frame) or self._pose(frame) for frame in frames}
        self._numbers = {pose: self._numbers.get(pose, frame) for frame, pose in self._poses.items()}

    @property
    def oldest(self) -> int:
        """The first frame whose light may be kept until now."""
        return self._now.frame - self._reuse + 1

    @property
    def numbers(self) -> list[int]:
        """A number of each of these frames, the same where eye and sun are the same; of others no pose has had it."""
        return [self._numbers[pose] for pose in self._poses.values()] or [0]

    @property
    def differ(self) -> bool:
        """Whether it matters of which of these frames light is."""
        return self._tolerance > 0 and len(self._numbers) > 1

    def _pose(self, frame: int) -> Pose:
        shot = self._now.at(frame)
        light, camera = shot.sequence.sun(frame), shot.view.camera

        def content() -> tuple[tuple[float, ...], tuple[float, ...], float]:
            eye = camera.eye(shot.sequence.scene.road)
            return tuple(eye.tolist()), tuple(light.direction.tolist()), light.diffuse

        return Pose(*shot.kept("pose", (shot.sequence.scene, camera, light), content))

    def finding(self, tiles: Tiles, last: Held) -> Callable[[], None]:
        """What sets EPOCH and KEEP of tiles whose light is kept, once all are chosen.

        last: tiles of one frame ago, none where nothing is held.
        """
        if not self.differ:
            return lambda: None
        if tiles.fitted:  # they are only when what is seen is known
            return lambda: self._following(tiles, last)()
        return self._following(tiles, last)

    def _following(self, tiles: Tiles, last: Held) -> Callable[[], None]:
        layout, launcher, now = tiles.layout, self._now.launcher, self._now.frame
        road, poses = self._now.sequence.scene.road, self._poses.values()
        rows = self._rows.get("rows", (layout, last.layout), lambda: rows_of(layout, last.layout, road))
        inputs = [
            now,
            sqrt(self._now.material.highest_power / e),
            self._tolerance,
            launcher.lent(np.array([pose.eye for pose in poses]), wp.vec3d),
            launcher.lent(np.array([(*pose.direction, pose.diffuse) for pose in poses], np.float32), wp.vec4),
            launcher.lent(self._states(layout.segments), wp.int32),
            road.width,
            launcher.lent(rows.targets, wp.vec4i),
            launcher.lent(rows.places, wp.vec2d),
            launcher.lent(rows.before, wp.int32),
            tiles.table.device,
            last.table.device,
        ]
        follow_all = launcher.laid_out(len(rows.before), follow, (), inputs)

        def find() -> None:
            for table in (tiles.table, last.table):
                table.send()
            follow_all()
            tiles.table.fetch()

        return find

    def _states(self, segments: NDArray[np.int64]) -> Ints:
        """What targets are of, now and one frame ago (see `follow`)."""
        now, before = (self._road(frame) for frame in (self._now.frame, self._now.frame - 1))
        states = np.where(placed(segments, before.whole) >= 0, WHOLE, CUT)
        # What had the number of a wire's or a post's chart then was another one.
        return np.where(placed(segments, now.segments) >= 0, states, OTHER).astype(np.int32)

    def _road(self, frame: int) -> "Roads":
        if frame not in self._roads:
            self._roads[frame] = Roads.of(self._now.at(frame).mesh)
        return self._roads[frame]


class Roads(NamedTuple):
    """Segments of the road that a frame draws, rising, and those that it draws to both ends and that face the eye all
    over."""

    segments: NDArray[np.int64]
    whole: NDArray[np.int64]

    @staticmethod
    def of(mesh: Mesh) -> "Roads":
        """Of the frame's mesh."""
        road = ~mesh.loose
        segments, first = charts_in(mesh.segments[road])
        v = mesh.uv[mesh.triangles[road], 1]
        whole = np.minimum.reduceat(v.min(axis=1), first) == 0.0
        whole &= np.maximum.reduceat(v.max(axis=1), first) == 1.0
        whole &= np.minimum.reduceat(mesh.facing[road], first)
        return Roads(segments, segments[whole])


class Rows(NamedTuple):
    """Rows of tiles of all targets: what `follow` takes as rows, places and before."""

    targets: Ints
    places: NDArray[np.float64]
    before: Ints


def rows_of(layout: Layout, last: Layout, road: Road) -> Rows:
    """The rows of a layout, whose tiles were in the last one or not."""
    across = layout.across
    targets = np.repeat(np.arange(len(across)), across)
    count = across[targets]
    row = np.arange(len(targets)) - np.repeat(np.cumsum(across) - across, across)
    y = (layout.segments[targets] + (row + 0.5) / count) * road.segment
    place = placed(layout.segments, last.segments)
    found = np.flatnonzero(place >= 0)
    place[found[last.widths[place[found]] != layout.widths[found]]] = -1
    before = place.astype(np.int32)[targets]
    known = before >= 0
    before[known] = last.firsts[before[known]] + row[known] * count[known]
    rows = np.stack([targets, layout.firsts[targets] + row * count, count, row], axis=1)
    return Rows(rows.astype(np.int32), np.stack([y, road.height_at(y)], axis=1), before)
