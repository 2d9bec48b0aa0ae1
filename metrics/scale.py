"""Scale independence: a picture rendered small should look like the large one seen from further away.

For scales from 1 down every picture is rendered at its own size and compared with the same technique's scale-1
picture, area-filtered to that size, and with the reference at that size; only over wholly covered pixels.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import csr_array

from metrics.clip import Clip, ClipError
from metrics.display import STANDARD, Display, Domain, to_domain
from metrics.measurement import Measurement, Metric

HIGHLIGHT = 95.0
"""Percentile of the scale-1 reference above which radiance is a highlight."""

# Upright strips that are left out in turn, for the standard errors (Efron & Stein 1981).
STRIPS = 8

_SOURCE = "area filter by exact pixel overlap"

SCORES = {
    "scale.rmse": Metric(
        "1",
        "lower",
        "rms difference to the reference at each scale over its rms, rms over the scales",
        _SOURCE,
        "sqrt(mean over scales of r_s^2), r_s = rms(test_s - reference_s) / rms(reference_s)",
    ),
    "scale.self_rmse": Metric(
        "1",
        "lower",
        "the same to the technique's own filtered scale-1 picture, below scale 1",
        _SOURCE,
        "sqrt(mean over scales of q_s^2), q_s = rms(test_s - filtered_s) / rms(filtered_s)",
    ),
    "scale.mean_drift": Metric(
        "%",
        "lower",
        "largest change of mean radiance against the own filtered scale-1 picture",
        _SOURCE,
        "max over scales of |d_s|, d_s = 100 (mean(test_s) / mean(filtered_s) - 1)",
    ),
    "scale.highlight": Metric(
        "1",
        "information",
        f"energy above the {HIGHLIGHT:g}th percentile over that of the own filtered scale-1 picture; the scale "
        "furthest from 1",
        _SOURCE,
        f"sum of test_s^2 above b, over sum of filtered_s^2 above b; b the {HIGHLIGHT:g}th percentile at scale 1",
    ),
    "scale.slope": Metric(
        "% per octave",
        "information",
        "least-squares slope of the mean's drift against log2 of the scale",
        _SOURCE,
        "sum (x - mean x) d_s / sum (x - mean x)^2, x = log2(s)",
    ),
}


def area_filter(image: NDArray[np.float64], height: int, width: int) -> NDArray[np.float64]:
    """Mean of a picture [..., H, W] over each of height x width equal cells, by exact overlap of areas."""
    rows = np.moveaxis(image, -2, 0)
    lower = (_overlap(height, len(rows)) @ rows.reshape(len(rows), -1)).reshape(height, *rows.shape[1:])
    columns = np.moveaxis(lower, -1, 0)
    small = _overlap(width, len(columns)) @ columns.reshape(len(columns), -1)
    return np.moveaxis(small.reshape(width, *columns.shape[1:]), (0, 1), (-1, -2))


def measure_scales(
    test: Sequence[Clip],
    reference: Sequence[Clip] | None,
    scales: Sequence[float],
    *,
    domain: Domain = "linear",
    display: Display = STANDARD,
) -> Measurement:
    """Compare pictures of one view at several scales.

    test, reference: one-frame clips, one a scale, each with its own size and coverage; reference may be None.
    scales: size factors, the first 1, all above 0.
    domain: "linear" radiance, or "display": codes in 0..1 as `display` makes them, of all pictures.
    Raises ClipError if lists differ in length, the first scale is not 1, or a picture is not as large as its
    reference.
    """
    _check(test, reference, scales)
    own = to_domain(test[0].image(0), domain, display)
    seen = _whole(test[0])
    guide = own if reference is None else to_domain(reference[0].image(0), domain, display)
    bright = float(np.percentile(guide[:, seen], HIGHLIGHT)) if seen.any() else 0.0
    views = []
    for index, scale in enumerate(scales):
        picture = to_domain(test[index].image(0), domain, display, index)
        filtered = area_filter(own, *picture.shape[1:])
        whole = _whole(test[index]) & (area_filter(seen.astype(float), *picture.shape[1:]) > 1 - 1e-9)
        exact = None if reference is None else to_domain(reference[index].image(0), domain, display, index)
        views.append(View(float(scale), picture, filtered, exact, whole))
    found = _report(_rows(views, bright), has_reference=reference is not None)
    left = _without_strips(views, bright)
    for name, value in found.scores.items():
        if all(name in scores for scores in left):
            found.put(name, value, "", replicates=[scores[name] for scores in left])
    found.note_unknown_errors()
    return found


@dataclass(frozen=True)
class View:
    """Pictures [3, H, W] at one scale: the test's, its filtered scale-1 picture, the reference's; and where to look."""

    scale: float
    picture: NDArray[np.float64]
    filtered: NDArray[np.float64]
    exact: NDArray[np.float64] | None
    whole: NDArray[np.bool_]

    def without(self, strip: int) -> "View":
        """Without one of STRIPS upright strips."""
        width = self.whole.shape[1]
        kept = (np.arange(width) + 0.5) * STRIPS // width != strip
        return replace(self, whole=self.whole & kept)


def _rows(views: Sequence[View], bright: float) -> list[dict[str, float]]:
    """Figures of every scale that has something to look at."""
    rows = []
    for view in views:
        if view.whole.any():
            picture, filtered = view.picture[:, view.whole], view.filtered[:, view.whole]
            row = {"scale": view.scale} | _compare(picture, filtered, bright)
            if view.exact is not None:
                row["rmse"] = _relative_rmse(picture, view.exact[:, view.whole])
            rows.append(row)
    return rows


def _without_strips(views: Sequence[View], bright: float) -> list[dict[str, float]]:
    """The scores with one upright strip of the picture left out at a time."""
    has_reference = views[0].exact is not None
    return [
        _report(_rows([view.without(strip) for view in views], bright), has_reference=has_reference).scores
        for strip in range(STRIPS)
    ]


def _check(test: Sequence[Clip], reference: Sequence[Clip] | None, scales: Sequence[float]) -> None:
    if len(test) != len(scales) or (reference is not None and len(reference) != len(scales)):
        raise ClipError("a scale run needs one picture of the test, and of the reference, for every scale")
    if not scales or abs(scales[0] - 1) > 1e-9 or min(scales) <= 0:
        raise ClipError(f"the scales are {list(scales)}; they must start at 1 and stay above 0")
    for index, clip in enumerate(reference or ()):
        if clip.shape != test[index].shape:
            raise ClipError(
                f"at scale {scales[index]:g} the test is {test[index].shape[::-1]} px and the reference "
                f"{clip.shape[::-1]} px; render both at one size"
            )


def _whole(clip: Clip) -> NDArray[np.bool_]:
    covered = clip.covered(0)
    return np.ones(clip.shape, dtype=bool) if covered is None else covered


def _compare(picture: NDArray[np.float64], own: NDArray[np.float64], bright: float) -> dict[str, float]:
    """Figures of covered pixels [3, n] against the own filtered picture's; a figure without a base is left out."""
    row = {"self_rmse": _relative_rmse(picture, own)}
    if own.mean() != 0:
        row["mean_drift"] = 100 * float(picture.mean() / own.mean() - 1)
    base = float(np.sum(own[own > bright] ** 2))
    if base > 0:
        row["highlight"] = float(np.sum(picture[picture > bright] ** 2)) / base
    return row


def _relative_rmse(picture: NDArray[np.float64], exact: NDArray[np.float64]) -> float:
    rms = float(np.sqrt(np.mean(exact**2)))
    difference = float(np.sqrt(np.mean((picture - exact) ** 2)))
    return difference / rms if rms > 0 else difference


def _report(rows: list[dict[str, float]], *, has_reference: bool) -> Measurement:
    found = Measurement()
    keys = ["scale", "self_rmse", "mean_drift", "highlight"] + (["rmse"] if has_reference else [])
    found.curves["scale"] = {key: [row.get(key) for row in rows] for key in keys}
    smaller = [row for row in rows if row["scale"] < 1]
    few = "no smaller scale has wholly covered pixels"
    errors = [row["rmse"] for row in smaller if "rmse" in row]
    found.put("scale.rmse", _rms(errors), few if has_reference else "needs a reference")
    found.put("scale.self_rmse", _rms([row["self_rmse"] for row in smaller]), few)
    drifts = [row["mean_drift"] for row in smaller if "mean_drift" in row]
    black = "the scale-1 picture is black" if smaller else few
    found.put("scale.mean_drift", max(map(abs, drifts), default=None), black)
    lights = [row["highlight"] for row in smaller if "highlight" in row]
    furthest = max(lights, key=lambda ratio: abs(np.log2(max(ratio, 1e-9))), default=None)
    found.put("scale.highlight", furthest, "the filtered scale-1 picture has no highlight" if smaller else few)
    points = [(np.log2(row["scale"]), row["mean_drift"]) for row in rows if "mean_drift" in row]
    octaves, values = np.array(points).T if len(points) > 1 else (np.zeros(2), np.zeros(2))
    away = octaves - octaves.mean()
    spread = float(away @ away)
    found.put("scale.slope", float(away @ values) / spread if spread > 0 else None, "needs two scales")
    return found


def _rms(values: list[float]) -> float | None:
    return float(np.sqrt(np.mean(np.square(values)))) if values else None


def _overlap(cells: int, pixels: int) -> csr_array:
    """[cells, pixels], the share of each cell that each pixel takes; rows sum to 1."""
    edges = np.arange(cells + 1)[:, None] * (pixels / cells)
    below = np.clip(edges - np.arange(pixels)[None, :], 0.0, 1.0)
    return csr_array(np.diff(below, axis=0) * (cells / pixels))
