"""The report in a headless Chromium: links, motion, phone, colour schemes and the report in a folder."""

import copy
import re
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from playwright.sync_api import CDPSession, Page
from report_runs import FRAMES, TECHNIQUES, WORST, make_run, make_scores
from viewer_page import PHONE, PIXEL, canvas, inset, place_of, settle, shown, truth

from swimlab.report.page import write_report

VIEW = "#clip=0&a=pixel-point&b=tsl&frame=3&flip=0&split=1&heat=1&ev=1&zoom=2.5&x=0.4&y=0.6"


def touch(session: CDPSession, kind: str, *places: tuple[float, float]) -> None:
    """Send a touch event of fingers at the given places."""
    points = [{"x": x, "y": y, "id": n} for n, (x, y) in enumerate(places)]
    session.send("Input.dispatchTouchEvent", {"type": kind, "touchPoints": points})


def middle(page: Page, selector: str) -> tuple[float, float]:
    box = page.locator(selector).bounding_box()
    assert box
    return box["x"] + box["width"] / 2, box["y"] + box["height"] / 2


def test_the_address_restores_the_view(visit: Callable[..., Page], report: str) -> None:
    page = visit(report + VIEW)
    page.keyboard.press("n")
    page.keyboard.press("ArrowRight")
    page.keyboard.press("-")
    page.keyboard.press("z")
    page.keyboard.press("Shift+ArrowLeft")
    page.mouse.move(0, 0)
    settle(page)
    page.wait_for_timeout(300)
    again = visit(page.url)
    of_interest = "(({ a, b, frame, split, heat, exposure }) => [a, b, frame, split, heat, exposure])(state)"
    assert again.evaluate(of_interest) == page.evaluate(of_interest) == ["tsl", "tsl", 4, True, 1, 0.5]
    assert np.abs(canvas(again) - canvas(page)).mean() < 2  # positions are kept to 1/10000 of the picture


def test_a_fresh_view_is_the_pick_as_a_whole(visit: Callable[..., Page], run: Path, scores: dict[str, Any]) -> None:
    told = copy.deepcopy(scores)
    (point,) = (entry for entry in told["sequences"] if entry["technique"] == "pixel-point")
    point["scores"]["budget.mse"] /= 16
    write_report([run], told, run / "picked.html", picture_budget=580_000)
    page = visit((run / "picked.html").as_uri())
    assert page.evaluate("[clip().name.includes('whole'), detailBeside().frames.length > 1]") == [True, True]
    assert page.evaluate("[state.clip, state.a, state.b]") == [0, "pixel-point", "reference"]
    assert page.evaluate("namesBeside()") == ["pixel-point", "reference", "tsl"]
    deep = visit((run / "picked.html").as_uri() + "#clip=0&a=tsl&b=pixel-point&frame=5")
    assert deep.evaluate("[state.clip, state.a, state.b]") == [0, "tsl", "pixel-point"]


def test_a_clip_that_is_chosen_is_seen_whole(visit: Callable[..., Page], run: Path, scores: dict[str, Any]) -> None:
    """Also from the first screen, of which the viewer has the lower edge."""
    write_report([run], scores, run / "small.html", picture_budget=580_000)
    page = visit((run / "small.html").as_uri(), viewport={"width": 1400, "height": 900})
    page.evaluate("window.scrollTo(0, 0)")
    page.select_option("#clip", "0")
    settle(page)
    box, bar = page.locator("#screen").bounding_box(), page.locator(".bar").bounding_box()
    assert box
    assert bar
    assert box["y"] >= 0
    assert box["y"] + box["height"] <= bar["y"] + 1
    at = page.evaluate("layout()")
    assert at["height"] * at["scale"] <= box["height"] + 1


def test_a_bad_address_shows_the_first_view(visit: Callable[..., Page], report: str) -> None:
    page = visit(report + "#clip=9&a=nobody&frame=77&heat=8&ev=-99&zoom=nan&x=4")
    assert page.evaluate("[state.clip, state.a, state.frame, state.heat, state.exposure, state.zoom, state.x]") == [
        *(1, "tsl", 0, 0, -8, 1, 1)
    ]
    page.evaluate("location.hash = '#provenance'")
    settle(page)
    assert page.evaluate("state.a") == "tsl"


def test_a_clip_loops_at_its_own_rate(visit: Callable[..., Page], report: str) -> None:
    page = visit(report, prepare=lambda page: page.clock.install())
    page.evaluate("clip().frames.forEach((_, i) => [state.a, state.b].forEach((name) => picture(0, name, i, false)))")
    page.wait_for_function("clip().frames.every((_, i) => isReady(i))")
    page.clock.pause_at("2100-01-01")
    page.keyboard.press("p")
    # Four frames, then eight, at whatever part of a tick of 16 ms the clock was paused.
    page.clock.run_for(148)
    assert page.evaluate("state.frame") == 4
    page.clock.run_for(148)
    assert page.evaluate("state.frame") == (4 + 4) % FRAMES
    page.keyboard.press("p")
    page.clock.run_for(1000)
    assert page.evaluate("state.frame") == 2


def test_a_detail_loops_beside_the_whole_picture(visit: Callable[..., Page], report: str, run: Path) -> None:
    page = visit(report)
    left, top, width, height = page.evaluate("detailBeside().region")
    for place in (2, FRAMES - 1):  # as it comes round
        page.wait_for_function("(place) => loop.frame === place", arg=place)
    page.keyboard.press("d")
    page.evaluate("loop.frame = 4; drawBeside()")
    assert page.inner_text("[data-action=loop]") == "play"
    says = page.inner_text("#inset-says")
    assert f"{width}x{height} px at ({left}, {top}), frame 4 of frames 0 to {FRAMES - 1}" in says
    for name in page.evaluate("namesBeside()"):
        x, y = page.evaluate(
            """(name) => { const at = panelsBeside(), [, left, top] = at.places.find(([one]) => one === name);
            return [left + (at.width - 1.5) * at.scale, top + (at.height - 1.5) * at.scale]; }""",
            name,
        )
        corner = (left + width - 2, top + height - 2)
        assert inset(page)[int(y), int(x)].tolist() == truth(run, name, 4, corner)
    page.click("#inset", position={"x": x, "y": y})
    settle(page)
    assert page.evaluate("[Boolean(clip().region), state.a]") == [True, name]
    assert page.locator("#beside").is_hidden()


def test_who_wants_no_motion_gets_none(visit: Callable[..., Page], report: str) -> None:
    page = visit(report, reduced_motion="reduce")
    assert page.evaluate("[loop.running, loop.frame]") == [False, 0]


def test_frames_are_scrubbed(visit: Callable[..., Page], report: str, run: Path) -> None:
    page = visit(report)
    page.locator("#frame").fill("4")
    assert shown(page) == truth(run, "tsl", 4)
    assert page.inner_text("#frame-number") == "4"
    page.locator("#fps").fill("12")
    page.locator("#fps").press("Enter")
    assert page.evaluate("state.fps") == 12


def test_a_worst_region_is_linked_to_the_viewer(visit: Callable[..., Page], report: str) -> None:
    page = visit(report)
    link = page.locator("figure:has(h4:text-is('Worst errors')) svg a").filter(has_text="tsl")
    x, y = map(int, re.findall(r"at \((\d+), (\d+)\)", link.text_content() or "")[0])
    link.click()
    settle(page)
    assert page.evaluate("[state.clip, state.a, clip().frames[state.frame]]") == [0, "tsl", WORST]
    left, top = place_of(page, (x, y))
    box = page.locator("#screen").bounding_box()
    assert box
    assert (left >= 0, top >= 0, left < box["width"], top < box["height"]) == (True,) * 4
    assert -1 <= box["y"] < 900  # places of boxes are rounded


def test_worst_of_all_goes_to_another_clip(visit: Callable[..., Page], run: Path, scores: dict[str, Any]) -> None:
    write_report([run], scores, run / "small.html", picture_budget=580_000)
    page = visit((run / "small.html").as_uri() + "#clip=0")
    clips = page.evaluate("data.clips.map((item) => item.frames)")
    assert clips[0] == [FRAMES - 1]
    assert page.locator("#beside").is_visible()
    assert WORST in clips[1]
    page.keyboard.press("w")
    assert page.evaluate("[state.clip, state.frame]") == [0, 0]
    settle(page)
    assert f"its worst of all is frame {WORST}" in page.inner_text("#status")
    page.keyboard.press("p")
    settle(page)
    assert "this clip has one frame" in page.inner_text("#status")
    page.keyboard.press("Shift+W")
    settle(page)
    assert page.evaluate("[state.clip, clip().frames[state.frame]]") == [1, WORST]
    assert "its worst frame" in page.inner_text("#status")
    page.select_option("#clip", "0")
    settle(page)
    assert page.evaluate("state.clip") == 0


def test_a_run_without_reference_has_nothing_to_hold(visit: Callable[..., Page], tmp_path: Path) -> None:
    run = make_run(tmp_path, techniques=("tsl", "lean"))
    write_report([run], make_scores(techniques=("tsl", "lean")), tmp_path / "report.html")
    page = visit((tmp_path / "report.html").as_uri())
    assert page.locator("[data-hold]").is_disabled()
    assert page.locator("[data-action=heat]").is_disabled()
    page.keyboard.press("r")
    page.keyboard.press("h")
    assert shown(page) == truth(run, "tsl")


@pytest.mark.parametrize("scheme", ["light", "dark"])
def test_colours_follow_the_system_until_chosen(visit: Callable[..., Page], report: str, scheme: str) -> None:
    page = visit(report, color_scheme=scheme)
    paper = "getComputedStyle(document.body).backgroundColor"
    colours = {"light": "rgb(255, 255, 255)", "dark": "rgb(21, 23, 26)"}
    assert page.evaluate(paper) == colours[scheme]
    for theme, expected in [("light", colours["light"]), ("dark", colours["dark"])]:
        page.click("#theme")
        assert page.inner_text("#theme") == f"theme: {theme}"
        assert page.evaluate(paper) == expected
    page.reload()
    assert page.inner_text("#theme") == "theme: dark"
    page.click("#theme")
    assert page.inner_text("#theme") == "theme: auto"
    assert page.evaluate(paper) == colours[scheme]


def test_a_phone_needs_neither_keys_nor_sideways_scrolling(
    visit: Callable[..., Page], report: str, run: Path, tolerance: Callable[[str], float]
) -> None:
    page = visit(report, **PHONE)
    fingers = page.context.new_cdp_session(page)
    assert page.evaluate("document.documentElement.scrollWidth") <= PHONE["viewport"]["width"]
    for button in page.locator(".bar button").all():
        box = button.bounding_box()
        assert box
        assert box["height"] >= 40
        assert box["y"] + box["height"] <= PHONE["viewport"]["height"]
    page.tap("[data-action=flip]")
    assert shown(page) == truth(run, "reference")
    page.tap("[data-action=flip]")
    touch(fingers, "touchStart", middle(page, "[data-hold]"))
    assert shown(page) == truth(run, "reference")
    touch(fingers, "touchEnd")
    assert shown(page) == truth(run, "tsl")
    page.tap("[data-action=split]")
    assert shown(page, panel=0) == truth(run, "tsl")
    assert shown(page, panel=1) == truth(run, "reference")
    assert place_of(page, PIXEL, 1)[0] == pytest.approx(place_of(page, PIXEL, 0)[0])
    page.tap("[data-action=split]")
    settle(page)
    x, y = middle(page, "#screen")
    touch(fingers, "touchStart", (x - 20, y), (x + 20, y))
    touch(fingers, "touchMove", (x - 40, y), (x + 40, y))
    touch(fingers, "touchEnd")
    settle(page)
    assert page.evaluate("state.zoom") == pytest.approx(2, rel=tolerance("a pinch"))
    assert page.inner_text("#readout").startswith("pixel (")


def test_a_phone_shows_flicker_and_what_scores_mean_at_once(visit: Callable[..., Page], report: str) -> None:
    page = visit(report, **PHONE)
    width = PHONE["viewport"]["width"]
    heading = page.locator(".scores th", has_text=re.compile("^flicker$")).first.bounding_box()
    assert heading
    assert heading["x"] + heading["width"] <= width
    for table in page.locator(".glossary").all():
        box = table.bounding_box()
        assert box
        assert box["x"] + box["width"] <= width


def test_a_folder_shows_what_the_page_shows(visit: Callable[..., Page], report: str, folder: Path) -> None:
    page, other = visit(report + VIEW), visit((folder / "index.html").as_uri() + VIEW)
    assert np.array_equal(canvas(page), canvas(other))
    for key in ("h", "h", "ArrowRight", "s", " "):
        page.keyboard.press(key)
        other.keyboard.press(key)
        settle(page)
        settle(other)
        assert np.array_equal(canvas(page), canvas(other))


def test_memory_is_bounded_and_pictures_come_back(visit: Callable[..., Page], folder: Path, run: Path) -> None:
    page = visit((folder / "index.html").as_uri())
    page.keyboard.press("d")
    settle(page)
    bytes_kept = "Array.from(kept.values()).reduce((sum, [, bytes]) => sum + bytes, 0)"
    assert page.evaluate("keptBytes") == page.evaluate(bytes_kept) <= page.evaluate("KEPT_BYTES")
    page.evaluate("keep('huge', null, KEPT_BYTES)")
    assert page.evaluate("[kept.size, keptBytes === KEPT_BYTES]") == [1, True]
    page.evaluate("forget('huge')")
    assert page.evaluate("keptBytes") == 0
    page.keyboard.press(" ")
    assert shown(page) == truth(run, "reference")


def test_a_lost_picture_is_named_and_the_rest_works(
    visit: Callable[..., Page], run: Path, folder: Path, tmp_path: Path
) -> None:
    name = f"pictures/0/{TECHNIQUES[0]}.0003.js"
    script = (folder / name).read_text(encoding="utf-8")
    (folder / name).write_text("", encoding="utf-8")
    page = visit((folder / "index.html").as_uri() + f"#clip=0&a={TECHNIQUES[0]}&b=tsl&frame=3")
    assert page.evaluate("failed.size") == 1
    page.keyboard.press(" ")
    assert shown(page) == truth(run, "tsl", 3)
    (folder / name).write_text(script, encoding="utf-8")
