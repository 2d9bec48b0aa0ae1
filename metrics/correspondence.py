"""Where the surface seen in one frame is seen in another, composed from motion fields, and pictures taken there.

Everything is done with B-spline interpolation (Unser 1999): linear interpolation would itself read as flicker.
Surfaces that pass in front of each other are recognised by their motion: the field bends at the edge between them, and
nothing is measured near such an edge, nor where two of them come from one place.
"""

from collections.abc import Iterator, Sequence
from itertools import islice
from typing import Any

import numpy as np
import warp as wp
from numpy.typing import NDArray

from metrics.geometry import Field, Geometry, Mask, Surface
from metrics.kernels.claims import claim_rows
from metrics.kernels.edges import find_smooth, land_rows
from metrics.kernels.follow import steps
from metrics.kernels.gains import FINEST, add_gains, mean_left, table, whole_octaves
from metrics.kernels.interpolation import field_spline, picture_spline, taken
from metrics.kernels.launch import Launcher
from metrics.memory import unset
from metrics.tiles import Level
from metrics.transform import TileTransform

# Splines ring where a picture ends: nothing is measured this near to an edge (the quintic's ringing falls by
# .43 a pixel).
MARGIN = 8

# A tile is left out where the other frame shows the surface this many times smaller: its detail is lost there.
SHRINK = 2.0

# A motion field has an edge where its second difference is larger, px.
BEND = 0.25

# Surfaces that move apart by less than this in a frame have an edge between them that is MARGIN wide, px.
APART = MARGIN / 2

# A place in the next frame is lost, since its surface is covered up there, if it is still so far off, px.
LOST = 1e-3

# Every so many rows and columns tell what interpolation leaves of a frame's noise.
SAMPLED = 4


class Correspondence:
    """A span's middle frame followed through frames start..stop-1.

    usable: [H, W], true where the surface of the middle frame is seen in every frame, off all edges, and not much
        smaller. Places are held if they take no more than `room` bytes, else found again as they are asked for.
    left_in: [frames, octaves], share of a noise's energy that taking pictures there leaves, mean over what is usable.
    """

    def __init__(self, geometry: Geometry, launcher: Launcher, start: int, stop: int, *, room: float) -> None:
        self._geometry, self._launcher = geometry, launcher
        self._start, self._stop = start, stop
        self._steps = steps(launcher.device)
        self._middle = (start + stop - 1) // 2
        self._held: list[Field] = []
        later: list[Field] = []
        height, width = geometry.shape
        holds = 8 * height * width * (stop - start) <= room
        self._sampled: list[Field] = []
        self._first, self.usable, self._gains = self._trace(later if holds else None)
        usable, left = self.usable[::SAMPLED, ::SAMPLED], np.empty((len(self._sampled), FINEST))

        def sample(frame: int) -> None:
            left[frame] = mean_left(self._sampled[frame][usable], table())

        launcher.each(range(len(left)), sample)
        self.left_in = whole_octaves(left)
        self._sampled.clear()
        if holds:
            until_middle = islice(self.places(slice(0, height)), self._middle - start + 1)
            self._held = [*map(launcher.copied, until_middle), *later]

    def places(self, rows: slice) -> Iterator[Field]:
        """Frame by frame how far from each pixel of these rows of the middle frame its surface is, [rows, W, 2] px.

        Each stands until the next is asked for.
        """
        if self._held:
            yield from (away[rows] for away in self._held)
            return
        away = self._launcher.view(self._launcher.copied(self._first[rows]), wp.vec2)
        moved, usable = self._launcher.zeros(away.shape, wp.vec2), self._launcher.empty(away.shape, wp.uint8)
        for t in range(self._start, self._stop):
            if t > self._start:
                self._step_ahead(t, rows.start, away, moved, usable)
            if t == self._middle:
                away.zero_()
                moved.zero_()
            yield np.asarray(away.numpy())

    def take(self, picture: NDArray[Any], away: Field, rows: slice) -> NDArray[np.float32]:
        """Rows of a picture [channels, H, W] as seen from the middle frame: taken `away`, 0 where not usable."""
        launcher = self._launcher
        usable = launcher.view(self.usable[rows].view(np.uint8), wp.uint8)
        spline = picture_spline(launcher, picture.astype(np.float32, copy=False))
        return taken(launcher, spline, launcher.view(away, wp.vec2), usable, rows.start, len(picture))

    def left_of(self, levels: Sequence[Level]) -> list[NDArray[np.float64]]:
        """For every level [n, octaves], the share of a noise's energy that is left in its tiles, mean over the frames.

        Asked for once: pixel by pixel it is let go.
        """
        gains, frames = np.moveaxis(self._gains, 2, 0), np.float32(self._stop - self._start)
        planes = unset(gains.shape, np.float32)

        def mean(octave: int) -> None:
            np.divide(gains[octave], frames, out=planes[octave])

        self._launcher.each(range(len(planes)), mean)
        del self._gains
        transforms = (TileTransform(level, (0.0, 0.0)) for level in levels)
        return [whole_octaves(transform.power_mean(planes, self._launcher)) for transform in transforms]

    def glue(self) -> Iterator[Field]:
        """Frame by frame how far the surface that each pixel sees is in the middle frame, [H, W, 2] px.

        The opposite of `places`, and found in another way: pixel by pixel from one frame to the next.
        """
        launcher = self._launcher
        rest = np.zeros((*self._geometry.shape, 2), np.float32)
        away = rest
        for t in range(self._middle - 1, self._start - 1, -1):
            after = _field(self._geometry.surface(t + 1))
            away = self._glued(self._steps.glue_back, field_spline(launcher, after), away)
        for t in range(self._start, self._stop):
            if t > self._start:
                motion = _field(self._geometry.surface(t))
                away = self._glued(self._steps.glue_ahead, launcher.view(motion, wp.vec2), away)
            away = rest if t == self._middle else away
            yield away

    def _trace(self, later: list[Field] | None) -> tuple[Field, Mask, Field]:
        """The places of the first frame, what is usable, and what is left of noise, summed over the frames: from the
        middle frame backwards, then forwards.

        later: takes the places of the frames after the middle one.
        """
        launcher, shape = self._launcher, self._geometry.shape
        middle = self._geometry.surface(self._middle)
        usable = launcher.array(self._inner(self._middle, middle), wp.uint8)
        away = launcher.zeros(shape, wp.vec2)
        gains = launcher.zeros(shape, wp.vec3)
        self._sum_gains(away, gains)
        for t in range(self._middle - 1, self._start - 1, -1):
            after = self._geometry.surface(t + 1)
            launcher.over(shape[0], self._steps.back, (), [field_spline(launcher, _field(after)), 0, away])
            inner = self._inner(t, self._geometry.surface(t)) & ~self._meet(after)
            self._land(inner, away, usable)
            self._sum_gains(away, gains)
        self._sampled.reverse()
        first = launcher.copied(away.numpy())
        away.zero_()
        moved = launcher.zeros(shape, wp.vec2)
        for t in range(self._middle + 1, self._stop):
            surface = self._geometry.surface(t)
            met = self._meet(surface)
            if met.any():
                self._land(~met, away, usable)
            self._step_ahead(t, 0, away, moved, usable)
            self._land(self._inner(t, surface), away, usable)
            self._sum_gains(away, gains)
            if later is not None:
                later.append(launcher.copied(away.numpy()))
        return first, usable.numpy().astype(bool), gains.numpy()

    def _sum_gains(self, away: Any, gains: Any) -> None:
        launcher = self._launcher
        left = launcher.view(table(), wp.vec3)
        launcher.over(away.shape[0], add_gains, (), [away, left, gains])
        self._sampled.append(np.array(away.numpy()[::SAMPLED, ::SAMPLED]))

    def _step_ahead(self, t: int, top: int, away: Any, moved: Any, usable: Any) -> None:
        launcher = self._launcher
        field = field_spline(launcher, _field(self._geometry.surface(t)))
        launcher.over(away.shape[0], self._steps.ahead, (), [field, top, away, moved, LOST, usable])

    def _land(self, inner: Mask, away: Any, usable: Any) -> None:
        launcher = self._launcher
        landing = launcher.view(inner.view(np.uint8), wp.uint8)
        launcher.over(away.shape[0], land_rows(launcher.device), (), [landing, 0, away, 1 / SHRINK, usable])

    def _glued(self, kernel: wp.Kernel, motion: Any, nearer: Field) -> Field:
        """Where what a frame sees is in the middle frame, from where what its neighbour sees is."""
        launcher, shape = self._launcher, self._geometry.shape
        away = launcher.empty(shape, wp.vec2)
        launcher.over(shape[0], kernel, (), [motion, field_spline(launcher, nearer), away])
        return np.asarray(away.numpy())

    def _inner(self, t: int, surface: Surface) -> Mask:
        """[H, W], true where frame t is covered, and its motion has no edge, for MARGIN pixels all round."""
        import cv2  # heavy

        whole = surface.whole.view(np.uint8)
        if t > 0:
            launcher, shape = self._launcher, self._geometry.shape
            smooth = launcher.empty(shape, wp.uint8)
            fields = [launcher.view(_field(surface), wp.vec2), BEND, launcher.view(whole, wp.uint8), smooth]
            launcher.over(shape[0], find_smooth(launcher.device), (), fields)
            whole = smooth.numpy()
        square = np.ones((2 * MARGIN + 1, 2 * MARGIN + 1), np.uint8)
        return np.asarray(cv2.erode(whole, square, borderType=cv2.BORDER_CONSTANT, borderValue=0)).view(bool)

    def _meet(self, surface: Surface) -> Mask:
        """Where in the frame before surfaces of this one come from one place though they move apart.

        One of them covered the other there.
        """
        motion = _field(surface)
        rows = motion.reshape(len(motion), -1)
        low, high = (found.reshape(-1, 2) for found in (rows.min(axis=0), rows.max(axis=0)))
        if float((high.max(axis=0) - low.min(axis=0)).max()) <= APART:
            return np.zeros(surface.whole.shape, dtype=bool)
        least, most = claims(self._launcher, motion, surface.whole)
        return np.asarray(((most.numpy() - least.numpy()) > APART).any(axis=2))


def claims(launcher: Launcher, motion: Field, shown: Mask) -> tuple[Any, Any]:
    """Of the motions [H, W, 2] by which pixels shown come from each place of the frame before, the least and the most.

    Two fields [H, W] on the device, px; infinite, and the least above the most, where none comes from.
    """
    least, most = (launcher.filled(shown.shape, wp.vec2, limit) for limit in (np.inf, -np.inf))
    inputs = [launcher.view(motion, wp.vec2), launcher.view(shown.view(np.uint8), wp.uint8), least, most]
    launcher.launch(claim_rows(launcher.device), len(shown), inputs)
    return least, most


def _field(surface: Surface) -> Field:
    """The motion where a surface covers pixels wholly, else 0."""
    mask = surface.mask
    return surface.motion if mask is None else np.where(mask[..., None], surface.motion, np.float32(0.0))
