"""Which pictures of a run are there, and whole."""

from pathlib import Path

from swimlab.runs.frames import COLOUR, FrameError, frame_path, read_channels
from swimlab.runs.frames import GEOMETRY as GEOMETRY_CHANNELS
from swimlab.runs.record import ERROR, GEOMETRY, REFERENCE


def is_whole(run: Path, name: str, frame: int, height: int) -> bool:
    """Whether a run holds a frame of a technique or of the geometry to its last row; of the reference with its error.

    height: in px. A file is written from the top, so one that was cut off lacks its end. Of the rest nothing is read.
    """
    folders = (REFERENCE, ERROR) if name == REFERENCE else (name,)
    return all(_ends_well(frame_path(run, folder, frame), folder, height) for folder in folders)


def _ends_well(path: Path, folder: str, height: int) -> bool:
    if not path.is_file():
        return False
    try:
        read_channels(path, GEOMETRY_CHANNELS if folder == GEOMETRY else COLOUR, rows=(height - 1, height))
    except FrameError:
        return False
    return True
