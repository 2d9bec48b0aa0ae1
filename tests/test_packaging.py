"""The wheel: exactly three packages at its top level, with their data, and what the tests run against."""

import subprocess
import sys
import zipfile
from pathlib import Path

import pytest

import swimlab

ROOT = Path(__file__).parents[1]


@pytest.fixture(scope="module")
def contents(tmp_path_factory):
    folder = tmp_path_factory.mktemp("wheel")
    words = ["build", "--wheel", "--no-isolation", "--outdir", str(folder), str(ROOT)]
    subprocess.run([sys.executable, "-m", *words], check=True, capture_output=True)
    (wheel,) = folder.glob("*.whl")
    return zipfile.ZipFile(wheel).namelist()


def test_the_top_level_is_exactly_three_packages(contents):
    top = {name.split("/")[0] for name in contents if ".dist-info/" not in name}
    assert top == {"swimlab", "sequences", "metrics"}


@pytest.mark.parametrize(
    "name",
    [
        "sequences/library/road-shift.toml",
        "swimlab/report/templates/report.html",
        "swimlab/report/static/viewer.js",
        "swimlab/py.typed",
    ],
)
def test_data_files_are_packed(contents, name):
    assert name in contents


def test_every_source_file_is_packed(contents):
    sources = [path for package in ("swimlab", "sequences", "metrics") for path in (ROOT / package).rglob("*.py")]
    assert {path.relative_to(ROOT).as_posix() for path in sources} <= set(contents)


def test_tests_import_one_installation_of_all_three_packages():
    import metrics
    import sequences

    homes = {Path(package.__file__).parents[1] for package in (swimlab, sequences, metrics)}
    assert len(homes) == 1
