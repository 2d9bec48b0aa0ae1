"""Shots measured on an engine: a task for each build, whose entry of scores.json is a file, then one a run folder."""

from collections.abc import Iterable, Mapping, Sequence
from pathlib import Path
from typing import Any, NamedTuple

from swimlab.footage.brought import from_anywhere
from swimlab.footage.keys import as_keys
from swimlab.footage.request import Request
from swimlab.footage.sources import Inputs, check_unchanged, files_of, find_inputs, hash_inputs
from swimlab.footage.subject import Subject
from swimlab.runs.configuration import UNTOLD
from swimlab.runs.record import Record, RunError
from swimlab.scoring.brought import inputs_of, measure_brought
from swimlab.scoring.footage import measure_build
from swimlab.scoring.kept import keep, keys_of_builds
from swimlab.sweep.engine import Engine, Task
from swimlab.sweep.perform import Show, perform

STORE = ".scores"
"""Folder of the entries, each named by its key; no shot can be called so."""


class Asked(NamedTuple):
    """A shot to measure: its name, what is asked of its builds, and the run folder that they make."""

    name: str
    requests: Mapping[str, Request]
    run: Path


class Build(NamedTuple):
    """A build to measure, all that a worker needs. key: of its scores. inputs: its files."""

    key: str
    shot: str
    technique: str
    request: Request
    inputs: Inputs

    @property
    def frames(self) -> tuple[int, ...]:
        """A place for each of its files."""
        return tuple(range(len(self.inputs[self.technique]["files"])))

    def path(self, out: Path) -> Path:
        """File of its entry; it is there when the build is measured."""
        return out / STORE / f"{self.key}.json"


class Shots:
    """Shots, and the builds of all of them, each once."""

    def __init__(self, asked: Iterable[Asked]) -> None:
        """Files are hashed. Raises FrameError for those that are not there, RunError where builds can have no key."""
        self.asked = [each._replace(requests=_absolute(each.requests)) for each in asked]
        self.inputs: dict[str, Inputs] = {}
        self.keys: dict[str, dict[str, str]] = {}
        self.builds: dict[str, Build] = {}
        known: dict[str, Mapping[str, Any]] = {}
        for name, requests, run in self.asked:
            known |= files_of(Record.read(run).inputs) if (run / "run.json").is_file() else {}
            inputs = self.inputs[name] = hash_inputs(find_inputs(requests), known)
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
        """Measure the missing ones of some builds; the failures by file."""
        tasks = [
            Task(build.key, f"{build.shot}, {build.technique}", measure_into, (build, out, threads))
            for build in builds
            if not build.path(out).is_file()
        ]
        return _in_keys(perform(tasks, out, engine, what="measuring builds", show=show))

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

    def _measured(self, out: Path) -> list[Asked]:
        """The shots all of whose builds are measured."""
        return [each for each in self.asked if all(self.builds[key].path(out).is_file() for key in self._keys(each))]

    def _keys(self, asked: Asked) -> Iterable[str]:
        return self.keys[asked.name].values()


def _writing(asked: Asked) -> str:
    """The key of the task that writes a shot's run."""
    return f"run-{asked.name}"


def measure_into(build: Build, out: Path, threads: int | None) -> None:
    """Measure a build and write its entry beneath `out`; nothing where it is there.

    Raises RunError where this machine would make another key, and all that measuring raises.
    """
    _check_keys({build.technique: build.request}, build.inputs, {build.technique: build.key})
    if build.path(out).is_file():
        return
    subject = Subject(build.request, lambda _: None, lambda _: None)
    entry = measure_build(build.shot, build.technique, subject, threads=threads)
    check_unchanged(build.inputs, when="while it was measured")
    keep(out / STORE, build.key, entry)


def write_run(asked: Asked, out: Path, inputs: Inputs, keys: Mapping[str, str], command: str) -> None:
    """Write a shot's run folder of the entries of its builds. Raises as `measure_into` and `measure_brought` do."""
    _check_keys(asked.requests, inputs, keys)
    measure_brought(asked.requests, asked.run, sequence=asked.name, command=command, store=out / STORE, known=inputs)


def _check_keys(requests: Mapping[str, Request], inputs: Inputs, keys: Mapping[str, str]) -> None:
    if keys_of_builds(requests, inputs, device="cpu") != keys:
        raise RunError(
            "this machine measures by another version of swimlab, or of what it stands on, or by another $OCIO; "
            "install, and set, the same"
        )


def _in_keys(failures: Mapping[Path, str]) -> dict[Path, str]:
    """Failures in the words of shot files."""
    return {path: as_keys(text) for path, text in failures.items()}


def _absolute(requests: Mapping[str, Request]) -> dict[str, Request]:
    return {name: from_anywhere(request) for name, request in requests.items()}
