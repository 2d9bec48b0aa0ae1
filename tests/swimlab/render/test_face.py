"""What a technique's file of your own imports."""

import subprocess
import sys
import textwrap
import time

import pytest

import swimlab
from swimlab import render as face
from swimlab.render.catalogue import techniques
from swimlab.render.plan import make_plan
from swimlab.render.run import render_run
from swimlab.runs.frames import frame_path, read_frame


@pytest.fixture
def example(tmp_path):
    """The example of the docstring, as a file."""
    lines = face.__doc__.partition("names:\n\n")[2].splitlines()
    code = textwrap.dedent("\n".join(line for line in lines[: lines.index("    )") + 1]))
    (tmp_path / "own").mkdir()
    (tmp_path / "own" / "duller.py").write_text(code, encoding="utf-8")
    yield tmp_path / "own"
    swimlab.render.techniques.__path__ = swimlab.render.techniques.__path__[:1]
    techniques.cache_clear()


def test_the_example_of_the_docstring_renders(example, tmp_path):
    assert swimlab.add_techniques(example) == ["duller"]
    plan = make_plan("road-shift", ["duller", "pixel-trilinear"], size=(64, 36), frames="0", samples=4)
    render_run(plan, tmp_path / "run")
    own, given = (read_frame(frame_path(tmp_path / "run", name, 0)) for name in ("duller", "pixel-trilinear"))
    assert (own != given).any()


def test_every_name_is_there():
    assert {name: getattr(face, name) for name in face.__all__}
    with pytest.raises(AttributeError, match="no attribute 'nothing'"):
        _ = face.nothing


def test_another_module_of_the_package_does_not_wait_for_warp():
    code = "import sys, swimlab.render.settings; sys.exit('warp' in sys.modules)"
    assert subprocess.run([sys.executable, "-c", code], check=False).returncode == 0


def test_the_same_sequence_gives_the_same_bytes(tmp_path):
    runs = [tmp_path / "one", tmp_path / "other"]
    for run in runs:
        render_run(make_plan("road-drive", ["tsl", "reference"], size=(48, 27), frames="0-1", samples=4), run)
        # Another second, as OpenImageIO's files carry the date in seconds.
        time.sleep(1.1)
    files = sorted(path.relative_to(runs[0]) for path in runs[0].rglob("*.exr"))
    assert len(files) == 8
    assert all((runs[0] / file).read_bytes() == (runs[1] / file).read_bytes() for file in files)
