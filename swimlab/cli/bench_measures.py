"""`swimlab bench measures`."""

from typing import Annotated

from cyclopts import Parameter


def bench_measures(
    *,
    size: str = "1920x1080",
    frames: int = 32,
    threads: int | None = None,
    quiet: Annotated[bool, Parameter(name=["--quiet", "-q"], negative="")] = False,
) -> int:
    """Time the measures, in frames a second.

    Parameters
    ----------
    size:
        Size of the frames in pixels, WIDTHxHEIGHT.
    frames:
        Frames of the clip.
    threads:
        Threads to measure with (default: every core).
    quiet:
        Show no progress.
    """
    from rich.console import Console
    from rich.table import Table

    from swimlab.cli.options import parse_size
    from swimlab.cli.progress import progress
    from swimlab.runs.provenance import provenance
    from swimlab.runs.record import RunError
    from swimlab.studies.bench import MAIN, NAMES, TRANSFORMS, time_measures

    width, height = parse_size(size)
    if frames < 2 or min(width, height) < 64:
        raise RunError(f"--frames {frames} --size {size}: needs at least 2 frames of 64x64 px")
    with progress("timing measures", len(NAMES), quiet=quiet) as advance:
        timings = time_measures(width, height, frames, threads=threads, advance=advance)
    about = provenance("")
    table = Table(
        "scores", title=f"{frames} frames of {size}, {about['machine']}, swimlab {about['swimlab']}", box=None
    )
    table.add_column("frames/s", justify="right")
    table.add_column("peak memory, MB", justify="right")
    for timing in timings:
        table.add_row(timing.name, f"{timing.frames_per_second:.2f}", f"{timing.peak_memory / 1e6:.0f}")
    table.caption_justify = "left"
    speed = {timing.name: timing.frames_per_second for timing in timings}
    share = speed[", ".join(MAIN)] / speed[TRANSFORMS]
    table.caption = (
        f"The limit is the transform of half-overlapping tiles, two pictures of three channels a frame: {share:.0%} of "
        f"the time of {', '.join(MAIN)}. Reading files comes on top."
    )
    Console().print(table)
    return 0
