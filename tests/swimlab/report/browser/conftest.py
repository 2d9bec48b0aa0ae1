"""A report of a small run, as a page and as a folder, and a headless Chromium to open it in."""

import shutil
import sys
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import pytest
from playwright.sync_api import Browser, Page, sync_playwright
from report_runs import WORST, make_run, make_scores
from viewer_page import LAPTOP, settle

from swimlab.report.page import write_report, write_report_folder


@pytest.fixture(scope="module")
def run(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return make_run(tmp_path_factory.mktemp("run"))


@pytest.fixture(scope="module")
def scores() -> dict[str, Any]:
    """As of `make_scores`, with an error that is greatest in frame WORST, and tsl the technique to pick."""
    made = make_scores()
    for entry in made["sequences"]:
        entry["scores"]["budget.mse"] /= 4 if entry["technique"] == "tsl" else 1
        for row in entry["frames"]:
            row["mse"] = 0.04 if row["frame"] == WORST else 0.01
    return made


@pytest.fixture(scope="module")
def report(run: Path, scores: dict[str, Any]) -> str:
    """The address of the page."""
    write_report([run], scores, run / "report.html")
    return (run / "report.html").as_uri()


@pytest.fixture(scope="module")
def folder(run: Path, scores: dict[str, Any]) -> Path:
    write_report_folder([run], scores, run / "report")
    return run / "report"


@pytest.fixture(scope="module")
def browser(request: pytest.FixtureRequest) -> Iterator[Browser]:
    """Closed with its module: while it is there, its event loop is in the way of any other."""
    chromium = shutil.which("chromium")
    if chromium is None:
        if sys.platform != "linux":
            request.node.add_marker(pytest.mark.may_skip("CI has a chromium on Linux alone"))
        pytest.skip("chromium is not installed")
    with sync_playwright() as playwright:
        arguments = ["--no-sandbox", "--force-color-profile=srgb"]
        launched = playwright.chromium.launch(executable_path=chromium, args=arguments)
        yield launched
        launched.close()


@pytest.fixture
def visit(browser: Browser) -> Iterator[Callable[..., Page]]:
    """Open an address; at the end, refuse any message, error or request that leaves the file system."""
    complaints: list[str] = []
    contexts = []

    def note_request(address: str) -> None:
        if not address.startswith(("file:", "data:")):
            complaints.append(address)

    def visit(address: str, *, prepare: Callable[[Page], None] = lambda _: None, **options: Any) -> Page:
        context = browser.new_context(**(LAPTOP | options))
        contexts.append(context)
        page = context.new_page()
        page.on("console", lambda message: complaints.append(message.text))
        page.on("pageerror", lambda error: complaints.append(str(error)))
        page.on("request", lambda request: note_request(request.url))
        prepare(page)
        page.goto(address)
        page.evaluate("document.getElementById('viewer').scrollIntoView()")
        settle(page)
        return page

    yield visit
    for context in contexts:
        context.close()
    assert complaints == []
