"""The section on peers: what a comparison with other renderers found, read from its JSON."""

import json
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from swimlab.runs.record import RunError
from swimlab.studies.page import Cell, Section, Table

Report = Mapping[str, Any]

RATIO = ("ours", "against", "clock", "quartiles", "cores", "quartiles of cores")


def read_peers(path: Path) -> Section:
    """The section made of the JSON that reports/peers/run.py writes. Raises RunError where it cannot be read."""
    try:
        return section(json.loads(path.read_text(encoding="utf-8")))
    except OSError as error:
        raise RunError(f"--peers {path}: {error.strerror}; write it by reports/peers/run.py --json {path}") from error
    except (ValueError, KeyError, TypeError) as error:
        problem = f"--peers {path}: is not what reports/peers/run.py writes"
        raise RunError(f"{problem} ({type(error).__name__}: {error}); run it again") from error


def section(report: Report) -> Section:
    """What was asked of speed against peers, whether it is met, and everything that was timed."""
    settings = report["settings"]
    versions = "; ".join(f"{name} {version}" for name, version in report["versions"].items())
    width, height = settings["size"]
    rows: list[list[Cell]] = [[*_ratio(ratio), _asked(ratio), _verdict(ratio)] for ratio in report["targets"]]
    met = sum(row[-1] == "met" for row in rows)
    return Section(
        "Against peers",
        [
            f"The same road from the same maps drawn by other renderers, in turns with ours: {width}x{height}, the "
            f"road covers {report['covered']:.0%} with the horizon in view, {settings['threads']} threads, "
            f"{settings['rounds']} rounds; {report['machine']}; {versions}. Meanwhile other programs kept "
            f"{report['others']:.1f} processors busy. *Clock* is what a user waits, *cores* the time of all cores, "
            "which these hardly disturb (rates as if every thread had a core); ratios are medians over rounds, with "
            "quartiles. A peer that is left out has no rows. "
            f"**{met} of {len(rows)} targets are met**.",
            Table("peer targets", [*RATIO, "asked", "verdict"], rows),
            "Ratios that nothing is asked of:",
            Table("peer ratios", list(RATIO), [_ratio(ratio) for ratio in report["ratios"]]),
            f"All that was timed. The error is against our reference, whose own is {report['truth_error']:.2g}: every "
            "renderer's picture is scored in the same way.",
            Table(
                "peers",
                ["", "ms", "quartiles", "ms of all cores", "rms error", "million samples a second"],
                [_timed(label, row) for label, row in report["results"].items()],
            ),
        ],
    )


def _ratio(ratio: Report) -> list[Cell]:
    by_clock, by_cores = ratio["wall"], ratio["cpu"]
    names: list[Cell] = [f"`{ratio['this']}`", f"`{ratio['that']}`"]
    return [*names, by_clock["median"], _quartiles(by_clock), by_cores["median"], _quartiles(by_cores)]


def _asked(ratio: Report) -> str:
    return f"≤ {ratio['limit']:g} by the {ratio['by']}"


def _verdict(ratio: Report) -> str:
    found = ratio["wall" if ratio["by"] == "clock" else "cpu"]["median"]
    return "met" if found <= ratio["limit"] else "**not met**"


def _timed(label: str, row: Report) -> list[Cell]:
    rate = row.get("million_samples_a_second")
    cost: list[Cell] = [f"`{label}`", row["ms"]["median"], _quartiles(row["ms"]), row["cpu_ms"]["median"]]
    return [*cost, row["rms"], rate["wall"]["median"] if rate else None]


def _quartiles(spread: Report) -> str:
    return f"{spread['low']:.3g}–{spread['high']:.3g}"
