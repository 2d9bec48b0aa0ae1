"""What each frame of a clip shows and how it moved: read once, and held while there is room."""

from collections import OrderedDict
from dataclasses import dataclass
from functools import lru_cache
from threading import Lock

import numpy as np
from numpy.typing import NDArray
from scipy import ndimage

from metrics.clip import WHOLE, Clip

Mask = NDArray[np.bool_]
Field = NDArray[np.float32]


@dataclass(frozen=True)
class Surface:
    """What a frame shows: [H, W] where a surface covers pixels at all, and where wholly, and [H, W, 2] px (x, y), how
    it moved since the frame before.

    known: whether the motion is known, which that of the first frame need not be. uniform: whether it is one for all.
    """

    covered: Mask
    whole: Mask
    motion: Field
    known: bool
    uniform: bool = False

    @property
    def mask(self) -> Mask | None:
        """Where a surface covers pixels wholly; None if that is everywhere."""
        return None if self.whole.all() else self.whole

    @property
    def nbytes(self) -> int:
        """Memory that it takes."""
        masks = 0 if self.covered is self.whole else 2 * self.covered.nbytes
        return masks + (0 if self.uniform else self.motion.nbytes)


class Geometry:
    """The surfaces of a clip's frames; of those asked for last as many are held as fit in `room` bytes."""

    def __init__(self, clip: Clip, *, room: float) -> None:
        self.clip = clip
        self._room = room
        self._held: OrderedDict[int, Surface] = OrderedDict()
        self._lock = Lock()

    @property
    def shape(self) -> tuple[int, int]:
        """Height and width, px."""
        return self.clip.shape

    @property
    def count(self) -> int:
        """Number of frames."""
        return self.clip.count

    def surface(self, t: int) -> Surface:
        """What frame t shows. Raises ClipError naming the frame if its motion, coverage or depth is bad."""
        with self._lock:
            if t in self._held:
                self._held.move_to_end(t)
                return self._held[t]
            # Room is made before another is read: all that are asked for one after another take about as much.
            most = max((held.nbytes for held in self._held.values()), default=0)
            while self._held and sum(held.nbytes for held in self._held.values()) + most > self._room:
                self._held.popitem(last=False)
            self._held[t] = read_surface(self.clip, t)
            return self._held[t]


@lru_cache(maxsize=2)
def everywhere(shape: tuple[int, int]) -> Mask:
    """[H, W], all true: one for all frames that are covered wholly."""
    return np.ones(shape, dtype=bool)


def read_surface(clip: Clip, t: int) -> Surface:
    """What frame t of a clip shows, silhouettes included.

    A pixel that is covered in part, but not at its centre, takes the motion of the nearest one that is.
    """
    share = clip.share(t)
    covered = whole = everywhere(clip.shape)
    if share is not None:
        covered, whole = share > 0, share >= WHOLE
    motion = clip.moved(t)
    if not callable(clip.motion):
        return Surface(covered, whole, motion, known=True, uniform=True)
    depth = clip.distance(t)
    bare = covered if depth is None else covered & ~(depth > 0)
    if depth is not None and bare.any() and not bare[covered].all():
        _, (row, column) = ndimage.distance_transform_edt(~(depth > 0), return_indices=True)
        motion = motion.copy()
        motion[bare] = motion[row[bare], column[bare]]
    return Surface(covered, whole, motion, known=t > 0 or bool(motion.any()))
