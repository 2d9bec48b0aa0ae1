"""What CI does about tests that are skipped."""

import os
import subprocess
import sys
from pathlib import Path

import pytest

TESTS = """
import pytest

@pytest.mark.may_skip("no machine of ours has one")
@pytest.mark.skipif(True, reason="no tea machine")
def test_tea(): ...

@pytest.mark.skipif(True, reason="no browser")
def test_page(): ...

@pytest.mark.xfail
def test_known(): assert False

def test_good(): ...
"""


@pytest.mark.parametrize(("ci", "counts"), [("", "2 skipped"), ("true", "1 passed, 1 skipped, 1 xfailed, 1 error")])
def test_a_skip_without_a_reason_in_its_marker_fails_in_ci(tmp_path: Path, ci: str, counts: str) -> None:
    (tmp_path / "test_it.py").write_text(TESTS, encoding="utf-8")
    (tmp_path / "pytest.ini").write_text("[pytest]\nmarkers =\n    may_skip(reason): why\n", encoding="utf-8")
    words = [sys.executable, "-m", "pytest", "-p", "skips", "-p", "no:cacheprovider", "-p", "no:swimlab", str(tmp_path)]
    environment = os.environ | {"SWIMLAB_NO_SKIPS": ci, "PYTHONPATH": str(Path(__file__).parent)}
    ended = subprocess.run(words, env=environment, cwd=tmp_path, capture_output=True, text=True, check=False)
    assert counts in ended.stdout, ended.stdout + ended.stderr
    assert ended.returncode == (1 if ci else 0)
    assert ("without the marker may_skip" in ended.stdout and "no browser" in ended.stdout) == bool(ci)
