"""Shots measured on an engine: builds, whose entries of scores.json are files, then a run folder of each shot."""

from collections.abc import Iterable, Mapping, Sequence
from pathlib import Path
from typing import Any, NamedTuple

from swimlab.footage.brought import from_anywhere
from swimlab.footage.builds import of_same_frames
from swimlab.footage.keys import as_keys
from swimlab.footage.request import Request
from swimlab.footage.sources import Inputs, files_of, find_inputs, hash_inputs
from swimlab.runs.configuration import UNTOLD
from swimlab.runs.record import Record, RunError
from swimlab.scoring.brought import inputs_of, measure_brought
from swimlab.scoring.kept import keep, kept_entries, keys_of_builds
from swimlab.sweep.build import STORE, Build, check_keys, join_build, measure_into, measure_part
from swimlab.sweep.engine import Engine, Task
from swimlab.sweep.perform import Show, perform


class Asked(NamedTuple):
    """A shot to measure: its name, what is asked of its builds, and the run folder that they make."""

    name: str
    requests: Mapping[str, Request]
    run: Path


class Shots:
    """Shots, and the builds of all of them, each once."""

    def __init__(self, asked: Iterable[Asked]) -> None:
        """Files are hashed. Raises FrameError for those that are not there, RunError where builds can have no key."""
        self.asked: list[Asked] = []
        self.inputs: dict[str, Inputs] = {}
        self.keys: dict[str, dict[str, str]] = {}
        self.builds: dict[str, Build] = {}
        known: dict[str, Mapping[str, Any]] = {}
        for name, given, run in asked:
            whole = _absolute(given)
            known |= files_of(Record.read(run).inputs) if (run / "run.json").is_file() else {}
            found = find_inputs(whole)
            requests = of_same_frames(whole)
            self.asked.append(Asked(name, requests, run))
            inputs = self.inputs[name] = hash_inputs(found, known)
            known |= files_of(inputs)
            keys = self.keys[name] = keys_of_builds(requests, inputs, device="cpu")
            if not keys:
                raise RunError(UNTOLD)
            for build, key in keys.items():
                own = inputs_of(build, requests, inputs)
                self.builds.setdefault(key, Build(key, name, build, requests[build], own))

    def measure(
        self, builds: Sequence[Build], out: Path, engine: Engine, *, threads: int | None, show: Show
    ) -> dict[Path, str]:
        """Measure the missing ones of some builds, long ones by parts; the failures by file."""
        self._take_kept(out)
        missing = [build for build in builds if not build.path(out).is_file()]
        opened = [
            Task(build.key, build.label, measure_into, (build, out, threads))
            for build in missing
            if build.planned(out) is None
        ]
        failures = perform(opened, out, engine, what="measuring builds", show=show)
        long = [(build, parts) for build in missing if (parts := build.parts(out))]
        looked_at = [
            Task(part.key, part.label, measure_part, (part, out, threads))
            for _, some in long
            for part in some
            if not part.path(out).is_file()
        ]
        failures |= perform(looked_at, out, engine, what="measuring parts of builds", show=show)
        joined = [
            Task(build.key, build.label, join_build, (build, out))
            for build, some in long
            if all(part.path(out).is_file() for part in some)
        ]
        failures |= perform(joined, out, engine, what="joining parts of builds", show=show)
        return _in_keys(failures)

    def write(self, out: Path, engine: Engine, *, command: str, show: Show) -> dict[Path, str]:
        """Write the run folders of the shots all of whose builds are measured; the failures by file."""
        tasks = [
            Task(
                _writing(each), each.name, write_run, (each, out, self.inputs[each.name], self.keys[each.name], command)
            )
            for each in self._measured(out)
        ]
        return _in_keys(perform(tasks, out, engine, what="writing runs", show=show))

    def written(self, out: Path, failures: Mapping[Path, str]) -> list[Path]:
        """The run folders that were written, after these failures."""
        failed = {path.stem for path in failures}
        return [each.run for each in self._measured(out) if _writing(each) not in failed]

    def _take_kept(self, out: Path) -> None:
        """Put the entries that runs have already where those of measured builds are."""
        for name, _, run in self.asked:
            keys = self.keys[name]
            for build, entry in kept_entries(run, keys).items():
                if not self.builds[keys[build]].path(out).is_file():
                    keep(out / STORE, keys[build], entry)

    def _measured(self, out: Path) -> list[Asked]:
        """The shots all of whose builds are measured."""
        return [each for each in self.asked if all(self.builds[key].path(out).is_file() for key in self._keys(each))]

    def _keys(self, asked: Asked) -> Iterable[str]:
        return self.keys[asked.name].values()


def _writing(asked: Asked) -> str:
    """The key of the task that writes a shot's run."""
    return f"run-{asked.name}"


def write_run(asked: Asked, out: Path, inputs: Inputs, keys: Mapping[str, str], command: str) -> None:
    """Write a shot's run folder of the entries of its builds. Raises as `measure_into` and `measure_brought` do."""
    check_keys(asked.requests, inputs, keys)
    measure_brought(asked.requests, asked.run, sequence=asked.name, command=command, store=out / STORE, known=inputs)


def _in_keys(failures: Mapping[Path, str]) -> dict[Path, str]:
    """Failures in the words of shot files."""
    return {path: as_keys(text) for path, text in failures.items()}


def _absolute(requests: Mapping[str, Request]) -> dict[str, Request]:
    return {name: from_anywhere(request) for name, request in requests.items()}
