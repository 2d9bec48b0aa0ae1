"""`swimlab compare`."""

import json
import shlex
import sys
from pathlib import Path
from typing import Annotated, Any

from cyclopts import Parameter

from swimlab.cli.comparison_table import print_comparison, print_outlook
from swimlab.cli.sources import warn_of_measuring
from swimlab.compare import history
from swimlab.compare.history import commit_of
from swimlab.compare.pick import Pick
from swimlab.compare.runs import compare_runs
from swimlab.runs.entries import read_all
from swimlab.runs.provenance import provenance
from swimlab.runs.record import RunError

Flag = Parameter(negative="")


def compare_command(
    *runs: Path,
    history: Path | None = None,
    save: Annotated[bool, Flag] = False,
    techniques: Annotated[str | None, Parameter(name=["--techniques", "-t"])] = None,
    metrics: Annotated[str | None, Parameter(name="--metric")] = None,
    sigma: float = 3.0,
    json_output: Annotated[bool, Parameter(name="--json", negative="")] = False,
) -> int:
    """Show the scores of two or more runs side by side, or of a run against its history.

    The first run is the base. Each change stands in units, in percent, and in the standard errors of both scores. Runs
    of other settings may be compared: what differs is said, and the scores it concerns are marked.

    Parameters
    ----------
    runs:
        Measured run folders, folders of a study, or scores.json files.
    history:
        Compare with the last run of the same settings in this folder, and show the trend.
    save:
        Add the scores to the folder of --history, as NUMBER_COMMIT_TIME.json.
    techniques:
        Techniques to show, with commas; * and ? as in file names (default: all).
    metrics:
        Scores to show, with commas; * and ? as in file names (default: the main ones).
    sigma:
        Standard errors beyond which a change is called real.
    json_output:
        Print the comparison as JSON instead of a table.
    """
    pick = Pick.of(techniques, metrics)
    if not 0 < sigma < float("inf"):
        raise RunError(f"--sigma {sigma:g}: must be above 0")
    about = provenance(shlex.join(["swimlab", *sys.argv[1:]]))
    if history is not None:
        return _against_history(runs, history, pick, sigma, save=save, json_output=json_output, about=about)
    if save:
        raise RunError("--save: adds to a folder of earlier scores; name it with --history FOLDER")

    comparison = compare_runs(runs, pick=pick, threshold=sigma, provenance=about)
    if json_output:
        print(json.dumps(comparison.as_json(), indent=1, allow_nan=False))
    else:
        print_comparison(comparison)
    warn_of_measuring(runs)
    return 0


def _against_history(
    runs: tuple[Path, ...],
    folder: Path,
    pick: Pick,
    sigma: float,
    *,
    save: bool,
    json_output: bool,
    about: dict[str, Any],
) -> int:

    earlier = history.read_history(folder)
    outlook = history.look_back(read_all(runs), earlier, pick=pick, threshold=sigma)
    saved = history.save(folder, runs, commit_of(Path.cwd()), provenance=about) if save else None
    warn_of_measuring(runs)
    if json_output:
        content = outlook.as_json(sigma) | {"provenance": about, "saved": None if saved is None else str(saved)}
        print(json.dumps(content, indent=1, allow_nan=False))
        return 0
    if earlier:
        print_outlook(outlook, sigma)
    else:
        print(f"{folder}: holds no history files yet" + ("" if save else "; --save adds one"))
    if saved is not None:
        print(saved)
    return 0
