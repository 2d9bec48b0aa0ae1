"""How a score changed, and whether that is more than chance."""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from math import copysign, erfc, inf, isfinite, sqrt
from statistics import mean, stdev
from typing import Any, Literal

from metrics import METRICS
from metrics.ratios import difference_error, reference_floor
from swimlab.runs.counting import counted
from swimlab.runs.entries import Entry, number
from swimlab.runs.shares import share

Verdict = Literal["same", "better", "worse", "changed", "unresolved", "unknown", "gone", "new"]

SIGMAS = 3.0
"""A change is said to be real beyond so many standard errors, if nothing else is said."""

ROUNDING = 1e-9
"""Values that agree within this share of themselves are the same: other versions of libraries round otherwise."""

BY_ERRORS = "standard errors"

FEWEST = 3
"""So many earlier runs tell by their spread what chance does."""


@dataclass(frozen=True)
class Change:
    """How a score changed. None stands for what there is not.

    before, after: the score. sigmas: the change in standard errors; infinite where the errors are 0. by: what they are
    taken from, "standard errors" or "spread of 5 runs". verdict: "changed" is a real change of a score of which neither
    direction is better; "unresolved" may be chance; "unknown" lacks a standard error. reason: why, where that is not
    plain. like: whether both were measured under the same settings, as far as they concern the technique.
    """

    sequence: str
    technique: str
    metric: str
    before: float | None
    after: float | None
    errors: tuple[float | None, float | None] = (None, None)
    sigmas: float | None = None
    by: str = BY_ERRORS
    verdict: Verdict = "unknown"
    reason: str = ""
    like: bool = True

    @property
    def absolute(self) -> float | None:
        """After less before."""
        return None if self.before is None or self.after is None else self.after - self.before

    @property
    def relative(self) -> float | None:
        """The change as a share of what was before; None where that is 0 or round-off."""
        return None if self.before is None or self.after is None else share(self.before, self.after)

    def as_json(self) -> dict[str, Any]:
        """Ready for JSON, which has no infinity: infinite sigmas are null."""
        metric = METRICS.get(self.metric)
        sigmas = self.sigmas if self.sigmas is not None and isfinite(self.sigmas) else None
        about = {"unit": metric.unit if metric else None, "better": direction(self.metric)}
        return {
            **vars(self),
            **about,
            "errors": list(self.errors),
            "sigmas": sigmas,
            "change": self.absolute,
            "share": self.relative,
        }


def direction(metric: str) -> str:
    """Which way a score is better: "lower", "higher" or "information"; the last for metrics of other projects."""
    return METRICS[metric].better if metric in METRICS else "information"


def change(before: Entry, after: Entry, metric: str, *, threshold: float = SIGMAS, like: bool = True) -> Change:
    """How a score changed between two measurements, in standard errors of the change (see `difference_error`).

    They say how far the change would move on another piece of the same kind of surface.
    """
    values = number(before.scores, metric), number(after.scores, metric)
    errors = number(before.errors, metric), number(after.errors, metric)
    found = Change(before.sequence, before.technique, metric, *values, errors=errors, like=like)
    if values[0] is None or values[1] is None:
        return _with(found, "gone" if values[1] is None else "new", reason=_why_absent(before, after, metric))
    difference = values[1] - values[0]
    if same(values[0], values[1]):
        return _with(found, "same", sigmas=0.0)
    error = difference_error(metric, vars(before), vars(after))
    if error is None or not isfinite(error):
        return _with(found, "unknown", reason="no standard error is known")
    sigmas = in_errors(difference, error)
    if abs(difference) <= reference_floor(metric, before.scores, after.scores):
        return _with(found, "unresolved", sigmas=sigmas, reason="within the reference's own error")
    return _with(found, _verdict(metric, difference, sigmas, threshold), sigmas=sigmas)


def change_in_history(earlier: Sequence[Entry], now: Entry, metric: str, *, threshold: float = SIGMAS) -> Change:
    """How a score changed since the last of the earlier measurements, of the same settings all.

    With three or more of them their spread shows the effect of chance: how far the score lies from their mean, as
    Student's t of n - 1 degrees of freedom, given as the number of standard errors that is as improbable. A change
    that goes against that distance is unresolved. With fewer, as `change`.
    """
    found = change(earlier[-1], now, metric, threshold=threshold)
    past = [value for entry in earlier if (value := number(entry.scores, metric)) is not None]
    if len(past) < FEWEST or found.before is None or found.after is None:
        return found
    by = f"spread of {counted(len(past), 'run')}"
    if found.verdict == "same":
        return _with(found, "same", sigmas=0.0, by=by)
    centre = mean(past)
    spread = 0.0 if same(min(past), max(past)) else stdev(past)
    distance = in_errors(found.after - centre, spread * sqrt(1 + 1 / len(past)))
    sigmas = as_normal(distance, len(past) - 1)
    agrees = sigmas * (found.after - found.before) > 0
    verdict = _verdict(metric, sigmas, sigmas, threshold) if agrees else "unresolved"
    return _with(found, verdict, sigmas=sigmas, by=by)


def expected_by_chance(compared: int, threshold: float) -> float:
    """How many of so many scores chance alone moves beyond the threshold, if their errors are normal."""
    return compared * erfc(threshold / sqrt(2))


def same(one: float, other: float) -> bool:
    """Whether two values agree but for rounding."""
    return abs(one - other) <= ROUNDING * max(abs(one), abs(other))


def in_errors(difference: float, error: float) -> float:
    """The difference in standard errors; infinite where the error is 0."""
    return difference / error if error > 0 else copysign(inf, difference)


def as_normal(t: float, freedom: int) -> float:
    """The standard normal value that is as improbable as Student's t."""
    if not isfinite(t):
        return t
    from scipy.special import ndtri, stdtr  # heavy

    return copysign(-float(ndtri(stdtr(freedom, -abs(t)))), t)


def _verdict(metric: str, difference: float, sigmas: float, threshold: float) -> Verdict:
    if abs(sigmas) <= threshold:
        return "unresolved"
    better = direction(metric)
    if better == "information":
        return "changed"
    return "better" if (difference < 0) == (better == "lower") else "worse"


def _why_absent(before: Entry, after: Entry, metric: str) -> str:
    lacking = after if number(after.scores, metric) is None else before
    if metric in lacking.scores:
        return "is not a number"
    return lacking.absent.get(metric, "was not measured")


def _with(
    found: Change, verdict: Verdict, *, sigmas: float | None = None, by: str | None = None, reason: str = ""
) -> Change:
    return replace(found, verdict=verdict, sigmas=sigmas, by=by or found.by, reason=reason or found.reason)
