"""Light that is kept from frame to frame: of which frame the light of a tile is.

Light depends on the eye and on the sun, not on where the camera looks. A tile's light is made anew in turn, every
`reuse` frames, and between these where at its middle the half vector has turned too far for the lobe of the maps'
highest power: (N.H)^p is exp(-p angle^2 / 2), which changes by at most sqrt(p/e) of its peak a radian; or where the sun
has turned by as much. That frame follows from the sequence alone, so that what was rendered before changes no bit.
"""

from collections.abc import Callable, Iterable, Mapping
from math import e, sqrt
from typing import NamedTuple

import numpy as np
import warp as wp
from numpy.typing import NDArray

from sequences import Road
from swimlab.render.atlas import Held, Tiles
from swimlab.render.kernels.epochs import follow
from swimlab.render.layout import Ints, Layout, placed
from swimlab.render.mesh import charts_in
from swimlab.render.shot import Kept, Made, Shot


class Pose(NamedTuple):
    """What light depends on. eye: m, in the world. direction, diffuse: of the sun. Frames of one number are alike."""

    eye: tuple[float, ...]
    direction: tuple[float, ...]
    diffuse: float
    number: int


def recent(kept: Mapping[int, Made], near: range) -> dict[int, Made]:
    """What is kept of some frames, of those in a range."""
    return {frame: made for frame, made in kept.items() if frame in near}


class Epochs:
    """Finds the frame whose light tiles have. reuse: frames that light is kept at most. tolerance: see above."""

    def __init__(self, reuse: int, tolerance: float) -> None:
        self._reuse, self._tolerance = reuse, tolerance
        self._shots: dict[int, Shot] = {}
        self._drawn: dict[int, Roads] = {}
        self._wholes: dict[int, tuple[NDArray[np.int64], NDArray[np.bool_]]] = {}
        self._poses: dict[int, Pose] = {}
        self._numbers: dict[object, int] = {}
        self._rows = Kept()

    def look(self, shot: Shot) -> None:
        """Make `shot` the present, and forget frames that are too old to matter."""
        self._now = shot
        near = range(self.oldest, shot.frame)
        self._shots = recent(self._shots, near) | {shot.frame: shot}
        self._drawn, self._wholes = recent(self._drawn, near), recent(self._wholes, near)
        self._poses = recent(self._poses, near)
        self._window = [self._pose(frame) for frame in self._frames()] if self._reuse > 1 else []

    def shot(self, frame: int) -> Shot:
        """Another frame of the sequence."""
        if frame not in self._shots:
            self._shots[frame] = self._now.at(frame)
        return self._shots[frame]

    @property
    def oldest(self) -> int:
        """The first frame whose light may be kept until now."""
        return self._now.frame - self._reuse + 1

    def poses(self, frames: Iterable[int]) -> list[int]:
        """A number for each of some frames up to now, the same where eye and sun are the same."""
        return [self._pose(frame).number if self._reuse > 1 else 0 for frame in frames]

    def _pose(self, frame: int) -> Pose:
        if frame not in self._poses:
            shot = self.shot(frame)
            light, camera = shot.sequence.sun(frame), shot.view.camera

            def content() -> tuple[tuple[float, ...], tuple[float, ...], float]:
                eye = camera.eye(shot.sequence.scene.road)
                return tuple(eye.tolist()), tuple(light.direction.tolist()), light.diffuse

            pose = shot.kept("pose", (shot.sequence.scene, camera, light), content)
            self._poses[frame] = Pose(*pose, self._numbers.setdefault(pose, len(self._numbers)))
        return self._poses[frame]

    def finding(self, tiles: Tiles, last: Held) -> tuple[range, Callable[[], None]]:
        """The frames whose light tiles may have, and what fills EPOCH of tiles once they are chosen.

        last: tiles of one frame ago, nothing where that was not rendered.
        """
        if self._tolerance == 0 or len({pose.number for pose in self._window}) < 2:
            return range(self._now.frame, self._now.frame + 1), lambda: None
        if tiles.fitted:  # they are only when what is seen is known
            return self._frames(), lambda: self._following(tiles, last)()
        return self._frames(), self._following(tiles, last)

    def _following(self, tiles: Tiles, last: Held) -> Callable[[], None]:
        layout, launcher, road = tiles.layout, self._now.launcher, self._now.sequence.scene.road
        rows = self._rows.get("rows", (layout, last.layout), lambda: rows_of(layout, last.layout, road))
        whole = np.array([self._whole(frame, layout.segments) for frame in self._frames()])
        # What had the number of a wire's or a post's chart then was another one.
        whole &= placed(layout.segments, self._roads(self._now.frame).segments) >= 0
        inputs = [
            self.oldest,
            sqrt(self._now.material.highest_power / e),
            self._tolerance,
            launcher.lent(np.array([pose.eye for pose in self._window]), wp.vec3d),
            launcher.lent(np.array([pose.direction for pose in self._window], np.float32), wp.vec3),
            launcher.lent(whole, wp.bool),
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

    def _frames(self) -> range:
        return range(self.oldest, self._now.frame + 1)

    def _whole(self, frame: int, segments: NDArray[np.int64]) -> NDArray[np.bool_]:
        """Of each of some targets, whether a frame draws its segment of the road to both ends."""
        known = self._wholes.get(frame)
        if known is None or known[0] is not segments:
            known = self._wholes[frame] = segments, placed(segments, self._roads(frame).whole) >= 0
        return known[1]

    def _roads(self, frame: int) -> "Roads":
        if frame not in self._drawn:
            mesh = self.shot(frame).mesh
            road = ~mesh.loose
            segments, first = charts_in(mesh.segments[road])
            v = mesh.uv[mesh.triangles[road], 1]
            whole = np.minimum.reduceat(v.min(axis=1), first) == 0.0
            whole &= np.maximum.reduceat(v.max(axis=1), first) == 1.0
            whole &= np.minimum.reduceat(mesh.facing[road], first)
            self._drawn[frame] = Roads(segments, segments[whole])
        return self._drawn[frame]


class Roads(NamedTuple):
    """Segments of the road that a frame draws, rising, and those that it draws to both ends and that face the eye all
    over."""

    segments: NDArray[np.int64]
    whole: NDArray[np.int64]


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
