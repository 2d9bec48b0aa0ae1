"""A build of a shot, measured where there is room: as one task, or, if it is long, by parts."""

import pickle
from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Any, NamedTuple

from metrics.totals import Found
from swimlab.footage.request import Request
from swimlab.footage.sources import Inputs, check_unchanged
from swimlab.footage.subject import Subject
from swimlab.runs.files import replacing
from swimlab.runs.record import RunError
from swimlab.scoring.by_parts import Part, Planned, join_parts, look_at, plan_build
from swimlab.scoring.footage import measure_build
from swimlab.scoring.kept import keep, keys_of_builds

STORE = ".scores"
"""Folder of the entries, each named by its key, and of what they are joined of; no shot can be called so."""

LEAST = 64
"""Frames of a part at least. Beside its frames it costs a quarter of a second, a file and the frame before, which is to
be little; a killed worker loses no more than a part."""


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

    @property
    def label(self) -> str:
        """What it is, for people."""
        return f"{self.shot}, {self.technique}"

    def path(self, out: Path) -> Path:
        """File of its entry; it is there when the build is measured."""
        return out / STORE / f"{self.key}.json"

    def plan_path(self, out: Path) -> Path:
        """File of its plan; it is there when the build is to be measured by parts."""
        return out / STORE / f"{self.key}.plan"

    def planned(self, out: Path) -> Planned | None:
        """Its plan, where it has one; not one of files that were elsewhere, which are open in it."""
        path = self.plan_path(out)
        planned: Planned | None = _load(path) if path.is_file() else None
        return planned if planned is not None and planned.subject.request == self.request else None

    def parts(self, out: Path) -> "list[BuildPart]":
        """Its parts, where it has a plan."""
        planned = self.planned(out)
        return [BuildPart(self, part) for part in planned.parts] if planned is not None else []


class BuildPart(NamedTuple):
    """A part of a build."""

    build: Build
    part: Part

    @property
    def key(self) -> str:
        """Of what is found in it."""
        return "{}.{}-{}".format(self.build.key, *self.part.frames)

    @property
    def label(self) -> str:
        """What it is, for people."""
        return "{}, frames {}-{}".format(self.build.label, *self.part.frames)

    def path(self, out: Path) -> Path:
        """File of what is found in it; it is there when the part is measured."""
        return out / STORE / f"{self.key}.part"


def measure_into(build: Build, out: Path, threads: int | None) -> None:
    """Measure a build and write its entry beneath `out`, or, if it is long, its plan; nothing where either is there.

    Raises RunError where this machine would make another key, and all that measuring raises.
    """
    check_key(build)
    if build.path(out).is_file() or build.planned(out) is not None:
        return
    subject = Subject(build.request, lambda _: None, lambda _: None)
    planned = plan_build(subject, least=LEAST, threads=threads)
    if planned is None:
        entry = measure_build(build.shot, build.technique, subject, threads=threads)
        check_unchanged(build.inputs, when="while it was measured")
        keep(out / STORE, build.key, entry)
    else:
        check_unchanged(build.inputs, when="while it was measured")
        _write(build.plan_path(out), planned)


def measure_part(part: BuildPart, out: Path, threads: int | None) -> None:
    """Write what there is in a part of a build; nothing where that is there. Raises as `measure_into` does."""
    build = part.build
    check_key(build)
    if build.path(out).is_file() or part.path(out).is_file():
        return
    found = look_at(_load(build.plan_path(out)), part.part, threads=threads)
    check_unchanged(build.inputs, when="while it was measured")
    _write(part.path(out), found)


def join_build(build: Build, out: Path) -> None:
    """Write the entry of a build whose parts are all measured, and let these go. Raises as `measure_into` does."""
    check_key(build)
    parts = build.parts(out)
    if not build.path(out).is_file():
        entry = join_parts(build.shot, build.technique, _load(build.plan_path(out)), _found(parts, out))
        check_unchanged(build.inputs, when="while it was measured")
        keep(out / STORE, build.key, entry)
    for part in parts:
        part.path(out).unlink(missing_ok=True)
    build.plan_path(out).unlink(missing_ok=True)


def check_key(build: Build) -> None:
    """Raise RunError where this machine would make another key."""
    check_keys({build.technique: build.request}, build.inputs, {build.technique: build.key})


def check_keys(requests: Mapping[str, Request], inputs: Inputs, keys: Mapping[str, str]) -> None:
    """Raise RunError where this machine would make other keys of builds."""
    if keys_of_builds(requests, inputs, device="cpu") != keys:
        raise RunError(
            "this machine measures by another version of swimlab, or of what it stands on, or by another $OCIO; "
            "install, and set, the same"
        )


def _found(parts: list[BuildPart], out: Path) -> Iterator[Found]:
    for part in parts:
        yield from _load(part.path(out))


def _write(path: Path, value: Planned | list[Found]) -> None:
    with replacing(path) as temporary, temporary.open("wb") as file:
        pickle.dump(value, file, protocol=pickle.HIGHEST_PROTOCOL)


def _load(path: Path) -> Any:
    with path.open("rb") as file:
        return pickle.load(file)
