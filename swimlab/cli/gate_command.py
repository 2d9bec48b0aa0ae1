"""`swimlab gate`."""

import os
import shlex
import sys
from dataclasses import dataclass
from pathlib import Path
from typing import Annotated

from cyclopts import Parameter

from swimlab.cli.sources import warn_of_sources
from swimlab.gate import outputs as github
from swimlab.gate.outcome import Outcome, run_gate
from swimlab.gate.outputs import junit, junit_error, print_table
from swimlab.runs.files import write_json, write_text
from swimlab.runs.provenance import provenance


@Parameter(name="*")
@dataclass(frozen=True, kw_only=True)
class Reports:
    """Where to write the outcome beside the table on standard output.

    Parameters
    ----------
    json:
        File for the outcome as JSON.
    junit:
        File for the outcome as JUnit XML.
    summary:
        File for the outcome as Markdown (default: appended to $GITHUB_STEP_SUMMARY where that is set).
    annotations:
        Print ::error and ::warning lines, which GitHub shows beside the change (default: where GITHUB_ACTIONS is set).
    """

    json: Path | None = None
    junit: Path | None = None
    summary: Path | None = None
    annotations: bool | None = None

    def write_error(self, gate: Path, message: str) -> None:
        """Say in the JUnit file, if one was asked for, that the gate could not run: a CI server shows nothing else."""

        if self.junit is not None:
            write_text(self.junit, junit_error(gate, message))

    def write(self, outcome: Outcome) -> None:
        """Write every report that was asked for."""

        if self.json is not None:
            write_json(self.json, outcome.as_json())
        if self.junit is not None:
            write_text(self.junit, junit(outcome))
        step_summary = os.environ.get("GITHUB_STEP_SUMMARY")
        if self.summary is not None:
            write_text(self.summary, github.summary(outcome))
        elif step_summary:
            with Path(step_summary).open("a", encoding="utf-8") as file:
                file.write(github.summary(outcome))
        annotate = self.annotations
        if annotate is None:
            annotate = os.environ.get("GITHUB_ACTIONS") == "true"
        if annotate:
            for line in github.annotations(outcome):
                print(line)


def gate_command(gate: Path, /, *runs: Path, reports: Annotated[Reports | None, Parameter(name="*")] = None) -> int:
    """Hold the scores of runs to a gate file.

    Exit code 0: all passed, perhaps with warnings; 1: a score is beyond its limit; 2: a score is missing, not a
    number or of other settings than the baseline, or the gate could not run.

    Parameters
    ----------
    gate:
        Gate file: rules with limits, and the baseline to compare with.
    runs:
        Measured run folders, folders of a study, or scores.json files.
    """
    reports = reports or Reports()
    try:
        outcome = run_gate(gate, runs, provenance=provenance(shlex.join(["swimlab", *sys.argv[1:]])))
    except (ValueError, OSError) as error:
        reports.write_error(gate, str(error))
        raise
    warn_of_sources(runs)
    print_table(outcome)
    reports.write(outcome)
    return outcome.exit_code
