"""Tiles whose windows ride with the surface, in half-overlapping lattices of 64, 32 and 16 px."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from metrics.kernels.blocks import add_squares
from metrics.kernels.host import on_cpu

SIZES = (64, 32, 16)
"""Tile sizes in px, the largest first."""

# A smaller tile is added where the larger ones weigh less than this at its centre, and none of them could stand.
_SPARSE = 0.45

SAMPLE = 96
"""Tiles of a level at most whose course in time is looked at closely."""

_SMOOTH = 32
_BETA = 10.0

Mask = NDArray[np.bool_]
Offset = tuple[float, float]


@dataclass(frozen=True)
class Level:
    """Tiles of one size.

    origin: [n, 2] (y, x) of each tile's first pixel in the span's anchor frame.
    sample: [n], true for SAMPLE tiles at most, spread evenly, none of which overlap.
    """

    size: int
    origin: NDArray[np.intp]
    sample: Mask

    @property
    def count(self) -> int:
        return len(self.origin)

    @property
    def spectrum_shape(self) -> tuple[int, int]:
        """Shape of one real-input spectrum."""
        return self.size, self.size // 2 + 1

    @property
    def held(self) -> float:
        """Bytes that one spectrum of each tile's three channels takes, in single precision."""
        return 24.0 * self.count * self.size * (self.size // 2 + 1)

    def part(self, tiles: slice | Mask) -> "Level":
        """Some of the tiles."""
        return Level(self.size, self.origin[tiles], self.sample[tiles])

    def frequencies(self) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
        """Vertical [size, 1] and horizontal [1, size/2 + 1] frequencies, cycles/px."""
        vertical = np.asarray(np.fft.fftfreq(self.size), dtype=np.float64)[:, None]
        return vertical, np.asarray(np.fft.rfftfreq(self.size), dtype=np.float64)[None, :]

    def radius(self) -> NDArray[np.float64]:
        """|k| of every bin of a real-input spectrum, cycles/px."""
        return np.hypot(*self.frequencies())


def window(size: int, shift: float) -> NDArray[np.float64]:
    """w at the centres of `size` pixels, for a window centre `shift` px off the block's middle.

    From 32 px on w^2 = 1/2 + (150 cos a - 25 cos 3a + 3 cos 5a)/256, a = 2 pi x / size: it sums to 1 at half
    overlap (Princen & Bradley 1986) and is flat to sixth order at its ends. Of a pattern at .3 cycles/px
    3e-9 (64 px) and 4e-7 (32 px) of the energy leaks beyond the pixel Nyquist, where it would read as flicker;
    sin(pi/2 cos^2(pi x / size)) leaks 7e-8 and 2e-6. No window with that sum keeps below 3e-5 in 16 px: there
    w is a Kaiser window (Kaiser 1974, beta 10), with 5e-8.
    """
    x = np.arange(size) + 0.5 - size / 2 - shift
    inside = np.abs(x) < size / 2
    if size < _SMOOTH:
        return np.asarray(inside * np.i0(_BETA * np.sqrt(np.maximum(0.0, 1 - (2 * x / size) ** 2))) / np.i0(_BETA))
    angle = 2 * np.pi * x / size
    waves = 150 * np.cos(angle) - 25 * np.cos(3 * angle) + 3 * np.cos(5 * angle)
    return np.asarray(inside * np.sqrt(np.maximum(0.0, 0.5 + waves / 256)))


def split(offset: Offset) -> tuple[tuple[int, int], Offset]:
    """An offset (y, x) in px as whole pixels and the rest in -1/2..1/2."""
    whole = (int(np.ceil(offset[0] - 0.5)), int(np.ceil(offset[1] - 0.5)))
    return whole, (offset[0] - whole[0], offset[1] - whole[1])


def lay(
    shape: tuple[int, int], offsets: Sequence[Offset], mask: Callable[[int], Mask | None]
) -> tuple[list[Level], NDArray[np.float64]]:
    """Lay the tiles that stay inside the frame and wholly on covered pixels in every frame of a span.

    offsets: how far the surface has moved since the anchor frame, (y, x) px, frame by frame.
    mask: position in `offsets` -> where that frame [H, W] is covered (None: everywhere); read one at a time.
    Returns the levels that hold tiles, the largest first, and the summed w^2 of all tiles, [H, W], in the
    anchor frame.
    """
    steps = np.array([split(offset)[0] for offset in offsets])
    stands = _standing(shape, steps, mask)
    weight = np.zeros(shape)
    levels: list[Level] = []
    for index, size in enumerate(SIZES):
        allowed = stands[index].where.copy()
        y, x = np.ogrid[: allowed.shape[0], : allowed.shape[1]]
        centre = (y + stands[index].first[0] + size // 2, x + stands[index].first[1] + size // 2)
        for larger in range(index):
            allowed &= ~stands[larger].around(*centre, SIZES[larger])
        if levels and allowed.size:
            (top, *_), (left, *_) = (each.ravel() for each in centre)
            allowed &= weight[top : top + len(allowed), left : left + allowed.shape[1]] < _SPARSE
        if allowed.any():
            origin = _lattice(allowed, size // 2) + np.array(stands[index].first)
            levels.append(Level(size, origin, _apart(origin, size)))
            _add_weight(weight, levels[-1])
    return levels, weight


@dataclass(frozen=True)
class _Standing:
    """where: [h, w], true where a tile whose first pixel is `first` plus the index stays wholly covered."""

    first: tuple[int, int]
    where: Mask

    def around(self, y: NDArray[np.intp], x: NDArray[np.intp], size: int) -> Mask:
        """Whether a tile stands that is centred at (y, x), or as near to it as the frame lets it be."""
        if not self.where.size or self.where.all():
            return np.full(np.broadcast_shapes(y.shape, x.shape), bool(self.where.size))
        row, column = (
            np.clip(centre.ravel() - size // 2 - first, 0, length - 1)
            for centre, first, length in zip((y, x), self.first, self.where.shape, strict=True)
        )
        return self.where.take(row, axis=0).take(column, axis=1)


def _standing(shape: tuple[int, int], steps: NDArray[np.intp], mask: Callable[[int], Mask | None]) -> list[_Standing]:
    """For every size where tiles stay inside the frame and covered, for steps (y, x) of the surface in px."""
    import cv2  # heavy

    low, high = np.minimum(steps.min(axis=0), 0), np.maximum(steps.max(axis=0), 0)
    first = (int(-low[0]), int(-low[1]))
    room = [tuple(max(0, int(n)) for n in np.array(shape) + low - high - size + 1) for size in SIZES]
    stands = [_Standing(first, np.ones(extent, dtype=bool)) for extent in room]
    for index, (down, right) in enumerate(steps):
        covered = mask(index)
        if covered is None:
            continue
        for size, standing in zip(SIZES, stands, strict=True):
            height, width = standing.where.shape
            if height and width:
                whole = cv2.erode(covered.view(np.uint8), np.ones((size, size), np.uint8), anchor=(0, 0)).view(bool)
                top, left = first[0] + down, first[1] + right
                standing.where[...] &= whole[top : top + height, left : left + width]
    return stands


def _lattice(allowed: Mask, hop: int) -> NDArray[np.intp]:
    """Allowed places [n, 2] (y, x) of the lattice with this hop that has most of them, the central one at a tie."""
    height, width = allowed.shape
    padded = np.zeros((-(-height // hop) * hop, -(-width // hop) * hop), np.uint8)
    padded[:height, :width] = allowed
    # Down first, over rows as they lie.
    found = padded.reshape(len(padded) // hop, -1).sum(axis=0, dtype=np.uint16)
    found = found.reshape(hop, -1, hop).sum(axis=1, dtype=np.intp)
    off = [np.abs(np.arange(hop) - (length - 1) % hop / 2) / hop for length in (height, width)]
    y, x = np.unravel_index(np.argmax(found - (off[0][:, None] + off[1][None, :]) / 4), found.shape)
    places = np.argwhere(allowed[y::hop, x::hop])
    return np.asarray(places * hop + np.array([y, x]))


def _apart(origin: NDArray[np.intp], size: int) -> Mask:
    """Which tiles to sample: every second along both axes, thinned evenly to SAMPLE."""
    step = (origin - origin.min(axis=0)) // (size // 2)
    apart = np.flatnonzero((step % 2 == 0).all(axis=1))
    chosen = np.zeros(len(origin), dtype=bool)
    chosen[apart[np.linspace(0, len(apart) - 1, min(SAMPLE, len(apart))).round().astype(int)]] = True
    return chosen


def _add_weight(weight: NDArray[np.float64], level: Level) -> None:
    profile, rows = window(level.size, 0.0) ** 2, np.arange(len(weight))
    corners = level.origin.astype(np.int32, order="C")  # rising in y
    crossing = [np.searchsorted(corners[:, 0], rows - off, side="right") for off in (level.size, 0)]
    ranges = np.stack(crossing, axis=1).astype(np.int32)
    on_cpu(add_squares(), len(weight), [corners, ranges, profile[:, None] * profile[None, :], weight])
