"""The examples of `reports/engines`, loaded from their scripts."""

import importlib.util
from collections.abc import Callable
from pathlib import Path
from types import ModuleType

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
