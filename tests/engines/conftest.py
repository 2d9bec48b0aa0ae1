"""The examples of `reports/engines`, loaded from their scripts."""

import importlib.util
import json
from collections.abc import Callable
from pathlib import Path
from types import ModuleType
from typing import Any

import pytest

ENGINES = Path(__file__).parents[2] / "reports" / "engines"


@pytest.fixture(scope="session")
def example() -> Callable[[str], ModuleType]:
    """An example's `run.py`, by the name of its folder."""

    def load(name: str) -> ModuleType:
        spec = importlib.util.spec_from_file_location(f"{name}_example", ENGINES / name / "run.py")
        assert spec
        assert spec.loader
        module = importlib.util.module_from_spec(spec)
        with pytest.MonkeyPatch.context() as patch:  # as Python does it where a script is run
            patch.syspath_prepend(ENGINES / name)
            spec.loader.exec_module(module)
        return module

    return load


@pytest.fixture(scope="session")
def entries() -> Callable[[Path], dict[str, Any]]:
    """What scores.json of a drawn shot says, by build."""

    def entries(folder: Path) -> dict[str, Any]:
        scores = json.loads((folder / "run" / "scores.json").read_text(encoding="utf-8"))
        return {entry["technique"]: entry for entry in scores["sequences"]}

    return entries
