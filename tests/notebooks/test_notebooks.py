"""The notebooks: in step with their scripts, free of outputs, and true when they are run."""

import importlib.util
import json
import shutil
import subprocess
import sys
from pathlib import Path

import nbformat
import pytest

FOLDER = Path(__file__).parents[2] / "reports" / "notebooks"
NAMES = sorted(path.stem for path in FOLDER.glob("[0-9]*.py"))


@pytest.fixture(scope="module")
def pair():
    spec = importlib.util.spec_from_file_location("pair", FOLDER / "pair.py")
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


def test_every_script_has_a_notebook_and_the_other_way_round(pair):
    assert [path.stem for path in pair.sources()] == NAMES
    assert sorted(path.stem for path in FOLDER.glob("*.ipynb")) == NAMES
    assert len(NAMES) == 6


@pytest.mark.parametrize("name", NAMES)
def test_notebooks_are_what_their_scripts_say(pair, name):
    text = (FOLDER / f"{name}.ipynb").read_text(encoding="utf-8")
    assert text == pair.notebook(FOLDER / f"{name}.py"), "run: python reports/notebooks/pair.py"
    nbformat.validate(json.loads(text))


@pytest.mark.parametrize("name", NAMES)
def test_notebooks_hold_no_outputs(name):
    cells = json.loads((FOLDER / f"{name}.ipynb").read_text(encoding="utf-8"))["cells"]
    code = [cell for cell in cells if cell["cell_type"] == "code"]
    assert code
    assert all(cell["outputs"] == [] and cell["execution_count"] is None for cell in code)


@pytest.mark.parametrize("name", NAMES)
def test_notebooks_run_and_hold(name, tmp_path, monkeypatch):
    """Every assertion in them is true, nothing is said on stderr (where warnings go), and every figure is shown."""
    monkeypatch.setenv("IPYTHONDIR", str(tmp_path / "ipython"))
    monkeypatch.setenv("JUPYTER_RUNTIME_DIR", str(tmp_path / "runtime"))
    copy = tmp_path / f"{name}.ipynb"
    shutil.copy(FOLDER / copy.name, copy)
    execute = [Path(sys.executable).with_name("jupyter-execute"), "--inplace", "--timeout=300", copy]
    ended = subprocess.run(execute, capture_output=True, text=True, check=False)
    assert ended.returncode == 0, ended.stderr
    cells = [cell for cell in json.loads(copy.read_text(encoding="utf-8"))["cells"] if cell["cell_type"] == "code"]
    assert all(cell["execution_count"] for cell in cells)
    outputs = [output for cell in cells for output in cell["outputs"]]
    assert [output["text"] for output in outputs if output.get("name") == "stderr"] == []
    figures = sum("".join(cell["source"]).count("plt.subplots(") for cell in cells)
    assert sum("image/png" in output.get("data", {}) for output in outputs) == figures > 0
