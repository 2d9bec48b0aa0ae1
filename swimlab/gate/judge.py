"""Hold scores to a gate. Nothing passes that is missing, not a number, or measured under other settings."""

from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass, replace
from fnmatch import fnmatchcase
from math import isnan
from typing import Literal

from metrics import METRICS
from swimlab.gate.baseline import Baseline, Known
from swimlab.gate.comparable import difference
from swimlab.gate.evidence import Evidence
from swimlab.gate.lacking import may_lack, why_lacking
from swimlab.gate.rules import Cell, Gate, Rule
from swimlab.runs.entries import Entry, Key
from swimlab.runs.shares import share

Status = Literal["pass", "warn", "fail", "unjudged"]
MENDED = "`swimlab compare` shows what that costs; renew the baseline if it is meant"


@dataclass(frozen=True)
class Check:
    """The outcome for one score.

    rule: number of the rule that counts, from 1. limit: in words, as "<= 0.0012". base, sigma: of the baseline;
    sigma is None where a single run says nothing of it. reason: why it did not pass, or what to beware of.
    absent: whether the run lacks it, and its name is no slip: a rule may have to switch it off.
    """

    sequence: str
    technique: str
    metric: str
    rule: int
    status: Status
    value: float | None = None
    limit: str = ""
    base: float | None = None
    sigma: float | None = None
    reason: str = ""
    evidence: Evidence | None = None
    absent: bool = False

    @property
    def cell(self) -> Cell:
        """Sequence, technique and metric."""
        return self.sequence, self.technique, self.metric

    @property
    def name(self) -> str:
        """The score in words, as "road-shift/tsl budget.flicker"."""
        return f"{self.sequence}/{self.technique} {self.metric}"


def judge(gate: Gate, entries: Sequence[Entry], baseline: Baseline | None) -> list[Check]:
    """Check every score that a rule of the gate speaks of, in the order of sequence, technique and metric.

    A score beyond its limit has the status "fail" or "warn", after the rule's level; one that cannot be judged
    is "unjudged" at any level: missing from the run or the baseline, not a number, of other settings. Of
    other settings, it is held to its ceiling and floor all the same, and `reason` says so where it is beyond.
    """
    measured = {entry.key: entry for entry in entries}
    known = baseline.entries if baseline is not None else {}
    checks = []
    for cell, rule in sorted(governed(gate, entries, baseline)):
        entry = measured.get(cell[:2])
        checks.append(_check(cell, rule, gate, entry, known.get(cell[:2])))
    return checks


def exit_code(checks: Iterable[Check]) -> int:
    """1 where a score is beyond its limit, else 2 where one could not be judged, else 0."""
    found = {check.status for check in checks}
    return 1 if "fail" in found else 2 if "unjudged" in found else 0


def governed(gate: Gate, entries: Iterable[Entry], baseline: Baseline | None) -> list[tuple[Cell, int]]:
    """Every score that the rules speak of, with the number of the rule that counts, from 0.

    A metric with wildcards leaves out scores that are only information, and scores that are not available unless the
    baseline has them. Where a pattern matches nothing, the pattern itself stands for what is missing.
    """
    names: dict[Key, set[str]] = {}
    for entry in entries:
        names.setdefault(entry.key, set()).update(entry.scores)
    for key, known in (baseline.entries if baseline is not None else {}).items():
        names.setdefault(key, set()).update(known.scores)
    cells = dict.fromkeys(cell for rule in gate.rule if rule.level != "off" for cell in _cells(rule, names))
    ruled = [(cell, gate.governing(*cell)) for cell in cells]
    return [(cell, rule) for cell, rule in ruled if gate.rule[rule].level != "off"]


def _cells(rule: Rule, names: dict[Key, set[str]]) -> Iterator[Cell]:
    for sequence in _matching(rule.sequence, {key[0] for key in names}):
        for technique in _matching(rule.technique, {key[1] for key in names if key[0] == sequence}):
            found = names.get((sequence, technique), set())
            for metric in [rule.metric] if rule.metric in found else _matching(rule.metric, _judgeable(found)):
                yield sequence, technique, metric


def _judgeable(names: set[str]) -> set[str]:
    return {name for name in names if name not in METRICS or METRICS[name].better != "information"}


def _matching(pattern: str, names: set[str]) -> list[str]:
    return sorted(name for name in names if fnmatchcase(name, pattern)) or [pattern]


def _check(cell: Cell, number: int, gate: Gate, entry: Entry | None, known: Known | None) -> Check:
    check = Check(*cell, rule=number + 1, status="unjudged")
    rule, metric = gate.rule[number], cell[2]
    if entry is None:
        return replace(check, reason="was not measured; give its run, or mend the rule's sequence and technique")
    value = entry.scores.get(metric)
    if value is None:
        return replace(check, reason=why_lacking(metric, entry), absent=may_lack(metric, entry))
    if isnan(value):
        return replace(check, reason="is not a number; look for NaN and Inf in the frames and measure again")
    check = replace(check, value=value)
    better = METRICS[metric].better if metric in METRICS else "information"
    base = known.scores.get(metric) if known is not None else None
    unlike = difference(entry, known.settings, known.hashed) if known is not None else ""
    if unlike:
        held = _against(check, value, list(_limits(rule, None, better)), rule, None)
        beyond = f"; independent of the baseline, {held.reason}" if held.reason else ""
        told = f"is not comparable with the baseline: {unlike}; {MENDED}{beyond}"
        return replace(held, status="unjudged", reason=told)
    if base is not None:
        check = replace(check, base=base[0], sigma=base[1])
    elif gate.baseline is not None:
        status: Status = "warn" if gate.baseline.missing == "warn" else "unjudged"
        check = replace(check, status=status, reason="is not in the baseline; add it: swimlab baseline update")
        if status == "unjudged":
            return check
    if rule.max_increase is None and {"lower": rule.max, "higher": rule.min}.get(better, 0.0) is None:
        key = "max" if better == "lower" else "min"
        return replace(check, status="unjudged", reason=f"{better} is better, so the rule has to give {key}")
    return _against(check, value, list(_limits(rule, base, better)), rule, base)


def _limits(rule: Rule, base: tuple[float, float | None] | None, better: str) -> Iterator[tuple[str, float]]:
    """Each limit as (sign, bound): "<=" for a ceiling, ">=" for a floor.

    max_increase turns where higher is better, and binds both ways where neither is.
    """
    if rule.max is not None:
        yield "<=", rule.max
    if rule.min is not None:
        yield ">=", rule.min
    if rule.max_increase is not None and base is not None:
        allowed = rule.max_increase.allowance(base[0]) + (rule.noise_sigma or 0.0) * (base[1] or 0.0)
        if better != "higher":
            yield "<=", base[0] + allowed
        if better != "lower":
            yield ">=", base[0] - allowed


def _change(base: float, value: float) -> str:
    relative = share(base, value)
    if relative is None:
        return f"{value - base:+.4g} against the baseline's {base:.4g}, which is as good as 0"
    return f"{100 * relative:+.1f}% against the baseline"


def _against(
    check: Check, value: float, limits: list[tuple[str, float]], rule: Rule, base: tuple[float, float | None] | None
) -> Check:
    """Compare a value with its limits; the tightest of each sign is shown."""
    ceiling = min((bound for sign, bound in limits if sign == "<="), default=None)
    floor = max((bound for sign, bound in limits if sign == ">="), default=None)
    shown = [f"<= {ceiling:.4g}"] if ceiling is not None else []
    shown += [f">= {floor:.4g}"] if floor is not None else []
    check = replace(check, limit=" ".join(shown))
    reasons = [check.reason] if check.reason else []
    if rule.noise_sigma and base is not None and base[1] is None:
        reasons.append("sigma unknown: the baseline is of one run, so nothing is granted for noise")
    beyond = ""
    if ceiling is not None and value > ceiling:
        beyond = f"{value:.6g} is above {ceiling:.6g}"
    elif floor is not None and value < floor:
        beyond = f"{value:.6g} is below {floor:.6g}"
    if beyond:
        if base is not None:
            beyond += f", {_change(base[0], value)}"
        return replace(check, status="warn" if rule.level == "warn" else "fail", reason="; ".join([beyond, *reasons]))
    status: Status = "warn" if check.status == "warn" else "pass"
    return replace(check, status=status, reason="; ".join(reasons))
