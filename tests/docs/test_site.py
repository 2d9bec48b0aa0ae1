"""The site builds strictly, has a page for everything there is, and asks no other machine for anything."""

import html
import os
import re
import shutil
import subprocess
import sys
from importlib.util import find_spec
from pathlib import Path

import pytest
from playwright.sync_api import sync_playwright

from metrics import METRICS
from metrics.bands import BANDS
from swimlab.cli.main import COMMANDS
from swimlab.footage.convention import PRESETS
from swimlab.render.catalogue import brdfs, techniques

ROOT = Path(__file__).parents[2]
LOADED = re.compile(
    r"<(?:script|img|iframe|source|video|audio|object|embed)\b[^>]*?(?:src|data)=\"?([^\"\s>]+)|"
    r"<link\b[^>]*?href=\"?([^\"\s>]+)"
)
STYLED = re.compile(r"(?:url\(|@import )[\"']?(?!data:)([^\"')]+)")


def needs(package: str) -> None:
    """Skip where the extra `docs` is not installed; in CI it is."""
    if find_spec(package) is None:
        pytest.skip(f"{package} is not installed: extra 'docs'")


@pytest.fixture(scope="module")
def site(tmp_path_factory) -> Path:
    """Built as `make docs` builds it."""
    needs("mkdocs")
    folder = tmp_path_factory.mktemp("site")
    words = [sys.executable, "-m", "mkdocs", "build", "--strict", "--quiet", "--site-dir", str(folder)]
    environment = os.environ | {"NO_MKDOCS_2_WARNING": "1"}
    built = subprocess.run(words, cwd=ROOT, env=environment, capture_output=True, text=True, check=False)
    assert built.returncode == 0, built.stderr
    return folder


def page(site: Path, name: str) -> str:
    """What a page says, without its tags."""
    return html.unescape(re.sub(r"<[^>]+>", "", (site / name).read_text(encoding="utf-8")))


def test_nothing_is_loaded_from_another_machine(site):
    pages = list(site.rglob("*.html"))
    assert len(pages) > 40
    for path in pages:
        loaded = [first or second for first, second in LOADED.findall(path.read_text(encoding="utf-8"))]
        assert loaded
        assert not [place for place in loaded if "//" in place and not place.startswith("data:")], path
    for path in site.rglob("*.css"):
        assert not [place for place in STYLED.findall(path.read_text(encoding="utf-8")) if "//" in place], path


def test_the_search_works_from_files_and_asks_no_other_machine(site, request):
    """By iframe-worker.js, since a browser starts no worker from a file."""
    if sys.platform != "linux":
        request.node.add_marker(pytest.mark.may_skip("CI has a chromium on Linux alone"))
    chromium = shutil.which("chromium") or pytest.skip("chromium is not installed")
    with sync_playwright() as playwright:
        browser = playwright.chromium.launch(executable_path=chromium, args=["--no-sandbox"])
        page, asked, said = browser.new_page(), [], []
        page.on("request", lambda request: asked.append(request.url))
        page.on("console", lambda message: said.append(message.text))
        page.on("pageerror", lambda error: said.append(str(error)))
        page.goto((site / "index.html").as_uri())
        page.keyboard.press("/")
        page.keyboard.type("jitter")
        page.wait_for_function("/[0-9]+ matching/.test(document.querySelector('.md-search-result__meta').innerText)")
        found = page.locator(".md-search-result__list").inner_text()
        browser.close()
    assert "jitter" in found.lower()
    assert said == []
    assert [address for address in asked if not address.startswith(("file:", "data:", "blob:"))] == []


def test_every_picture_is_there(site):
    for path in site.rglob("*.html"):
        for place in re.findall(r"<img\b[^>]*?src=\"?([^\"\s>]+)", path.read_text(encoding="utf-8")):
            if not place.startswith("data:"):
                assert (path.parent / place).is_file(), (path, place)
    made = {path.name: path.stat().st_size for path in (site / "concepts").iterdir() if path.suffix in (".png", ".svg")}
    assert len(made) >= 10
    assert max(made.values()) < 200_000


def test_every_command_score_and_choice_has_its_place(site):
    said = page(site, "reference/commands.html")
    assert all(f"swimlab {command} " in said for command in (*COMMANDS, "bench speed-error"))
    said = page(site, "reference/catalogue.html")
    assert all(name in said for name in (*techniques(), *brdfs(), *PRESETS))
    said = page(site, "reference/scores.html")
    assert all(name in said for name in METRICS if name.rpartition(".")[2] not in BANDS)


@pytest.mark.parametrize(
    ("kind", "keys"),
    [
        ("sequence", ("scene.sun", "azimuth", "techniques.tsl", 'kind = "drive"', "display.bloom", "anisotropy")),
        ("shot", ("builds.NAME", "colorspace", "jitter_in", "pixels_per_degree")),
        ("gate", ("[[rule]]", "max_increase", "noise_sigma", "missing")),
        ("sweep", ("chunk", "grid", "techniques")),
    ],
)
def test_every_key_of_a_file_has_its_place(site, kind, keys):
    said = page(site, f"reference/{kind}-file.html")
    assert all(key in said for key in keys)


def test_the_python_interface_is_explained(site):
    said = page(site, "reference/api/swimlab.html")
    assert "Render techniques of a sequence beside the reference" in said
    said = page(site, "reference/api/metrics.html")
    assert "Measure a test clip, against a reference if there is one." in said
    assert "Sequence files that come with the package" in page(site, "reference/api/sequences.html")


@pytest.mark.parametrize("name", [name for name in METRICS if name.rpartition(".")[2] not in BANDS])
def test_every_score_has_a_formula_and_a_test_that_checks_it(name, monkeypatch):
    monkeypatch.syspath_prepend(ROOT / "docs" / "made")
    import scores

    assert METRICS[name].formula
    assert scores.checks()[name], f"mark a test of {name} with @pytest.mark.checks"


def test_tests_check_scores_that_there_are(monkeypatch):
    monkeypatch.syspath_prepend(ROOT / "docs" / "made")
    import scores

    assert set(scores.checks()) <= set(METRICS)


def test_a_docstrings_items_become_a_list(monkeypatch):
    monkeypatch.syspath_prepend(ROOT / "docs" / "made")
    needs("griffe")
    import docstrings

    text = (
        "What it is.\n\nsize: width and height,\n    px. x, y: places. Other: is no name. Raises ValueError\nfor none."
    )
    items = "- `size`: width and height, px.\n- `x`, `y`: places. Other: is no name."
    wanted = f"What it is.\n\n{items}\n\nRaises ValueError for none."
    assert docstrings.as_markdown(text, ["size", "x", "y"]) == wanted
    assert docstrings.as_markdown(text, []) == text


def test_the_glossary_is_in_order_and_each_term_stands_once():
    text = (ROOT / "docs" / "reference" / "glossary.md").read_text(encoding="utf-8")
    terms = re.findall(r"^(\S.*)\n:   ", text, re.MULTILINE)
    assert len(terms) > 50
    assert [term.lower() for term in terms] == sorted({term.lower() for term in terms})


def test_charts_that_are_explained_are_those_of_the_report():
    guide = (ROOT / "docs" / "guides" / "report.md").read_text(encoding="utf-8").partition("## Charts")[2]
    named = [name for row in re.findall(r"^\| ([A-Z][^|]*) \|", guide, re.MULTILINE) for name in row.split("; ")]
    drawn = "".join(path.read_text(encoding="utf-8") for path in (ROOT / "swimlab" / "report").rglob("*.py"))
    assert len(named) > 10
    assert [name for name in named if name not in drawn] == []


def test_the_readme_is_short():
    assert len((ROOT / "README.md").read_text(encoding="utf-8").splitlines()) <= 150


def test_links_of_written_pages_lead_to_files():
    for path in (ROOT / "README.md", ROOT / "CONTRIBUTING.md", *(ROOT / "reports" / "engines").glob("*.md")):
        for target in re.findall(r"\]\(([^)#\s]+)", path.read_text(encoding="utf-8")):
            if ":" not in target:
                assert (path.parent / target).exists(), (path, target)
