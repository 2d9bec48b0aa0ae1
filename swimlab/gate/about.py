"""What in the frames each score is about: an error, what of it is static, or a change; and at which pixels."""

from collections.abc import Mapping, Sequence
from typing import Any, Literal, NamedTuple

import numpy as np

from metrics.bands import BANDS
from swimlab.report.places import worst_frames

LOOKED = 8
"""Frames that are looked at for the worst of a score whose values by frame are not known."""

Kind = Literal["error", "bias", "detail", "change", "own change"]
"""bias, detail: the static error's parts; own change: of the picture itself, whatever the reference does."""


class About(NamedTuple):
    """What a score is about. pixels: as the map of the frame names their class; "covered": all.

    keys: the values by frame that tell which frame is worst. own: whether they are of this very score.
    band: of distance; "": all.
    """

    kind: Kind
    pixels: str
    keys: tuple[str, ...] = ()
    own: bool = True
    band: str = ""


_PLACED = {
    "budget.mse": About("error", "measured", ("mse",)),
    "budget.bias": About("bias", "measured", own=False),
    "budget.detail": About("detail", "measured", own=False),
    "budget.flicker": About("change", "measured", ("change",)),
    "residual.flicker": About("own change", "measured", ("change",), own=False),
    "frame.mse": About("error", "covered", ("frame_mse",)),
    "edges.mse": About("error", "edges", ("edges_mse",)),
    "edges.flicker": About("change", "edges", ("edges_flicker",)),
    "new.mse": About("error", "new", ("new_mse",)),
}

_BY_SCALE = {"scale.rmse": "rmse", "scale.self_rmse": "self_rmse", "scale.mean_drift": "mean_drift"}
"""Scores of a run over scales, and the curve whose largest value each is about."""


def about(metric: str) -> About | None:
    """What a score is about; None for one that has no place in a frame, as a share, a spectrum or another's metric."""
    name, _, band = metric.rpartition(".")
    if band in BANDS and name in _PLACED:
        return _PLACED[name]._replace(own=False, band=band)
    return About("error", "covered") if metric == "scale.rmse" else _PLACED.get(metric)


def frames_of(what: About, rows: Sequence[Mapping[str, Any]], *, reference: bool) -> list[int]:
    """The frames to look at, the likeliest first: the worst alone where the rows by frame tell of this very score."""
    if not what.keys:  # static: in every frame alike
        paired = sorted(frame for frame, _ in worst_frames(rows, "change"))
        chosen = np.linspace(0, len(paired) - 1, min(LOOKED, len(paired))).round().astype(int)
        return [paired[index] for index in chosen]
    ranked = [frame for frame, _ in worst_frames(rows, *what.keys)]
    own = what.own or (what.kind == "own change" and not reference)
    return ranked[:1] if own else ranked[:LOOKED]


def worst_scale(metric: str, curve: Mapping[str, Sequence[float | None]], frames: Sequence[int]) -> int | None:
    """Of the frames of a run over scales the one that a score is about; None where that is not known."""
    scales, values = curve.get("scale", []), curve.get(_BY_SCALE.get(metric, ""), [])
    if len(values) != len(frames) or len(scales) != len(frames):
        return None
    known = [
        (abs(value), frame)
        for scale, value, frame in zip(scales, values, frames, strict=True)
        if value is not None and scale is not None and scale < 1
    ]
    return max(known)[1] if known else None
