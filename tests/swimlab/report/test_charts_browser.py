"""The charts in a headless Chromium: marks are read by mouse, touch and keys; names show and hide; maps one by one."""

import json
import shutil
import sys
from collections.abc import Iterator
from pathlib import Path

import pytest
from playwright.sync_api import Page, sync_playwright
from report_runs import make_run, make_scores

from swimlab.report.page import write_report

CHROMIUM = shutil.which("chromium")
pytestmark = [pytest.mark.skipif(CHROMIUM is None, reason="chromium is not installed")]
if sys.platform != "linux":
    pytestmark.append(pytest.mark.may_skip("CI has a chromium on Linux alone"))

SPEED = "figure:has(h4:text-is('Error against time'))"
CHANGE = "figure:has(h4:text-is('Flicker over time'))"


@pytest.fixture(scope="module")
def report(tmp_path_factory: pytest.TempPathFactory) -> Path:
    scores = make_scores()
    for item in scores["sequences"]:
        item["curves"]["budget.strip"] = {"frequency": [0.0, 0.25], "error": [[0.1] * 6, [0.2] * 6]}
    run = make_run(tmp_path_factory.mktemp("run"))
    record = json.loads((run / "run.json").read_text(encoding="utf-8"))
    record["times"]["tsl"]["ms_per_frame"] = 50.0
    (run / "run.json").write_text(json.dumps(record), encoding="utf-8")
    write_report([run], scores, run / "report.html")
    return run / "report.html"


@pytest.fixture
def page(report: Path) -> Iterator[Page]:
    """The report on a phone that has keys; every complaint of the browser fails the test."""
    with sync_playwright() as tools:
        browser = tools.chromium.launch(executable_path=CHROMIUM, args=["--no-sandbox"])
        opened = browser.new_page(viewport={"width": 360, "height": 740}, has_touch=True)
        complaints: list[str] = []
        opened.on("pageerror", lambda error: complaints.append(str(error)))
        opened.on("console", lambda said: complaints.append(said.text) if said.type == "error" else None)
        opened.goto(report.as_uri())
        yield opened
        browser.close()
    assert complaints == []


def test_a_mark_is_read_by_touch_mouse_and_keys(page: Page) -> None:
    says = page.locator(f"{SPEED} .says")
    page.locator(f"{SPEED} .dot").first.tap()
    assert says.inner_text() == "pixel-point: 0.2 at 12.5, on the front"
    page.locator(f"{SPEED} svg").first.focus()
    page.keyboard.press("ArrowRight")
    assert says.inner_text() == "tsl: 0.2 at 50"
    page.keyboard.press("ArrowLeft")
    assert says.inner_text().startswith("pixel-point")
    page.keyboard.press("Escape")
    assert says.inner_text() == ""
    page.locator(f"{CHANGE} g[data-name=tsl] circle").nth(2).dispatch_event("pointerover")
    assert page.locator(f"{CHANGE} .says").inner_text() == "tsl: 0.173 at 3"


def test_the_arrow_keys_of_a_chart_leave_the_viewer_alone(page: Page) -> None:
    before = page.locator("#frame-number").inner_text()
    page.locator(f"{SPEED} svg").first.focus()
    page.keyboard.press("ArrowRight")
    assert page.locator("#frame-number").inner_text() == before


def test_chosen_names_alone_are_shown_in_every_chart(page: Page) -> None:
    button = page.locator(f"{CHANGE} button[data-name=tsl]")
    button.click()
    assert button.get_attribute("aria-pressed") == "true"
    for chart in (SPEED, CHANGE):
        assert page.locator(f"{chart} g[data-name=tsl]").first.is_visible()
        assert not page.locator(f"{chart} g[data-name=pixel-point]").first.is_visible()
    button.click()
    assert page.locator(f"{SPEED} g[data-name=pixel-point]").first.is_visible()


def test_pointing_at_a_name_lets_the_others_fade(page: Page) -> None:
    page.locator(f"{CHANGE} button[data-name=tsl]").hover()
    assert page.locator(f"{CHANGE} g.faint").evaluate_all("all => all.map((one) => one.dataset.name)") == [
        "pixel-point"
    ]
    page.mouse.move(0, 0)
    assert page.locator("g.faint").count() == 0


def test_one_technique_has_its_maps_shown(page: Page) -> None:
    parts = page.locator(".maps [data-technique]")
    assert parts.count() == 2
    for name in ("tsl", "pixel-point"):
        page.select_option("select.technique", name)
        shown = parts.evaluate_all("all => all.filter((one) => one.offsetHeight).map((one) => one.dataset.technique)")
        assert shown == [name]


def test_swatches_are_dashed_as_the_lines_are(page: Page) -> None:
    """In tables, cards and keys: the dash of every line of a technique is that of all its swatches."""
    dashes = page.evaluate("""() => {
        const found = {};
        const all = (selector) => [...document.querySelectorAll(selector)];
        const add = (name, path) => (found[name] ??= new Set()).add(
          `${path.getAttribute('stroke')} ${path.getAttribute('stroke-dasharray') ?? ''}`);
        const named = all('#scores tbody th, .chosen, figure:has(.line) .key button');
        for (const one of named) add(one.textContent.trim(), one.querySelector('path'));
        for (const line of all('path.line')) add(line.parentElement.dataset.name, line);
        return Object.fromEntries(Object.entries(found).map(([name, inks]) => [name, inks.size]));
    }""")
    assert dashes["tsl"] == dashes["pixel-point"] == 1


def test_nothing_is_wider_than_a_phone(page: Page) -> None:
    assert page.evaluate("document.documentElement.scrollWidth") <= 360
