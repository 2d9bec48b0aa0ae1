"""All scores and all measures, discovered: adding a measure is adding one file.

A measure's file defines SCORES (name -> Metric) and, if it works on the tiles of a clip, MEASURE (a class).
"""

from collections.abc import Iterable
from pathlib import Path
from types import ModuleType

from metrics.measurement import Measure, Metric
from metrics.plugins import modules


def _modules() -> list[ModuleType]:
    """The package's modules that define scores, by name."""
    return [module for module in modules("metrics", [str(Path(__file__).parent)]) if hasattr(module, "SCORES")]


def collect(found_in: Iterable[ModuleType]) -> dict[str, Metric]:
    """Scores of all modules by name, sorted. Raises ValueError if two modules define the same name."""
    found: dict[str, tuple[Metric, str]] = {}
    for module in found_in:
        for name, metric in module.SCORES.items():
            if name in found:
                raise ValueError(f"score {name} is defined in {found[name][1]} and in {module.__name__}")
            found[name] = (metric, module.__name__)
    return {name: found[name][0] for name in sorted(found)}


METRICS: dict[str, Metric] = collect(_modules())
"""Every score by name."""


def measures(names: Iterable[str] | None) -> list[type[Measure]]:
    """The measures that give any of the named scores (a name or its beginning, "budget"); all for None."""
    chosen = [
        module
        for module in _modules()
        if hasattr(module, "MEASURE") and (names is None or any(selected(s, names) for s in module.SCORES))
    ]
    return [module.MEASURE for module in chosen]


def selected(score: str, names: Iterable[str] | None) -> bool:
    """Whether a score is named, by itself or by its beginning; every one is for None."""
    return names is None or any(score == name or score.startswith(name + ".") for name in names)


def check_names(names: Iterable[str] | None) -> None:
    """Raise ValueError for a name that no score has or begins with."""
    for name in names or ():
        if not any(selected(score, [name]) for score in METRICS):
            raise ValueError(f"no score is named {name}; there are {', '.join(METRICS)}")
