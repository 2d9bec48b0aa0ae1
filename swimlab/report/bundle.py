"""The pictures of a report in a folder: every frame of every technique.

Each is a script that hands its base64 over to the viewer. A page opened from file:// may load scripts, while it may
neither fetch files nor read the pixels of images beside it.
"""

import json
from pathlib import Path

from swimlab.report.clips import Clip, encode
from swimlab.report.recorded import ReportError, Run

PAGE = "index.html"
PICTURES = "pictures"


def write_pictures(run: Run, report: Path, place: int) -> Clip:
    """Write the whole frames of a run as scripts into the folder `report`/pictures/`place`."""
    clip = Clip(run, folder=f"{PICTURES}/{place}")
    (report / clip.folder).mkdir(parents=True)
    for frame in run.frames:
        step = encode(run, frame, None)
        for technique in run.techniques:
            name = f"{clip.folder}/{technique}.{frame:04d}.js"
            error = step.errors.get(technique, {}).get(frame)
            handed = ", ".join(json.dumps(part) for part in (name, step.pictures[technique][frame], error))
            (report / name).write_text(f"received({handed});\n", encoding="utf-8")
        clip.merge(Clip(run, sizes=step.sizes, compared=step.compared))
    return clip


def refuse_strange_folder(folder: Path) -> None:
    """Raise ReportError for a path at which there is something other than an earlier report folder."""
    if not folder.exists():
        return
    strange = sorted({path.name for path in folder.iterdir()} - {PAGE, PICTURES}) if folder.is_dir() else ["a file"]
    if strange:
        raise ReportError(f"{folder}: is no report folder ({strange[0]} is there); name another with --output")
