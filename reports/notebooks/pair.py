"""Write NAME.ipynb for every NAME.py of this folder: the same cells, without outputs and without a trace of a machine.

python reports/notebooks/pair.py
"""

from pathlib import Path

import jupytext
import nbformat

FOLDER = Path(__file__).parent
METADATA = {
    "jupytext": {"formats": "ipynb,py:percent"},
    "kernelspec": {"display_name": "Python 3", "language": "python", "name": "python3"},
    "language_info": {"name": "python"},
}


def sources() -> list[Path]:
    """The notebooks' scripts, in order."""
    return sorted(FOLDER.glob("[0-9]*.py"))


def notebook(script: Path) -> str:
    """The content of the .ipynb file of a py:percent script; the same bytes for the same script."""
    read = jupytext.reads(script.read_text(encoding="utf-8"), fmt="py:percent")
    for place, cell in enumerate(read.cells):
        cell.id = f"{script.stem}-{place:02d}"
        cell.metadata = {}
    read.metadata = METADATA
    read.nbformat, read.nbformat_minor = 4, 5
    return nbformat.writes(read, version=4) + "\n"


if __name__ == "__main__":
    for script in sources():
        script.with_suffix(".ipynb").write_text(notebook(script), encoding="utf-8")
