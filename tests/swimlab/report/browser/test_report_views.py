"""Pictures brighter than a screen in the viewer: their radiance, and the views of it that can be chosen."""

from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from playwright.sync_api import Page
from report_runs import FRAMES, TECHNIQUES, make_run, make_scores
from viewer_page import PIXEL, point, rendered, settle, shown

from metrics.display import Display
from swimlab.report.display import srgb
from swimlab.report.page import write_report
from swimlab.runs.frames import frame_path, read_frame, write_frame


@pytest.fixture(scope="module")
def bright(tmp_path_factory: pytest.TempPathFactory, scores: dict[str, Any]) -> Path:
    """A run whose pictures go up to 24."""
    run = make_run(tmp_path_factory.mktemp("bright"))
    for name in TECHNIQUES:
        for frame in range(FRAMES):
            rgba = read_frame(frame_path(run, name, frame))
            rgba[..., :3] *= 30
            write_frame(frame_path(run, name, frame), rgba, half=False, metadata={})
    write_report([run], scores, run / "report.html")
    return run


@pytest.mark.parametrize("tone", ["none", "reinhard", "aces"])
def test_a_view_shows_what_the_display_domain_sends(
    visit: Callable[..., Page], bright: Path, tone: str, tolerance: Callable[[str], float]
) -> None:
    page = visit((bright / "report.html").as_uri())
    page.select_option("#tone", tone)
    for _ in range(6):
        page.keyboard.press("-")
    radiance = rendered(bright, "tsl", 0)[PIXEL[1], PIXEL[0], :3]
    assert radiance.max() > 1
    expected = 255 * Display(exposure=-3, tone_map=tone).curve(radiance)
    assert shown(page) == pytest.approx(expected, abs=tolerance("a wide code seen"))
    page.wait_for_timeout(300)
    assert visit(page.url).evaluate("state.tone") == tone


def test_radiance_above_one_is_read_and_reset_returns_to_the_first_view(
    visit: Callable[..., Page], bright: Path, tolerance: Callable[[str], float]
) -> None:
    page = visit((bright / "report.html").as_uri())
    point(page, PIXEL)
    words = page.inner_text("#readout").splitlines()[1].split()
    radiance = rendered(bright, "tsl", 0)[PIXEL[1], PIXEL[0], :3]
    assert [float(word) for word in words[2:5]] == pytest.approx(radiance, rel=tolerance("a wide code"))
    assert "hold radiance up to 200" in page.inner_text("#viewer")
    assert shown(page) == pytest.approx(srgb(radiance), abs=tolerance("a wide code seen"))
    page.select_option("#tone", "aces")
    page.keyboard.press("0")
    settle(page)
    assert page.evaluate("state.tone") == page.input_value("#tone") == "none"


def test_the_first_view_is_that_of_the_scores(visit: Callable[..., Page], bright: Path) -> None:
    scores = make_scores()
    for entry in scores["sequences"]:
        entry["display"] = {"tone_map": "reinhard"}
    write_report([bright], scores, bright / "display.html")
    page = visit((bright / "display.html").as_uri())
    assert page.input_value("#tone") == "reinhard"
    assert np.ptp(shown(page)) > 0
