"""`swimlab init-shot`."""

from pathlib import Path
from typing import Annotated

from cyclopts import Parameter

from swimlab.footage.draft import draft_shot
from swimlab.runs.files import write_text
from swimlab.runs.frames import FrameError

NAME = "shot.toml"


def init_shot_command(folder: Path, /, *, force: Annotated[bool, Parameter(negative="")] = False) -> int:
    """Write a shot file of the frames that a folder holds, with comments, to be gone through.

    What is a reference, motion, depth or mask is told by the names of files and folders; the rest are builds.

    Parameters
    ----------
    folder:
        Folder that holds frames, or folders of them; it gets shot.toml.
    force:
        Write over a shot.toml that is there.
    """
    if not folder.is_dir():
        raise FrameError(f"{folder}: is no folder; name one that holds frames, or folders of them")
    path = folder / NAME
    if path.exists() and not force:
        raise FrameError(f"{path}: is there already; remove it, or give --force")
    write_text(path, draft_shot(folder))
    print(path)
    return 0
