"""`swimlab baseline`."""

import shlex
import sys
from pathlib import Path
from typing import Annotated, Literal

from cyclopts import Parameter

from swimlab.cli.sources import warn_of_measuring, warn_of_sources
from swimlab.gate.outcome import update_baseline
from swimlab.gate.outputs import number
from swimlab.gate.rules import GateError, load_gate
from swimlab.runs.counting import counted
from swimlab.runs.provenance import provenance


def baseline_command(
    action: Literal["update"],
    gate: Path,
    /,
    *runs: Path,
    count: Annotated[int | None, Parameter(name="--runs")] = None,
) -> int:
    """Record the scores of runs as the baseline of a gate; the file is replaced as a whole.

    Only scores that a rule of the gate speaks of are recorded. Several runs of the same sequence under the same
    settings give their spread, which noise_sigma in a rule counts by.

    Parameters
    ----------
    action:
        What to do: update.
    gate:
        Gate file that names the baseline's file.
    runs:
        Measured run folders, folders of a study, or scores.json files.
    count:
        Refuse unless every technique on every sequence comes in so many runs.
    """
    command = shlex.join(["swimlab", *sys.argv[1:]])
    try:
        baseline = update_baseline(gate, runs, count=count, provenance=provenance(command))
    except GateError as error:
        for line in str(error).splitlines():
            print(f"swimlab: {line}", file=sys.stderr)
        if error.paste:
            print(
                f"to switch off scores that are not available, add at the end of {gate}:\n{error.paste}",
                file=sys.stderr,
            )
        return 2
    warn_of_sources(runs)
    warn_of_measuring(runs)
    for (sequence, technique), known in baseline.entries.items():
        for name, (mean, sigma) in known.scores.items():
            spread = "unknown" if sigma is None else number(sigma)
            print(f"{sequence} {technique} {name} = {number(mean)}, sigma {spread} ({counted(known.runs, 'run')})")
    print(load_gate(gate).baseline_path)
    return 0
