"""Rendering a plan into a run folder: resumable, and refused where the folder holds something else."""

import time
from collections.abc import Callable, Iterable
from pathlib import Path
from statistics import median

import numpy as np

from sequences import Sequence
from swimlab import __version__
from swimlab.catalogue import model_of, techniques
from swimlab.frames import (
    COLOUR,
    FrameError,
    Image,
    frame_path,
    read_channels,
    read_frame,
    write_channels,
    write_frame,
    write_geometry,
)
from swimlab.geometry import describe_geometry
from swimlab.launch import Launcher
from swimlab.material import load_material
from swimlab.plan import Plan
from swimlab.record import REFERENCE, Record, RunError, provenance
from swimlab.shot import Shot
from swimlab.technique import Picture

GEOMETRY = "geometry"
ERROR = "error"
"""Folders of a run beside the techniques': the geometry, and the reference's standard error in channels R, G, B, A."""


def render_run(
    plan: Plan,
    run: Path,
    *,
    force: bool = False,
    threads: int | None = None,
    device: str = "cpu",
    command: str = "",
    advance: Callable[[str], None] = lambda _: None,
) -> Record:
    """Render every picture of the plan that the run folder does not hold yet; `force` renders all anew.

    `advance` is called with a technique's name after each of its pictures. Raises RunError where the folder holds a run
    of another settings hash, MapError for unfit maps. An interrupt loses nothing that was written.
    """
    metadata = {"swimlab:hash": plan.digest(), "swimlab:version": __version__}
    with Launcher(threads=threads, device=device) as launcher:
        model = model_of(plan.sequence)
        material = load_material(plan.sequence, launcher, twisted=model.anisotropic)
        record = open_record(plan, run, force=force, command=command)
        record.write(run)
        renders = {name: begin(plan.sequence, name) for name in plan.techniques}
        times: dict[str, list[float]] = {name: [] for name in plan.techniques}
        shaded: dict[str, list[int]] = {name: [] for name in plan.techniques}
        try:
            for frame in plan.frames:
                shot = Shot(plan.sequence, frame, material, model, plan.samples, launcher)
                path = frame_path(run, GEOMETRY, frame)
                if force or not path.exists():
                    write_geometry(path, describe_geometry(shot), metadata=metadata)
                for name in plan.techniques:
                    path = frame_path(run, name, frame)
                    if force or not path.exists():
                        started = time.perf_counter()
                        picture = renders[name](shot)
                        times[name].append(1e3 * (time.perf_counter() - started))
                        shaded[name].append(picture.shaded)
                        check_range(picture, name, frame, half=plan.half)
                        _keep_error(run, frame, picture, record, metadata)
                        write_frame(path, picture.rgba, half=plan.half, metadata=metadata)
                    elif name == REFERENCE:
                        _recall_error(run, frame, record)
                    record.techniques = _with(record.techniques, name, techniques())
                    advance(name)
                record.frames = sorted({*record.frames, frame})
        finally:
            record.times |= {
                name: {"ms_per_frame": median(ms), "shaded_per_frame": median(shaded[name]), "frames": len(ms)}
                for name, ms in times.items()
                if ms
            }
            record.write(run)
    return record


def open_record(plan: Plan, run: Path, *, force: bool, command: str) -> Record:
    """The record to go on with: the folder's own where it is of the same settings, else a new one.

    Raises RunError where the folder holds other settings; with `force` their pictures are removed instead.
    """
    fresh = Record(
        sequence=plan.sequence_in_full(),
        settings={"samples": plan.samples, "half": plan.half},
        hash=plan.digest(),
        uniform_velocity=plan.sequence.motion.uniform_velocity,
        resizes=plan.sequence.motion.resizes,
        provenance=provenance(command),
    )
    before = _earlier(run, force=force)
    if before is not None and before.hash == fresh.hash:
        before.provenance, before.sequence = fresh.provenance, fresh.sequence
        return before
    if before is not None and not force:
        raise RunError(
            f"{run}: holds a run of other settings (hash {before.hash}, now {fresh.hash}); "
            "choose another folder with -o, or write over it with --force"
        )
    for name in [*techniques(), GEOMETRY, ERROR]:
        for path in (run / name).glob("[0-9]*.exr"):
            path.unlink()
    return fresh


def check_complete(run: Path, names: Iterable[str], frames: Iterable[int]) -> None:
    """Raise FrameError naming the first picture that a run should hold and does not."""
    wanted = [frame_path(run, name, frame) for name in names for frame in frames]
    missing = [path for path in wanted if not path.is_file()]
    if missing:
        raise FrameError(f"{missing[0]}: is missing ({len(missing)} in all); give the render command again to resume")


def rms_error(rgba: Image, error: Image) -> float:
    """Root of the mean squared standard error over RGB and the wholly covered pixels; 0 where there is none."""
    covered = rgba[..., 3] == 1.0
    return float(np.sqrt(np.mean(np.square(error[covered][:, :3], dtype=np.float64)))) if covered.any() else 0.0


def begin(sequence: Sequence, name: str) -> Callable[[Shot], Picture]:
    """What renders the sequence's shots under a technique with the settings that the sequence gives it."""
    technique = techniques()[name]
    settings = technique.settings.model_validate(sequence.techniques.get(name, {}))
    render = technique.begin()
    return lambda shot: render(shot, settings)


def check_range(picture: Picture, name: str, frame: int, *, half: bool) -> None:
    """Raise RunError for a picture that holds a NaN or Inf, or, with `half`, more than a 16-bit float does."""
    brightest = float(np.abs(picture.rgba).max())
    if not np.isfinite(brightest):
        raise RunError(f"{name}, frame {frame}: came out with a NaN or Inf; look for extreme values in the maps")
    if half and brightest > float(np.finfo(np.float16).max):
        raise RunError(f"{name}, frame {frame}: is too bright for 16-bit floats (over 65504); render with --float")


def _earlier(run: Path, *, force: bool) -> Record | None:
    """The record that the folder holds, if any; `force` goes over a broken one."""
    if not (run / "run.json").exists():
        return None
    try:
        return Record.read(run)
    except RunError:
        if force:
            return None
        raise


def _keep_error(run: Path, frame: int, picture: Picture, record: Record, metadata: dict[str, str]) -> None:
    if picture.error is None:
        return
    write_channels(frame_path(run, ERROR, frame), picture.error, COLOUR, half=False, metadata=metadata)
    record.reference_rms_error[str(frame)] = rms_error(picture.rgba, picture.error)


def _recall_error(run: Path, frame: int, record: Record) -> None:
    """Note the error of a reference that an earlier call wrote, where that call was killed before it could."""
    path = frame_path(run, ERROR, frame)
    if str(frame) not in record.reference_rms_error and path.exists():
        error = read_channels(path, COLOUR)
        record.reference_rms_error[str(frame)] = rms_error(read_frame(frame_path(run, REFERENCE, frame)), error)


def _with(names: list[str], name: str, order: Iterable[str]) -> list[str]:
    return [known for known in order if known in {*names, name}]
