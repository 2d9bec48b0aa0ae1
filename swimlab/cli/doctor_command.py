"""`swimlab doctor`."""

import json
from collections.abc import Callable
from typing import Annotated

from cyclopts import Parameter

CHECKS: dict[str, Callable[[], str]] = {}


def doctor_command(*, json_output: Annotated[bool, Parameter(name="--json", negative="")] = False) -> int:
    """Check that everything swimlab needs works on this machine. Exit code 2 if anything fails.

    Parameters
    ----------
    json_output:
        Print the checks as JSON.
    """
    found = []
    for name, check in CHECKS.items():
        try:
            found.append({"check": name, "ok": True, "said": check()})
        except Exception as error:  # every failure is a finding
            found.append({"check": name, "ok": False, "said": f"{type(error).__name__}: {error}"})
        if not json_output:
            print("{} {check}: {said}".format("ok   " if found[-1]["ok"] else "FAIL ", **found[-1]))
    if json_output:
        print(json.dumps(found, indent=1))
    return 0 if all(each["ok"] for each in found) else 2


def _check(name: str) -> Callable[[Callable[[], str]], Callable[[], str]]:
    def register(function: Callable[[], str]) -> Callable[[], str]:
        CHECKS[name] = function
        return function

    return register


@_check("system")
def _system() -> str:
    from metrics import machine

    return f"{machine.system()}, Python {machine.python()}, {machine.memory() / 1e9:.1f} GB of memory"


@_check("cores")
def _cores() -> str:
    from metrics import machine

    bounds = {name: count for name, count in machine.core_limits().items() if count is not None}
    return f"{machine.cores()} ({', '.join(f'{name} {count}' for name, count in bounds.items())})"


@_check("encoding")
def _encoding() -> str:
    import locale
    import sys

    streams = {name: getattr(sys, name).encoding for name in ("stdout", "stderr")}
    said = ", ".join(f"{name} {encoding}" for name, encoding in streams.items())
    return (
        f"{said}, locale {locale.getencoding()}, file names {sys.getfilesystemencoding()}; files are written in UTF-8"
    )


@_check("kernel cache")
def _cache() -> str:
    from metrics.kernels.starting import start_warp

    return f"{start_warp()} can be written"


@_check("render a picture")
def _render() -> str:
    import time

    from metrics.kernels.launch import Launcher
    from sequences import load
    from swimlab.render.catalogue import model_of, techniques
    from swimlab.render.material import load_material
    from swimlab.render.shot import Shot

    sequence = load("road-shift").with_changes(size=(64, 36))
    technique = techniques()["pixel-aniso"]
    with Launcher() as launcher:
        started = time.perf_counter()
        shot = Shot(sequence, 0, load_material(sequence, launcher), model_of(sequence), 4, launcher)
        mean = float(technique.render(shot, technique.settings()).rgba[..., :3].mean())
    if not mean > 0:
        raise RuntimeError("the picture came out black")
    return f"mean radiance {mean:.3f}, {time.perf_counter() - started:.1f} s with compilation"


@_check("write and read an EXR file")
def _files() -> str:
    import tempfile
    from pathlib import Path

    import numpy as np
    import OpenImageIO as oiio  # noqa: N813

    from swimlab.runs.frames import read_frame, write_frame

    picture = np.random.default_rng(0).random((8, 8, 4), np.float32)
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "0000.exr"
        write_frame(path, picture, half=False, metadata={})
        if not np.array_equal(read_frame(path), picture):
            raise RuntimeError("what was read is not what was written")
    return f"OpenImageIO {oiio.VERSION_STRING}"


@_check("temporary space")
def _space() -> str:
    import shutil

    free = shutil.disk_usage(".").free / 1e9
    if free < 1:
        raise RuntimeError(f"{free:.1f} GB free here; a study writes up to 0.6 GB")
    return f"{free:.0f} GB free here"
