"""A change of a score as a share of what it was."""

ROUND_OFF = 1e-12
"""A score nearer to 0 is what floats leave of nothing, in the units that scores have."""

LEAST = 1e-6
"""So small a part of what it became, a score was as good as 0, and its percents would say nothing."""


def share(before: float, after: float) -> float | None:
    """The change as a share of what was before; None where that is as good as 0 and there is no share of it."""
    if abs(before) <= max(ROUND_OFF, LEAST * abs(after)):
        return None
    return (after - before) / abs(before)
