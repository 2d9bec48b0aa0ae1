"""The documentation as its readers have it: pages with blocks, and a reader who does what they say, small and quick."""

import contextlib
import importlib.util
import io
import json
import os
import re
import shlex
import subprocess
import sys
import tomllib
from collections.abc import Iterator
from dataclasses import dataclass, replace
from itertools import islice
from pathlib import Path
from typing import Any

import pytest
import yaml

from metrics import registry
from swimlab.cli.main import app, main
from swimlab.render.plan import Plan, make_plan
from swimlab.studies.selftest import checks

ROOT = Path(__file__).parents[1]
NOT_RUN = "Not run in the tests: "
FENCE = re.compile(r"^```(\w+)(?: title=\"([^\"\n]*)\")?\n(.*?)^```$", re.MULTILINE | re.DOTALL)
SETUP = re.compile(r"(python3? -m venv|\. \.venv/bin/activate|(python3? -m )?pip install|make )")
"""What a reader does once; it is looked at, and not done."""

SIZE, FRAMES, SAMPLES, TECHNIQUES = (96, 54), 8, 16, 4
"""As much as the tests render of what a page renders."""

CHECKS = 2
"""So many checks of `swimlab selftest`, which has tests of its own."""


@dataclass(frozen=True)
class Block:
    """A block of code of a page. title: what a reader sees above it: the file that it is, or why it is not run."""

    page: str
    language: str
    title: str
    text: str


def pages() -> list[str]:
    """Every page with blocks, by its path in the repository."""
    written = (ROOT / "docs").rglob("*.md")
    engines = (ROOT / "reports" / "engines").rglob("*.md")
    found = [ROOT / "README.md", ROOT / "CONTRIBUTING.md", *written, *engines]
    kept = [path for path in found if "node_modules" not in path.parts]
    return sorted(path.relative_to(ROOT).as_posix() for path in kept)


def blocks(page: str) -> Iterator[Block]:
    """The blocks of a page, in order."""
    for found in FENCE.finditer((ROOT / page).read_text(encoding="utf-8")):
        yield Block(page, found[1], found[2] or "", found[3])


def commands(text: str) -> list[str]:
    """The lines of a shell block, continued ones joined, without comments."""
    lines = [line for line in text.replace("\\\n", " ").splitlines() if line.strip() and line.strip()[0] != "#"]
    return [line.strip() for line in lines]


def check_setup(line: str) -> None:
    """What installs names extras that there are, and what is made by `make` is a target."""
    project = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))["project"]
    for extras in re.findall(r"\[([a-z,]+)\]", line):
        assert set(extras.split(",")) <= set(project["optional-dependencies"]), line
    if line.startswith("make "):
        targets = re.findall(r"^([a-z]+):", (ROOT / "Makefile").read_text(encoding="utf-8"), re.MULTILINE)
        assert line.split()[1] in targets, line


def check_command(line: str) -> None:
    """A command that is not run has options and words that it takes."""
    words = shlex.split(line, comments=True)
    if words[0] == "swimlab":
        app.parse_args(words[1:], exit_on_error=False, print_error=False)
    elif words[0] == "python" and words[1] != "-m":
        assert (ROOT / words[1]).is_file(), line
    else:
        check_setup(line)


class Reader:
    """Does what the blocks of one page say, one after another, in a folder of its own."""

    def __init__(self, folder: Path, patch: pytest.MonkeyPatch) -> None:
        self._patch = patch
        self._names: dict[str, Any] = {"__name__": "page"}
        patch.chdir(folder)
        patch.setenv("COLUMNS", "200")
        for module in ("swimlab.cli.options", "swimlab.notebook.study", "swimlab.gate.outcome"):
            patch.setattr(f"{module}.make_plan", small_plan)
        patch.setattr("swimlab.cli.selftest_command.checks", lambda: islice(checks(), CHECKS))

    def follow(self, block: Block) -> None:
        """Save, run or check a block. Raises AssertionError where it does not do what it says."""
        match block.language, block.title:
            case "sh", title if title.startswith(NOT_RUN):
                for line in commands(block.text):
                    check_command(line)
            case "sh", "":
                for line in commands(block.text):
                    self._run(line)
            case (("toml" | "python"), title) if title:
                self._save(Path(title), block.text)
            case "python", "":
                with contextlib.redirect_stdout(io.StringIO()):
                    exec(compile(block.text, block.page, "exec"), self._names)
            case "yaml", "":
                for line in _runs(yaml.safe_load(block.text)):
                    check_command(line)
            case "json", "":
                json.loads(block.text)
            case (("gdscript" | "text"), _):
                pass
            case _:
                raise AssertionError(f"{block.page}: a block of {block.language} needs a title that says what it is")

    def _save(self, path: Path, text: str) -> None:
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_text(text, encoding="utf-8")
        if path.parts[0] == "metrics":  # a measure, which would be found in the package
            spec = importlib.util.spec_from_file_location(f"metrics.{path.stem}", path)
            module = importlib.util.module_from_spec(spec)
            spec.loader.exec_module(module)
            known = registry._modules
            self._patch.setattr(registry, "_modules", lambda: [*known(), module])
            self._patch.setattr(registry, "METRICS", registry.METRICS | module.SCORES)

    def _run(self, line: str) -> None:
        words = shlex.split(line, comments=True)
        if SETUP.match(line):
            check_setup(line)
        elif words[0] == "swimlab":
            self._swimlab(words, line)
        elif words[:2] == ["python", "-m"] or "=" in words[0]:
            self._elsewhere(words)
        else:
            raise AssertionError(f"{line}: no reader of the tests can do this; give the block a title that says why")

    def _swimlab(self, words: list[str], line: str) -> None:
        words, to = (words[: words.index(">")], words[words.index(">") + 1]) if ">" in words else (words, "")
        out, err, code = io.StringIO(), io.StringIO(), 0
        self._patch.setattr(sys, "argv", words)
        self._patch.setattr("warnings.showwarning", None)  # `main` replaces it
        with contextlib.redirect_stdout(out), contextlib.redirect_stderr(err):
            try:
                main()
            except SystemExit as end:
                code = int(end.code or 0)
        assert code == 0, f"{line}\nends with {code}\n{out.getvalue()}{err.getvalue()}"
        if to:
            Path(to).write_text(out.getvalue(), encoding="utf-8")

    def _elsewhere(self, words: list[str]) -> None:
        """In a process of its own, as large as the page says."""
        given = dict(word.split("=", 1) for word in words if re.match(r"[A-Z_]+=", word))
        rest = [word for word in words if not re.match(r"[A-Z_]+=", word)]
        rest = rest[1:] if rest[0] == "python" else ["-m", *rest]
        ended = subprocess.run(
            [sys.executable, *rest], env=os.environ | given, capture_output=True, text=True, check=False
        )
        assert ended.returncode == 0, f"{words}\n{ended.stdout}{ended.stderr}"


def small_plan(*given: Any, **options: Any) -> Plan:
    """A plan as it was asked for, with fewer and smaller pictures."""
    plan = make_plan(*given, **options)
    width, height = plan.sequence.size
    size = SIZE if width > SIZE[0] or height > SIZE[1] else (width, height)
    names = plan.techniques if len(plan.techniques) <= TECHNIQUES else (*plan.techniques[:2], "reference")
    sequence = plan.sequence.with_changes(size=size)
    samples = min(plan.samples, SAMPLES)
    return replace(plan, sequence=sequence, techniques=names, frames=plan.frames[:FRAMES], samples=samples)


def _runs(tree: Any) -> Iterator[str]:
    if isinstance(tree, dict):
        for key, value in tree.items():
            if key == "run":
                yield from commands(value)
            else:
                yield from _runs(value)
    elif isinstance(tree, list):
        for value in tree:
            yield from _runs(value)
