"""Charts: the segments of a mesh in texture space, each with its atlas coordinates as positions."""

from dataclasses import dataclass, field
from functools import cached_property
from typing import Any, NamedTuple

import numpy as np
import warp as wp
from numpy.typing import NDArray

from metrics.kernels.launch import Launcher
from swimlab.render.atlas import Tiles
from swimlab.render.kernels.choosing import LEAST_WIDTH
from swimlab.render.layout import Ints, Layout, placed
from swimlab.render.mesh import Doubles, Mesh, charts_in
from swimlab.render.shot import Kept, Shot
from swimlab.render.triangles import Triangles, set_up


@dataclass(frozen=True)
class Charts:
    """The charts of a mesh that turn to the eye, wholly or in part; (0, 0) to (1, 1) is a whole target.

    Triangles that face away are left out (Sloan & Baker, Drawing polygons on the backside).

    chosen: the mesh's triangles that are left, chart by chart. segments: [n], numbers of the charts, rising. ranges:
    [n, 2], of each chart the first of its triangles among these and one past the last. low, high: [n, 2], its extent
    in uv. narrowest: [n], the least extent in u or v of its triangles. owners: the chart of each triangle of
    the mesh, or -1.
    """

    launcher: Launcher
    mesh: Mesh
    chosen: NDArray[np.int64]
    segments: NDArray[np.int64]
    ranges: Ints
    low: Doubles
    high: Doubles
    narrowest: Doubles
    owners: Ints
    _kept: Kept = field(default_factory=Kept, repr=False)

    @staticmethod
    def of(launcher: Launcher, mesh: Mesh) -> "Charts":
        """All charts of a mesh."""
        chosen = np.flatnonzero(mesh.facing)
        segments, first = charts_in(mesh.segments[chosen])
        ranges = np.stack([first, np.append(first, len(chosen))[1:]], axis=1).astype(np.int32)
        of_all = np.full(len(mesh.segments), -1, np.int32)
        of_all[chosen] = np.repeat(np.arange(len(first)), ranges[:, 1] - ranges[:, 0])
        corners = mesh.uv[mesh.triangles[chosen]]
        low, high = corners.min(axis=1), corners.max(axis=1)
        extent = np.min(high - low, axis=1)
        some = len(segments) > 0
        return Charts(
            launcher,
            mesh,
            chosen,
            segments,
            ranges,
            np.minimum.reduceat(low, first) if some else low,
            np.maximum.reduceat(high, first) if some else high,
            np.minimum.reduceat(extent, first) if some else extent,
            of_all,
        )

    @cached_property
    def are_wide(self) -> bool:
        """Whether none is narrower than a texel, however small its target."""
        return bool(np.all((self.high - self.low) * LEAST_WIDTH >= 1))

    def drawn(self, tiles: Tiles) -> "Drawn":
        """The charts in targets, which may be of other charts too; kept while these are the same."""
        # Of wide charts it is the same for targets of all sizes, also before these are fitted.
        of = tiles.segments.tobytes() if self.are_wide else tiles.layout
        return self._kept.get("drawn", of, lambda: self._drawn(tiles.layout))

    def _drawn(self, layout: Layout) -> "Drawn":
        place = placed(layout.segments, self.segments)
        has, place = place >= 0, np.maximum(place, 0)
        ranges, widened = np.zeros((len(place), 2), np.int32), np.zeros(len(place), bool)
        texels = np.zeros(len(self.segments))
        if has.any():
            ranges[has] = self.ranges[place[has]]
            widened[has] = np.any((self.high - self.low)[place[has]] < 1 / layout.widths[has, None], axis=1)
            texels[place[widened]] = 1 / layout.widths[widened]
        triangles = self._kept.get("triangles", texels.tobytes(), lambda: self._set_up(texels))
        return Drawn(self.launcher.lent(ranges, wp.vec2i), widened, triangles)

    def _set_up(self, texels: Doubles) -> Triangles:
        """texels: the side of one of each chart that is widened, else 0."""
        mesh = self.mesh
        points = np.concatenate([mesh.uv, np.ones((len(mesh.uv), 1))], axis=1)
        for k in np.flatnonzero(texels).tolist():
            vertices = np.unique(mesh.triangles[self.chosen[slice(*self.ranges[k])]])
            middle = (self.low[k] + self.high[k]) / 2
            wider = np.maximum(1.0, texels[k] / np.maximum(self.high[k] - self.low[k], 1e-12))
            points[vertices, :2] = middle + (mesh.uv[vertices] - middle) * wider
        return set_up(self.launcher, points, mesh, self.chosen)


class Drawn(NamedTuple):
    """Charts in targets. One narrower than a texel, which might hold no texel's centre, is widened about its middle.

    ranges: [n], as launches take it, of each target the first of its triangles and one past the last. widened: [n],
    whether its chart is. triangles: of all charts, ready for the rasteriser.
    """

    ranges: Any
    widened: NDArray[np.bool_]
    triangles: Triangles


def charts_of(shot: Shot) -> Charts:
    """The charts of a shot's mesh; kept where the eye stands still."""
    of = shot.sequence.scene, shot.view.camera, shot.launcher
    return shot.kept("charts", of, lambda: Charts.of(shot.launcher, shot.mesh))
