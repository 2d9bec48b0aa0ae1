"""`swimlab demo`."""

import json
from math import sqrt
from pathlib import Path
from typing import Annotated, Any

from cyclopts import Parameter

from swimlab.cli.options import Rendering
from swimlab.cli.study_command import study_command

SEQUENCE = "road-shift"
TECHNIQUES = "pixel-point,pixel-aniso,lod-hack,vmf,tsl"
SIZE = "320x180"
FRAMES = "0-15"


def demo_command(
    *,
    output: Annotated[Path, Parameter(name=["--output", "-o"])] = Path("runs/demo"),
    threads: int | None = None,
    force: Annotated[bool, Parameter(negative="")] = False,
    quiet: Annotated[bool, Parameter(name=["--quiet", "-q"], negative="")] = False,
) -> int:
    """Render, measure and report a small road in under a minute, and say what to look at.

    The same as a small 'swimlab study', of five techniques in 320x180 pixels and 16 frames.

    Parameters
    ----------
    output:
        Run folder to write.
    threads:
        Threads to render with (default: every core).
    force:
        Render everything again, over what the folder holds.
    quiet:
        Show no progress.
    """
    rendering = Rendering(frames=FRAMES, size=SIZE, threads=threads, force=force, quiet=quiet)
    code = study_command(SEQUENCE, techniques=TECHNIQUES, output=output, rendering=rendering)
    entries = json.loads((output / "scores.json").read_text(encoding="utf-8"))["sequences"]
    print(f"\nOpen {output / 'report.html'} in a browser. What to look at:")
    for sentence in what_to_look_at(entries):
        print(f"- {sentence}")
    return code


def what_to_look_at(entries: list[dict[str, Any]]) -> list[str]:
    """Three sentences on entries of scores.json: which sparkles most, which is most biased, which is nearest."""
    scores = {entry["technique"]: entry["scores"] for entry in entries}

    def rms(technique: str, part: str) -> float:
        return sqrt(scores[technique][f"budget.{part}"])

    sparkling = max(scores, key=lambda name: rms(name, "flicker"))
    biased = max(scores, key=lambda name: rms(name, "bias"))
    nearest = min(scores, key=lambda name: rms(name, "mse"))
    share = (rms(sparkling, "flicker") / rms(sparkling, "mse")) ** 2
    calm = rms(biased, "flicker") / rms(sparkling, "flicker")
    return [
        f"Play {sparkling}: it flickers most, {rms(sparkling, 'flicker'):.2f} rms, {share:.0%} of its squared error.",
        f"Flip {biased} against the reference: it flickers {calm:.0%} as much, and is the most biased: "
        f"{rms(biased, 'bias'):.2f} of its {rms(biased, 'mse'):.2f} rms error.",
        f"Flip {nearest} against the reference: it is the nearest to it, {rms(nearest, 'mse'):.2f} rms, of which "
        f"{rms(nearest, 'flicker'):.2f} is flicker.",
    ]
