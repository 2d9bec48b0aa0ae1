"""Motion vectors of frames that a clip skips: they are there beside the others, and motion is composed over them."""

from collections.abc import Sequence
from dataclasses import replace
from itertools import pairwise

from swimlab.footage.pattern import Files, find_files, frame_range, without_range
from swimlab.footage.reader import ImageReader, Reader


def find_vectors(name: str, *, frames: str | None = None) -> Files:
    """As `find_files`, with the files of the frames that are skipped, where there is one of them at least.

    Those of them that are not there are among the missing.
    """
    chosen = find_files(name, frames=frames)
    between = sorted({*range(chosen.numbers[0], chosen.numbers[-1] + 1)} - {*chosen.numbers})
    if not between:
        return chosen
    span = find_files(without_range(chosen.name), frames=f"{chosen.numbers[0]}-{chosen.numbers[-1]}")
    return replace(span, name=chosen.name) if {*between} - {*span.missing} else chosen


def with_between(reader: Reader, numbers: Sequence[int], *, frames: str | None) -> tuple[Reader, list[int]]:
    """Vectors of the frames `numbers` and of those between them, where such are there; and the place of each frame.

    reader: the vectors of the frames alone, as many; it is returned as it is where its numbers skip others than the
    frames' do. frames: as it was opened with.
    """
    alone = list(range(len(numbers)))
    if _steps(reader.numbers) != _steps(numbers):
        return reader, alone
    whole = find_vectors(reader.name, frames=frames)
    if whole.numbers == reader.numbers:
        return reader, alone
    return ImageReader(whole), [number - whole.numbers[0] for number in reader.numbers]


def lacking_between(numbers: Sequence[int], places: Sequence[int]) -> str:
    """What to say where frames are skipped and no vectors between them are there; empty where all is there.

    places: of the frames among the vectors.
    """
    skipped = sorted({*range(numbers[0], numbers[-1] + 1)} - {*numbers})
    if not skipped or places[-1] - places[0] > len(places) - 1:
        return ""
    return (
        f"frames are skipped ({frame_range(skipped)}), of which there are no motion vectors: those that are there are "
        "taken to reach back to the frame measured before; if they reach back by one frame, write the vectors of every "
        "frame beside them, as a factor is right for steady motion only"
    )


def _steps(numbers: Sequence[int]) -> list[int]:
    return [after - before for before, after in pairwise(numbers)]
