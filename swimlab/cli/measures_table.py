"""The times of measures in the terminal."""

from collections.abc import Sequence

from rich.table import Table

from swimlab.cli.terminal import print_whole
from swimlab.runs.provenance import provenance
from swimlab.studies.bench import MAIN, TRANSFORMS, Timing


def print_timings(timings: Sequence[Timing], clip: str) -> None:
    """Print a row for each group of measures. clip: what was measured, in words."""
    about = provenance("")
    table = Table("scores", title=f"{clip}, {about['machine']}, swimlab {about['swimlab']}", box=None)
    for column in ("frames/s", "slowest", "fastest"):
        table.add_column(column, justify="right")
    table.add_column("peak memory, MB", justify="right")
    for timing in timings:
        speeds = timing.frames_per_second, timing.slowest, timing.fastest
        table.add_row(timing.name, *(f"{speed:.2f}" for speed in speeds), f"{timing.peak_memory / 1e6:.0f}")
    speed = {timing.name: timing.frames_per_second for timing in timings}
    share = speed[", ".join(MAIN)] / speed[TRANSFORMS]
    table.caption_justify = "left"
    table.caption = (
        f"The limit is the transform of half-overlapping tiles, two pictures of three channels a frame: {share:.0%} of "
        f"the time of {', '.join(MAIN)}. With a vector a pixel frames are also unwarped, in spans of 16 frames or more."
    )
    print_whole(table)
