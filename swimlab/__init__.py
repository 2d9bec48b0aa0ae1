"""swimlab: render sequences under competing shading techniques and tell a stable error from a flickering one.

`sequences` says what is rendered, `metrics` measures frames, and this package renders, runs and reports. Heavy
libraries are imported where they are used, so that importing this package costs nothing.

For notebooks and scripts: `study` renders and measures a sequence, `open` opens a run folder, `measure_frames` measures
frames of your own, and `add_techniques` finds techniques in a folder of your own.
"""

from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from swimlab.notebook.footage import measure_frames
    from swimlab.notebook.study import open_run as open
    from swimlab.notebook.study import study
    from swimlab.render.catalogue import add_techniques
    from swimlab.runs.provenance import SWIMLAB as __version__  # noqa: N811

__all__ = ["__version__", "add_techniques", "measure_frames", "open", "study"]

_HOMES = {
    "__version__": ("swimlab.runs.provenance", "SWIMLAB"),
    "add_techniques": ("swimlab.render.catalogue", "add_techniques"),
    "measure_frames": ("swimlab.notebook.footage", "measure_frames"),
    "open": ("swimlab.notebook.study", "open_run"),
    "study": ("swimlab.notebook.study", "study"),
}


def __getattr__(name: str) -> Any:
    """Import what is asked for when it is asked for."""
    from importlib import import_module

    if name not in _HOMES:
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    module, attribute = _HOMES[name]
    return getattr(import_module(module), attribute)


def __dir__() -> list[str]:
    return sorted(__all__)
