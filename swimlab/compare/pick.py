"""Which scores are looked at: techniques and metrics by patterns."""

from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from fnmatch import fnmatchcase

from swimlab.runs.entries import Entry
from swimlab.runs.record import RunError

MAIN = (
    "budget.mse",
    "budget.bias",
    "budget.detail",
    "budget.flicker",
    "frame.mse",
    "edges.flicker",
    "new.mse",
    "residual.flicker",
    "visible.flicker",
    "plane.on",
    "moire.excess",
    "scale.rmse",
    "scale.mean_drift",
    "flip*.mean",
    "vdp.jod",
    "vmaf.mean",
)
"""What is looked at if nothing else is said: the whole picture's scores, and no bands of distance."""


@dataclass(frozen=True)
class Pick:
    """Patterns with * and ? of techniques and metrics; any that matches picks."""

    techniques: tuple[str, ...] = ("*",)
    metrics: tuple[str, ...] = MAIN

    @staticmethod
    def of(techniques: str | None, metrics: str | None) -> "Pick":
        """From lists with commas; None picks what is picked by default. Raises RunError for an empty list."""
        chosen = {}
        for option, key, text in (("-t", "techniques", techniques), ("--metric", "metrics", metrics)):
            if text is not None:
                chosen[key] = tuple(pattern.strip() for pattern in text.split(",") if pattern.strip())
                if not chosen[key]:
                    raise RunError(f"{option} {text!r}: give names or patterns, with commas")
        return Pick(**chosen)

    def check(self, entries: Sequence[Entry]) -> None:
        """Raise RunError naming a pattern that nothing in the entries matches; the default ones may."""
        techniques = sorted({entry.technique for entry in entries})
        for pattern in self.techniques:
            if not matching(techniques, [pattern]):
                raise RunError(f"-t {pattern}: matches no technique; there are {', '.join(techniques)}")
        if self.metrics == MAIN:
            return
        metrics = sorted({name for entry in entries for name in (*entry.scores, *entry.absent)})
        for pattern in self.metrics:
            if not matching(metrics, [pattern]):
                raise RunError(f"--metric {pattern}: matches no score; there are {', '.join(metrics)}")

    def has(self, technique: str) -> bool:
        """Whether the technique is looked at."""
        return bool(matching([technique], self.techniques))

    def of_entries(self, *entries: Entry) -> list[str]:
        """The scores to look at that any of the entries has, in the order of their names."""
        return matching(sorted({name for entry in entries for name in entry.scores}), self.metrics)


def matching(names: Iterable[str], patterns: Sequence[str]) -> list[str]:
    """Names that match any of the patterns."""
    return [name for name in names if any(fnmatchcase(name, pattern) for pattern in patterns)]
