"""The columns of a table of scores, in the terminal, in notebooks and in the report: one heading for one score."""

from math import sqrt

from metrics import METRICS

COLUMNS = {
    "rms error": ("budget.mse", sqrt),
    "floor": ("budget.floor", sqrt),
    "bias": ("budget.bias", sqrt),
    "detail": ("budget.detail", sqrt),
    "flicker": ("budget.flicker", sqrt),
    "measured": ("measured.fraction", float),
    "edges": ("edges.mse", sqrt),
    "edge flicker": ("edges.flicker", sqrt),
    "new": ("new.mse", sqrt),
    "frame": ("frame.mse", sqrt),
    "residual": ("residual.flicker", sqrt),
    "reference's residual": ("residual.flicker.reference", sqrt),
    "visible flicker": ("visible.flicker", float),
    "quantisation": ("quantisation.floor", sqrt),
    "on plane": ("plane.on", float),
    "order 1": ("plane.order1", float),
    "order 2": ("plane.order2", float),
    "off plane": ("plane.off", float),
    "scale rmse": ("scale.rmse", float),
    "self rmse": ("scale.self_rmse", float),
    "mean drift %": ("scale.mean_drift", float),
    "highlight": ("scale.highlight", float),
    "slope %/octave": ("scale.slope", float),
    "FLIP": ("flip.mean", float),
    "FLIP (oiio)": ("flip-oiio.mean", float),
    "JOD": ("vdp.jod", float),
    "VMAF": ("vmaf.mean", float),
}
"""Heading -> the score behind it and how it is shown; squared radiance is shown as its root, as radiance."""

HIGHER, NEITHER = "↑", "·"
MARKS = f"lower is better but where {HIGHER} says higher and {NEITHER} neither"
"""What the marks behind headings mean."""

UPWARDS = {"vdp.jod", "vmaf.mean"}
"""Scores of peers of which more is better; METRICS knows it of ours."""


def marked(heading: str) -> str:
    """A heading of COLUMNS with the mark of which direction is better, if it is not lower."""
    score = COLUMNS[heading][0]
    better = METRICS[score].better if score in METRICS else "higher" if score in UPWARDS else "lower"
    return heading + {"higher": f"\N{NO-BREAK SPACE}{HIGHER}", "information": f"\N{NO-BREAK SPACE}{NEITHER}"}.get(
        better, ""
    )


def roots(headings: list[str]) -> str:
    """Which scores the roots among some columns are of, in a sentence; empty if there are none."""
    shown = [f"{heading} of {COLUMNS[heading][0]}" for heading in headings if COLUMNS[heading][1] is sqrt]
    return (
        f"Roots of scores: {', '.join(shown)}; a gate's limits are for the scores themselves, in squared radiance."
        if shown
        else ""
    )
