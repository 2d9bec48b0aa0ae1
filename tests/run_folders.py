"""What is compared of two run folders: pixels and scores, whatever stands in headers and provenance."""

import json
from pathlib import Path
from typing import Any

import OpenImageIO as oiio  # noqa: N813


def pixels(folder: Path) -> dict[str, bytes]:
    """The decoded pixels of every frame beneath a folder."""
    return {str(path.relative_to(folder)): _decoded(path) for path in folder.rglob("[0-9]*.exr")}


def entries(scores: Path) -> list[dict[str, Any]]:
    """The scores of a scores.json, without when and where they and their pictures were made, and without their keys."""
    found = json.loads(scores.read_text(encoding="utf-8"))["sequences"]
    return [{name: value for name, value in entry.items() if name not in ("key", "rendered")} for entry in found]


def _decoded(path: Path) -> bytes:
    source = oiio.ImageInput.open(str(path))
    values = source.read_image(0, 0, 0, source.spec().nchannels, oiio.FLOAT)
    source.close()
    return values.tobytes()
