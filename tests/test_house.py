"""CONTRIBUTING's table of rooms is true."""

import re
import tomllib
from pathlib import Path

ROOT = Path(__file__).parents[1]


def test_the_table_lists_the_folders_and_the_layers() -> None:
    text = (ROOT / "CONTRIBUTING.md").read_text(encoding="utf-8")
    listed = re.findall(r"^\| `(\w+)/` \| ", text.partition("The rooms of")[2], re.MULTILINE)
    contracts = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))["tool"]["importlinter"][
        "contracts"
    ]
    layers = next(each["layers"] for each in contracts if each.get("containers") == ["swimlab"])
    assert [room for layer in layers for room in sorted(layer.split(" | "))] == [
        room for layer in layers for room in sorted(listed) if room in layer.split(" | ")
    ]
    order = [next(i for i, layer in enumerate(layers) if room in layer.split(" | ")) for room in listed]
    assert order == sorted(order)
    assert set(listed) == {path.parent.name for path in (ROOT / "swimlab").glob("*/__init__.py")}
