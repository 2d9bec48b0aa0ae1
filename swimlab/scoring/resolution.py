"""Which differences between techniques are more than chance."""

from collections.abc import Mapping, Sequence
from itertools import pairwise
from typing import Any

from metrics import METRICS
from metrics.ratios import SIGMAS, resolved

MARK = "≈"
LEGEND = (
    f"{MARK} not resolved from the next better one: within {SIGMAS:g} standard errors of their difference, "
    "or the reference's own error"
)


def unresolved(entries: Sequence[Mapping[str, Any]], score: str) -> set[str]:
    """Techniques that a score does not tell from the next better one of the entries of scores.json.

    Empty for scores of which no standard error is known, or of which neither direction is better.
    """
    metric = METRICS.get(score)
    having = [e for e in entries if score in e["scores"] and score in e.get("errors", {})]
    if metric is None or metric.better == "information":
        return set()
    ranked = sorted(having, key=lambda entry: float(entry["scores"][score]), reverse=metric.better == "higher")
    return {worse["technique"] for better, worse in pairwise(ranked) if not resolved(score, better, worse)}
