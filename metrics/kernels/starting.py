"""Warp is started quietly, with a kernel cache that can be written."""

import os
import tempfile
import warnings
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

import warp as wp

from metrics.kernels.making import made_once
from metrics.machine import user


@contextmanager
def _quiet_stderr() -> Iterator[None]:
    """Keep the driver's notices, which are written to file descriptor 2 from C, off the screen."""
    saved = os.dup(2)
    with Path(os.devnull).open("w") as sink:
        os.dup2(sink.fileno(), 2)
        try:
            yield
        finally:
            os.dup2(saved, 2)
            os.close(saved)


@made_once
def start_warp() -> Path:
    """Initialise Warp, quietly, with a kernel cache that can be written; return the cache's folder."""
    configured = os.environ.get("WARP_CACHE_PATH") or wp.config.kernel_cache_dir
    if configured is None:
        base = os.environ.get("XDG_CACHE_HOME") or os.path.expanduser("~/.cache")  # noqa: PTH111, no home is no error
        configured = str(Path(base) / "swimlab" / f"warp-{wp.__version__}")
    folder = Path(configured)
    if not _writable(folder):
        folder = Path(tempfile.gettempdir()) / f"swimlab-kernels-{user()}"
        warnings.warn(f"kernel cache {configured} cannot be written; using {folder}", RuntimeWarning, stacklevel=2)
        folder.mkdir(parents=True, exist_ok=True)
    wp.config.log_level = wp.LOG_WARNING
    wp.config.kernel_cache_dir = str(folder)
    with _quiet_stderr():
        wp.init()  # type: ignore[no-untyped-call]
    return folder


def _writable(folder: Path) -> bool:
    try:
        folder.mkdir(parents=True, exist_ok=True)
        with tempfile.TemporaryFile(dir=folder):
            return True
    except OSError:
        return False
