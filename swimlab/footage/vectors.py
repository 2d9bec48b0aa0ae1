"""Motion vectors as files hold them: where they are known, and brought to the size of the frames."""

from collections.abc import Iterable
from concurrent.futures import ThreadPoolExecutor

import cv2
import numpy as np
from numpy.typing import NDArray
from scipy import ndimage

from metrics.machine import cores
from swimlab.footage.convention import Convention
from swimlab.footage.latest import Latest
from swimlab.footage.reader import Reader
from swimlab.footage.source import Box, Mask
from swimlab.runs.frames import FrameError, Image

Known = NDArray[np.bool_]

EDGE = 0.25
"""Neighbouring vectors that differ by more than this, px of the frames, are of two surfaces: no zoom is that steep."""


class Vectors:
    """Two channels of a file a frame.

    A vector is unknown where it is NaN or infinite, masked, or the pair that an engine leaves where it wrote none; the
    nearest known one stands in for it, so that no interpolation takes up what is not known.
    """

    def __init__(
        self,
        reader: Reader,
        part: int,
        channels: tuple[str, str],
        convention: Convention,
        *,
        size: tuple[int, int] | None = None,
        crop: Box | None = None,
        mask: Mask | None = None,
    ) -> None:
        """size: width and height of the frames; None: that of the vectors. crop: in the frames' px."""
        self.reader = reader
        self.size = size or reader.header.size
        self._surveyed: frozenset[int] = frozenset()
        self._unknown: frozenset[int] = frozenset()
        self._part = part
        self._channels = channels
        self._convention = convention
        self._crop = crop
        self._mask = mask
        self._at = Latest(self._resampled, 4)

    @property
    def ratio(self) -> NDArray[np.float32]:
        """Px of the frames to one of the vectors, (x, y)."""
        return np.divide(self.size, self.reader.header.size, dtype=np.float32)

    def stored(self, index: int) -> Image:
        """[H, W, 2] of the frames' size, cropped: values as stored, all finite.

        Raises FrameError naming the frame.
        """
        return self._at(index)[0]

    def known(self, index: int) -> Known:
        """[H, W] of the frames' size, cropped: where the vectors are known. Raises FrameError as `stored` does."""
        return self._at(index)[1]

    def survey(self, indices: Iterable[int]) -> dict[int, float]:
        """Share of the vectors that is unknown, by index, of the frames that have any.

        Raises FrameError for the first frame that cannot be read or of which none is known.
        """
        wanted = list(indices)
        with ThreadPoolExecutor(cores()) as pool:
            shares = dict(zip(wanted, pool.map(lambda index: 1 - self._read(index)[1].mean(), wanted), strict=True))
        found = {index: float(share) for index, share in shares.items() if share > 0}
        for index, share in found.items():
            if share == 1:
                raise FrameError(
                    f"{self.reader.label(index)}: none of its motion vectors is known: all are NaN, masked or not "
                    "written; mend the frame or its mask, or leave it out with --frames"
                )
        self._surveyed, self._unknown = frozenset(wanted), frozenset(found)
        return found

    def surveyed(self, index: int) -> bool:
        """Whether the last survey could read a frame."""
        return index in self._surveyed

    def whole(self, indices: Iterable[int]) -> bool:
        """Whether the last survey found all vectors known, in these frames too."""
        return not self._unknown and self._surveyed.issuperset(indices)

    def _read(self, index: int) -> tuple[Image, Known]:
        """Values [h, w, 2] as stored, and where they are known."""
        stored = self.reader.read(index, self._part, self._channels)
        width, height = self.reader.header.size
        if stored.shape[:2] != (height, width):
            raise FrameError(f"{self.reader.label(index)}: is not {width}x{height} px, as most frames are")
        known: Known = np.asarray(np.isfinite(stored).all(axis=2))
        if self._convention.unwritten is not None:
            known &= (stored != np.array(self._convention.unwritten, np.float32)).any(axis=2)
        if self._mask is not None:
            known &= self._mask.coverage(index) > 0
        return stored, known

    def _resampled(self, index: int) -> tuple[Image, Known]:
        stored, known = self._read(index)
        if not known.any():  # of a frame that only another reading of the vectors asks for
            stored = np.zeros_like(stored)
        elif not known.all():
            nearest = ndimage.distance_transform_edt(~known, return_distances=False, return_indices=True)
            stored = stored[tuple(nearest)]
        if self.size != self.reader.header.size:
            factors = np.abs(self._convention.factors(self.reader.header.size) * self.ratio)
            stored, known = resample(stored, known, self.size, edge=EDGE / factors)
        return (self._crop.cut(stored), self._crop.cut(known)) if self._crop else (stored, known)


def resample(field: Image, known: Known, size: tuple[int, int], *, edge: NDArray[np.float32]) -> tuple[Image, Known]:
    """Vectors [h, w, 2] at the pixel centres of a picture of another size (width, height), both over the same view.

    Linear within a surface, so that a zoom or a turn stays smooth; the nearest vector where the four around differ by
    more than `edge`, (x, y) in stored units: a blend of two surfaces' vectors is the motion of neither. known: [h, w].
    """
    rows, columns = (_places(new, old) for new, old in zip(size[::-1], field.shape[:2], strict=True))
    near = [np.rint(places).astype(np.intp) for places in (rows, columns)]
    smooth = _smooth(field, edge)[np.ix_(rows.astype(np.intp), columns.astype(np.intp))]
    found = np.asarray(cv2.resize(field, size, interpolation=cv2.INTER_LINEAR), np.float32)  # between pixel centres
    row, column = np.nonzero(~smooth)
    found[row, column] = field[near[0][row], near[1][column]]
    return found, known[np.ix_(*near)]


def _places(new: int, old: int) -> NDArray[np.float64]:
    """Where the centres of `new` pixels lie among those of `old` ones over the same length, as indices."""
    return np.clip((np.arange(new) + 0.5) * old / new - 0.5, 0, old - 1)


def _smooth(field: Image, edge: NDArray[np.float32]) -> Known:
    """[h, w]: whether a vector and its neighbours right and below differ by `edge` at most."""
    padded = np.pad(field, ((0, 1), (0, 1), (0, 0)), mode="edge")
    around = [padded[:-1, :-1], padded[:-1, 1:], padded[1:, :-1], padded[1:, 1:]]
    return np.asarray((np.maximum.reduce(around) - np.minimum.reduce(around) <= edge).all(axis=2))
