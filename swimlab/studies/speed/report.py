"""The report on speed against error: the studies at work, and the page made of them."""

from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from metrics.kernels.launch import Launcher
from metrics.machine import processor
from sequences import load
from swimlab.render.material import load_material
from swimlab.runs.provenance import provenance
from swimlab.studies.page import tables, write_page
from swimlab.studies.speed import growth
from swimlab.studies.speed import settings as speed
from swimlab.studies.speed.peers import read_peers
from swimlab.studies.turns import share

NAME = "speed-against-error"
SEQUENCE = "road-shift"


@dataclass(frozen=True)
class Effort:
    """How much is rendered: pixels, frames, samples of the reference, rounds of timing, and of timing growth."""

    size: tuple[int, int] = (640, 360)
    frames: int = 8
    samples: int = 256
    rounds: int = 15
    growth_rounds: int = 5


def steps() -> int:
    """How often `advance` is called."""
    return len(speed.candidates()) + 3


def write_report(
    folder: Path,
    effort: Effort,
    *,
    peers: Path | None = None,
    threads: int | None = None,
    command: str = "",
    advance: Callable[[str], None] = lambda _: None,
) -> dict[str, Any]:
    """Write FOLDER/speed-against-error.md and its charts; the numbers of its tables with their provenance.

    peers: JSON of a comparison with other renderers, to have a section on it. `advance` is called `steps()` times with
    a word on what is done. Raises RunError where that JSON cannot be read.
    """
    against = [read_peers(peers)] if peers else []
    sequence = load(SEQUENCE).with_changes(size=effort.size)
    with Launcher(threads=threads) as launcher:
        used = launcher.threads
        material = load_material(sequence, launcher, twisted=False)
        found = speed.speed_study(
            sequence,
            launcher,
            material,
            frames=effort.frames,
            samples=effort.samples,
            rounds=effort.rounds,
            advance=advance,
        )
        curves = growth.growth_study(sequence, launcher, material, rounds=effort.growth_rounds)
        advance("growth")
    got = share((row.times for row in found.rows), used)
    size = "{}x{}".format(*effort.size)
    shown = f"`{SEQUENCE}` at {size}, {effort.frames} frames, of which the road covers {found.covered:,.0f} pixels."
    sections = [
        *speed.sections(found, about=shown),
        growth.section(curves, about=f"`{SEQUENCE}`, at {size} where pixels do not grow."),
        *against,
    ]
    about = provenance(command)
    opening = (
        "A number of milliseconds says nothing without its error, nor an error without its milliseconds. Here every "
        "technique is rendered at several settings on one machine, timed in turns in one run, and measured against "
        "one supersampled reference.\n\n"
        f"Made by `{command or 'swimlab bench speed-error'}` on {about['date']}: {processor()}, {about['machine']}, "
        f"{used} threads, swimlab {about['swimlab']}, Warp {about['warp']}, NumPy {about['numpy']}, Python "
        f"{about['python']}. The reference has {effort.samples} samples a pixel. Times are of one frame by kernels "
        f"that are compiled and maps that are in memory, medians and quartiles of {effort.rounds} rounds in which "
        f"every setting takes its turn; files are not written. While they were timed they had {got:.0%} of what "
        f"{used} cores can give: the less, the more did other programs disturb the times by the clock."
    )
    write_page(folder / f"{NAME}.md", "Speed against error", opening, sections)
    return {"provenance": about, "tables": tables(sections)}
