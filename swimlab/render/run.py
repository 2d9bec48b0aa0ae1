"""Rendering a plan into a run folder: resumable, and refused where the folder holds something else."""

import json
from collections.abc import Callable, Iterable
from pathlib import Path
from statistics import median

from metrics.kernels.launch import Launcher
from swimlab.render.catalogue import own_code, techniques
from swimlab.render.plan import Plan
from swimlab.render.renderer import Rendered, Renderer, rms_error
from swimlab.runs.files import clear_leftovers
from swimlab.runs.frames import COLOUR, frame_path, read_channels, read_frame
from swimlab.runs.provenance import moment, provenance
from swimlab.runs.record import ERROR, GEOMETRY, REFERENCE, Record, RunError
from swimlab.runs.whole import is_whole


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
    """Render every picture of the plan that the run folder does not hold whole; `force` renders all of them again.

    `advance` is called with a technique's name after each of its pictures. Raises RunError where the folder holds a run
    of another settings hash, MapError for maps that cannot be used. An interrupt loses nothing that was written.
    """
    clear_leftovers(run)
    there = None if force else finished(plan, run)
    if there is not None:
        for name in plan.techniques * len(plan.frames):
            advance(name)
        return there
    with Launcher(threads=threads, device=device) as launcher:
        renderer = Renderer(plan, launcher, digest=plan.digest())
        record = open_record(plan, run, force=force, command=command)
        record.write(run)
        rendered: dict[str, list[Rendered]] = {name: [] for name in plan.techniques}
        try:
            for frame in plan.frames:
                shot = renderer.shot(frame)
                if force or not is_whole(run, GEOMETRY, frame, shot.view.height):
                    renderer.write_geometry(shot, run)
                for name in plan.techniques:
                    if force or not is_whole(run, name, frame, shot.view.height):
                        picture = renderer.write_picture(shot, name, run)
                        rendered[name].append(picture)
                        if picture.rms_error is not None:
                            record.reference_rms_error[str(frame)] = picture.rms_error
                    elif name == REFERENCE:
                        _recall_error(run, frame, record)
                    record.techniques = _with(record.techniques, name, techniques())
                    advance(name)
                record.frames = sorted({*record.frames, frame})
        finally:
            record.times |= {
                name: {
                    "ms_per_frame": median(picture.ms for picture in pictures),
                    "shaded_per_frame": median(picture.shaded for picture in pictures),
                    "frames": len(pictures),
                }
                for name, pictures in rendered.items()
                if pictures
            }
            record.write(run)
    return record


def finished(plan: Plan, run: Path) -> Record | None:
    """The folder's record where it holds all of the plan as it is: there is nothing to render, nor to write.

    Raises RunError as `earlier_record` does.
    """
    record = earlier_record(plan, run, force=False)
    if record is None or outdated(plan, record) or record.sequence != json.loads(json.dumps(plan.sequence_in_full())):
        return None
    if set(plan.techniques) - set(record.techniques) or set(plan.frames) - set(record.frames):
        return None
    if REFERENCE in plan.techniques and {str(frame) for frame in plan.frames} - set(record.reference_rms_error):
        return None
    return None if lacking(plan, run, (GEOMETRY, *plan.techniques), plan.frames) else record


def open_record(plan: Plan, run: Path, *, force: bool, command: str) -> Record:
    """The record to continue: the folder's own where its settings are the same, else a new one.

    Raises RunError where the folder holds other settings; with `force` their pictures are removed instead. Pictures of
    your own techniques whose code has changed since are always removed.
    """
    before = earlier_record(plan, run, force=force)
    if before is None:
        record = Record(
            sequence={},
            settings={"samples": plan.samples, "half": plan.half},
            hash=plan.digest(),
            uniform_velocity=plan.sequence.motion.uniform_velocity,
            resizes=plan.sequence.motion.resizes,
            provenance={},
        )
        _remove_pictures(run, [*techniques(), GEOMETRY, ERROR])
        anew = set(plan.techniques)
    else:
        record, stale = before, outdated(plan, before)
        _remove_pictures(run, stale)
        anew = {*before.techniques, *plan.techniques} if force else _rendered_anew(plan, run, before)
        record.techniques = [name for name in before.techniques if name not in stale]
        record.times = {name: times for name, times in before.times.items() if name not in stale}
    record.sequence, record.provenance = plan.sequence_in_full(), provenance(command)
    record.rendered |= dict.fromkeys(sorted(anew), moment())
    record.code |= {name: code for name, code in own_code().items() if name in plan.techniques}
    return record


def earlier_record(plan: Plan, run: Path, *, force: bool) -> Record | None:
    """The record of a folder that holds a run of the plan's settings; None where it holds none.

    Raises RunError where it holds one of other settings or a broken one; with `force` None.
    """
    if not (run / "run.json").exists():
        return None
    try:
        before = Record.read(run)
    except RunError:
        if force:
            return None
        raise
    if before.hash == plan.digest():
        return before
    if force:
        return None
    raise RunError(
        f"{run}: holds a run of other settings (hash {before.hash}, now {plan.digest()}); "
        "choose another folder with -o, or write over it with --force"
    )


def lacking(plan: Plan, run: Path, names: Iterable[str], frames: Iterable[int]) -> list[tuple[str, int]]:
    """Of some techniques, or the geometry, and frames those (name, frame) that the run folder does not hold whole."""
    heights = {frame: plan.sequence.view(frame).height for frame in frames}
    return [(name, frame) for name in names for frame in heights if not is_whole(run, name, frame, heights[frame])]


def _rendered_anew(plan: Plan, run: Path, before: Record) -> set[str]:
    """The techniques of which scores may be that are older than the pictures will be: all that was there and is not."""
    there = [name for name in (GEOMETRY, *before.techniques) if name in (GEOMETRY, *plan.techniques)]
    lost = {name for name, _ in lacking(plan, run, there, [frame for frame in before.frames if frame in plan.frames])}
    shared = set(before.techniques) if lost & {GEOMETRY, REFERENCE} else set()
    return shared | (lost - {GEOMETRY}) | (set(plan.techniques) - set(before.techniques))


def outdated(plan: Plan, record: Record) -> list[str]:
    """Your own techniques in the plan whose pictures in the run were rendered by other code."""
    own = own_code()
    return [name for name in plan.techniques if name in own and record.code.get(name) != own[name]]


def _remove_pictures(run: Path, folders: Iterable[str]) -> None:
    for folder in folders:
        for path in (run / folder).glob("[0-9]*.exr"):
            path.unlink()


def _recall_error(run: Path, frame: int, record: Record) -> None:
    """Note the error of a reference that an earlier call wrote, where that call was killed before it could."""
    path = frame_path(run, ERROR, frame)
    if str(frame) not in record.reference_rms_error and path.exists():
        error = read_channels(path, COLOUR)
        record.reference_rms_error[str(frame)] = rms_error(read_frame(frame_path(run, REFERENCE, frame)), error)


def _with(names: list[str], name: str, order: Iterable[str]) -> list[str]:
    return [known for known in order if known in {*names, name}]
