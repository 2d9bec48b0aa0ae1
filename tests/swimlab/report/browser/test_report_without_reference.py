"""Brought frames without a reference, measured and opened: what can be shown without one is there, and nothing else."""

import re
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest
from moving_wall import HEIGHT, WIDTH, moved, picture, write
from playwright.sync_api import Page
from viewer_page import settle

from swimlab.footage.shot import load_shot
from swimlab.report.page import write_report
from swimlab.scoring.brought import measure_brought

COUNT, BAD, SPOT = 6, 4, (70, 50)
SHOT = """
version = 1
name = "wall"
[motion]
frames = "motion/####.exr"
[builds.calm]
frames = "calm/####.exr"
[builds.popping]
frames = "popping/####.exr"
"""


@pytest.fixture(scope="module")
def page_of_builds(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Two builds of a wall that the camera moves past; one brightens at SPOT in frame BAD."""
    folder = tmp_path_factory.mktemp("wall")

    def popping(t: int) -> np.ndarray:
        rgb = picture(t).copy()
        if t == BAD:
            rgb[SPOT[1] : SPOT[1] + 8, SPOT[0] : SPOT[0] + 8] += 6
        return rgb

    write(folder / "calm", picture, count=COUNT)
    write(folder / "popping", popping, count=COUNT)
    write(folder / "motion", moved, ("X", "Y"), count=COUNT)
    (folder / "shot.toml").write_text(SHOT, encoding="utf-8")
    shot = load_shot(folder / "shot.toml")
    scores = measure_brought(shot.requests(folder, "linear"), folder / "run", sequence=shot.name)
    write_report([folder / "run"], scores, folder / "run" / "report.html")
    return folder / "run" / "report.html"


def test_what_can_be_shown_is_there(visit: Callable[..., Page], page_of_builds: Path) -> None:
    page = visit(page_of_builds.as_uri())
    assert page.inner_text("#verdict h2") == "Which build should I ship?"
    assert "calm changes least on the surface" in page.inner_text("#verdict")
    assert "Without a reference no error is known" in page.inner_text("#viewer")
    assert page.evaluate("[state.a, state.b, namesBeside(), detailBeside().frames.length]") == [
        *("calm", "popping", ["calm", "popping"], COUNT)
    ]
    titles = page.locator("#charts h4:visible").all_inner_texts()
    assert {"Flicker over time", "Worst flicker", "Temporal profiles"} <= {*titles}
    assert not {"Error budget", "Worst errors", "Spectrum of the error"} & {*titles}
    assert "needs a reference" in page.inner_text("#scores")
    assert "Motion (fields) fits the frames" in page.inner_text("#scores")
    for section in ("#verdict", "#viewer", "#scores", "#charts"):
        assert "technique" not in page.inner_text(section).lower(), section


def test_the_frame_and_place_that_flicker_are_found(visit: Callable[..., Page], page_of_builds: Path) -> None:
    page = visit(page_of_builds.as_uri())
    page.select_option("#a", "popping")
    page.keyboard.press("w")
    settle(page)
    assert page.evaluate("clip().frames[state.frame]") in (BAD, BAD + 1)
    assert "rms change" in page.inner_text("#status")
    link = page.locator("figure:has(h4:text-is('Worst flicker')) svg a").filter(has_text="popping")
    frame, x, y = map(int, re.findall(r"frame (\d+) at \((\d+), (\d+)\)", link.text_content() or "")[0])
    assert frame in (BAD, BAD + 1)
    assert max(0, SPOT[0] - 60) <= x <= min(SPOT[0], WIDTH - 64)
    assert max(0, SPOT[1] - 60) <= y <= min(SPOT[1], HEIGHT - 64)
    profile = page.locator("figure:has(h4:text-is('Temporal profiles'))")
    assert profile.locator("image").count() == 4
    assert "followed through its vectors" in profile.inner_text()


def test_there_is_no_error_to_show(visit: Callable[..., Page], page_of_builds: Path) -> None:
    page = visit(page_of_builds.as_uri(), viewport={"width": 390, "height": 844})
    assert page.evaluate("document.documentElement.scrollWidth") <= 390
    assert page.locator("[data-hold]").is_disabled()
    assert page.locator("[data-action=heat]").is_disabled()
    page.keyboard.press("h")
    settle(page)
    assert page.locator("#legend-box").is_hidden()
