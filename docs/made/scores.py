"""Every score: unit, direction, formula, source, and the tests that hold it to a closed form or a property."""

import ast
from collections import defaultdict
from functools import cache
from pathlib import Path

from catalogue import cell

from metrics import METRICS
from metrics.bands import BANDS, describe

TESTS = Path(__file__).parents[2] / "tests"
BETTER = {"lower": "lower is better", "higher": "higher is better", "information": "information, no direction"}
OPENING = """# Scores

This page is made from what the measures declare (`swimlab list metrics --json`) and from the tests that name the
scores they check. In the formulas e is test - reference, E its surface-locked spectra at spatial frequency k, X the
test's, w the tiles' window and T the number of frames; sums are over all tiles and channels. Scores of radiance are
squared: the report and the tables print their square roots. With `--domain display` radiance is display codes in 0..1.

A score with bands has variants by distance: {bands}. `swimlab selftest` measures clips of known answer and prints
both; [How it measures](../concepts/measuring.md) says how.

| score | unit | better | what it says |
| --- | --- | --- | --- |
"""


def page() -> str:
    """The page: a table of all, then a section a score."""
    whole = [name for name in METRICS if name.rpartition(".")[2] not in BANDS]
    bands = ", ".join(f"`.{band}` ({describe(band)})" for band in BANDS)
    rows = []
    for name in whole:
        metric = METRICS[name]
        anchor = name.replace(".", "").lower()
        rows.append(f"| [`{name}`](#{anchor}) | {metric.unit} | {metric.better} | {cell(metric.description)} |")
    tests = checks()
    return (
        OPENING.format(bands=bands)
        + "\n".join(rows)
        + "\n\n"
        + "\n\n".join(_section(n, tests[n]) for n in whole)
        + "\n"
    )


def _section(name: str, tests: list[tuple[str, str]]) -> str:
    metric = METRICS[name]
    bands = [band for band in BANDS if f"{name}.{band}" in METRICS]
    lines = [
        f"## `{name}`",
        f"{cell(metric.description[0].upper() + metric.description[1:])}.",
        f"- **Unit**: {metric.unit}; {BETTER[metric.better]}" + (f"; bands {', '.join(bands)}" if bands else ""),
        f"- **Formula**: `{metric.formula}`",
        f"- **Source**: {metric.source}",
        *(f"- **Checked**: {words} (`{file}`)" for words, file in tests),
    ]
    return "\n\n".join(lines[:2]) + "\n\n" + "\n".join(lines[2:])


@cache
def checks(folder: Path = TESTS) -> dict[str, list[tuple[str, str]]]:
    """Score -> what its tests say and the files they stand in, by the marker `checks` of the tests."""
    found: dict[str, list[tuple[str, str]]] = defaultdict(list)
    for path in sorted(folder.rglob("test_*.py")):
        for node in ast.parse(path.read_text(encoding="utf-8")).body:
            if isinstance(node, ast.FunctionDef):
                for score in _marked(node):
                    words = node.name.removeprefix("test_").replace("_", " ")
                    found[score].append((words, f"tests/{path.relative_to(folder).as_posix()}"))
    return found


def _marked(function: ast.FunctionDef) -> list[str]:
    calls = [each for each in function.decorator_list if isinstance(each, ast.Call)]
    ours = [call for call in calls if ast.unparse(call.func) == "pytest.mark.checks"]
    return [ast.literal_eval(word) for call in ours for word in call.args]
