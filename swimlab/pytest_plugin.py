"""The pytest fixture `swimlab_gate`: render a sequence, or take runs, and hold them to a gate file.

pytest loads this module whenever swimlab is installed, so it imports nothing heavy until the fixture is used.
"""

import warnings
from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Protocol

import pytest

if TYPE_CHECKING:
    from metrics.display import Domain
    from swimlab.gate.outcome import Outcome


class CheckGate(Protocol):
    """What the fixture gives."""

    def __call__(
        self,
        what: str | Path,
        gate: str | Path,
        *,
        techniques: Sequence[str] | None = None,
        size: tuple[int, int] | None = None,
        frames: str | None = None,
        samples: int = 64,
        threads: int | None = None,
        domain: "Domain" = "linear",
    ) -> "Outcome":
        """Fail the test unless the gate passes; its outcome otherwise.

        what: a measured run folder (or a study's), or a sequence to render: a name from the library or a .toml file.
        gate: the gate file. Relative paths are looked for beside the test file first.
        The rest is for rendering: techniques (None: all; the reference is always rendered), size (width, height) in
        px, frames as "0-7", samples a pixel of the reference, threads, and the domain to measure in.
        """


@pytest.fixture
def swimlab_gate(request: pytest.FixtureRequest, tmp_path: Path) -> CheckGate:
    """Hold a sequence or a run to a gate: `swimlab_gate("road.toml", "gate.toml", techniques=["tsl"])`."""

    def beside(name: str | Path) -> Path:
        near = request.path.parent / name
        return near if near.exists() else Path(name)

    def check(
        what: str | Path,
        gate: str | Path,
        *,
        techniques: Sequence[str] | None = None,
        size: tuple[int, int] | None = None,
        frames: str | None = None,
        samples: int = 64,
        threads: int | None = None,
        domain: "Domain" = "linear",
    ) -> "Outcome":
        __tracebackhide__ = True
        from swimlab.gate.outcome import gate_runs, render_and_measure
        from swimlab.gate.outputs import table_text
        from swimlab.gate.rules import GateError
        from swimlab.runs.record import RunError

        run = beside(what)
        try:
            if not run.is_dir():
                sequence, run = run, tmp_path / run.stem
                render_and_measure(
                    sequence,
                    run,
                    only=techniques,
                    size=size,
                    frames=frames,
                    samples=samples,
                    threads=threads,
                    domain=domain,
                )
            outcome = gate_runs(beside(gate), [run])
        except (GateError, RunError) as error:
            pytest.fail(f"{error}\n{_renew(beside(gate), run)}", pytrace=False)
        if outcome.exit_code:
            pytest.fail(f"{table_text(outcome)}{_renew(beside(gate), run)}", pytrace=False)
        for text in outcome.warnings:
            warnings.warn(pytest.PytestWarning(text), stacklevel=2)
        return outcome

    return check


def _renew(gate: Path, run: Path) -> str:
    return f"if the change is meant, renew the baseline: swimlab baseline update {gate} {run}"
