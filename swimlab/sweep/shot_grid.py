"""Sweeps over shots: builds by settings. Frames are there, and each configuration is a way to look at them."""

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path

from sequences.problems import SequenceError
from swimlab.footage.request import Request
from swimlab.footage.shot import is_shot, load_shot
from swimlab.runs.record import RunError
from swimlab.runs.scores import read_scores
from swimlab.sweep.build import Build
from swimlab.sweep.engine import Engine
from swimlab.sweep.file import Sweep, SweepError, check_lists
from swimlab.sweep.grid import name_of, points
from swimlab.sweep.perform import Show
from swimlab.sweep.shots import Asked, Shots
from swimlab.sweep.work import Outcome

OF_RENDERING = ("size", "samples", "chunk")


@dataclass(frozen=True)
class ShotWork:
    """A sweep of shots in pieces. requests: what is asked of the builds of each configuration, by its name."""

    sweep: Sweep
    requests: dict[str, dict[str, Request]]
    out: Path

    @staticmethod
    def of(sweep: Sweep, out: Path) -> "ShotWork":
        """Cut a sweep up; run folders will be in `out`. Raises SweepError naming every mistake in it."""
        problems = dict.fromkeys(check_lists(sweep))
        of_rendering = [key for key in OF_RENDERING if key in sweep.model_fields_set]
        problems |= dict.fromkeys(
            f"{key}: is of rendering; the frames of shots are there, leave it out" for key in of_rendering
        )
        requests: dict[str, dict[str, Request]] = {}
        for source, varied in points(sweep):
            path = Path(sweep.place(source))
            frames = {} if sweep.frames is None else {"frames": sweep.frames}
            try:
                shot = load_shot(path, changes=frames | varied)
                name = name_of(shot.name, varied)
                if name in requests and not problems:
                    problems[f"sequences: two are named {name!r}; give one of them another name"] = None
                requests[name] = shot.requests(path.parent, sweep.domain, builds=sweep.techniques)
            except SequenceError as error:
                problems |= dict.fromkeys(error.problems)
            except RunError as error:
                problems[f"techniques: {error}"] = None
        if problems:
            raise SweepError("\n".join(f"{sweep.path}: {problem}" for problem in problems))
        return ShotWork(sweep, requests, out)

    @property
    def names(self) -> list[str]:
        """The configurations' names."""
        return list(self.requests)

    @cached_property
    def _shots(self) -> Shots:
        return Shots(Asked(name, asked, self.out / "runs" / name) for name, asked in self.requests.items())

    def pieces(self) -> list[Build]:
        """Every build once, in a fixed order: what several configurations look at alike is measured once."""
        return list(self._shots.builds.values())

    def do(
        self, pieces: Sequence[Build], out: Path, engine: Engine, *, threads: int | None, show: Show
    ) -> dict[Path, str]:
        """Measure the missing ones of some builds; the failures by file."""
        return self._shots.measure(pieces, out, engine, threads=threads, show=show)

    def finish(self, out: Path, engine: Engine, *, command: str, show: Show) -> Outcome:
        """Write the run folders of the configurations that are measured."""
        outcome = Outcome(failures=self._shots.write(out, engine, command=command, show=show))
        outcome.scores = [read_scores(run) for run in self._shots.written(out, outcome.failures)]
        return outcome


def are_shots(sweep: Sweep) -> bool:
    """Whether a sweep is over shot files. Raises SweepError where it is over sequences as well."""
    found = [is_shot(sweep.place(source)) for source in sweep.sequences]
    if any(found) and not all(found):
        shot, sequence = (sweep.sequences[found.index(kind)] for kind in (True, False))
        raise SweepError(
            f"{sweep.path}: sequences: {shot} is a shot, whose builds are there, and {sequence} is rendered under "
            "techniques; sweep them apart"
        )
    return all(found)
