"""The report's viewer in a headless Chromium: every control changes what it should."""

from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest
from playwright.sync_api import Page
from report_runs import FRAMES, SIZE, WORST
from viewer_page import PIXEL, canvas, error_at, place_of, point, rendered, settle, shown, truth

from swimlab.report.display import ERROR_RANGE, srgb

FRESH = "#clip=0&a=tsl&b=reference&frame=0&flip=0&split=0&heat=0&ev=0&zoom=4&x=0.5&y=0.5"

# What a control changes: its action, the key for it, and what must hold afterwards in the state of a fresh viewer.
CONTROLS = [
    ("flip", " ", "state.flipped"),
    ("heat", "h", "state.heat === 1"),
    ("split", "s", "state.split"),
    ("previous", "ArrowLeft", f"state.frame === {FRAMES - 1}"),
    ("play", "p", "state.playing"),
    ("loop", "d", "!loop.running"),
    ("next", "ArrowRight", "state.frame === 1"),
    ("worst", "w", f"state.frame === {WORST}"),
    ("worstOfAll", "Shift+W", f"state.frame === {WORST}"),
    ("darker", "-", "state.exposure === -0.5"),
    ("brighter", "+", "state.exposure === 0.5"),
    ("farther", "x", "state.zoom < 4"),
    ("closer", "z", "state.zoom > 4"),
    ("reset", "0", "state.zoom === 1"),
    ("help", "?", "document.getElementById('help').open"),
]


def test_every_button_and_its_key_do_the_same(visit: Callable[..., Page], report: str) -> None:
    page = visit(report)
    buttons = page.eval_on_selector_all("[data-action]", "all => all.map((one) => one.dataset.action)")
    assert sorted(buttons) == sorted(action for action, _, _ in CONTROLS)
    for action, key, holds in CONTROLS:
        for use_key in (False, True):
            page.keyboard.press("Escape")
            page.evaluate(
                "(fresh) => { state.playing = false; loop.running = true; location.hash = fresh; readAddress(); }",
                FRESH,
            )
            settle(page)
            assert not page.evaluate(holds), action
            if use_key:
                page.keyboard.press(key)
            else:
                page.click(f"[data-action={action}]")
            settle(page)
            assert page.evaluate(holds), action


def test_a_flip_shows_the_rendered_pictures(visit: Callable[..., Page], report: str, run: Path) -> None:
    page = visit(report)
    assert shown(page) == truth(run, "tsl")
    page.keyboard.press(" ")
    assert shown(page) == truth(run, "reference")
    page.keyboard.press(" ")
    assert shown(page) == truth(run, "tsl")


def test_the_reference_shows_for_as_long_as_it_is_held(visit: Callable[..., Page], report: str, run: Path) -> None:
    page = visit(f"{report}#clip=0&a=tsl&b=pixel-point&frame=3")
    page.keyboard.down("r")
    assert shown(page) == truth(run, "reference", 3)
    page.keyboard.up("r")
    assert shown(page) == truth(run, "tsl", 3)
    page.hover("[data-hold]")
    page.mouse.down()
    assert shown(page) == truth(run, "reference", 3)
    page.mouse.up()
    assert shown(page) == truth(run, "tsl", 3)


def test_techniques_are_chosen_by_list_and_key(visit: Callable[..., Page], report: str, run: Path) -> None:
    page = visit(report)
    page.select_option("#b", "pixel-point")
    assert shown(page) == truth(run, "pixel-point")
    page.keyboard.press("1")
    assert page.evaluate("[state.a, state.flipped]") == ["pixel-point", False]
    for key, letter, name in [("n", "a", "tsl"), ("Shift+N", "a", "pixel-point"), ("m", "b", "tsl")]:
        page.keyboard.press(key)
        settle(page)
        assert page.input_value(f"#{letter}") == page.evaluate(f"state.{letter}") == name


def test_split_shows_both_at_one_place(visit: Callable[..., Page], report: str, run: Path) -> None:
    page = visit(report)
    page.keyboard.press("s")
    point(page, PIXEL)
    page.mouse.wheel(0, -100)
    page.mouse.move(0, 0)
    assert shown(page, panel=0) == truth(run, "tsl")
    assert shown(page, panel=1) == truth(run, "reference")


def test_the_error_map_keeps_its_printed_scale(
    visit: Callable[..., Page], report: str, run: Path, tolerance: Callable[[str], float]
) -> None:
    page = visit(report)
    assert page.locator("#legend-box").is_hidden()
    error = error_at(run)
    grey = 0.55 * np.dot([0.2126, 0.7152, 0.0722], truth(run, "tsl"))
    colour = np.array([70, 160, 255] if error < 0 else [255, 84, 40])
    page.keyboard.press("h")
    over = grey + np.sqrt(abs(error)) * (colour - grey)
    assert shown(page) == pytest.approx(over, abs=tolerance("a code of 8 bit"))
    for text in (f"≤ −{ERROR_RANGE}", f"≥ +{ERROR_RANGE}", "linear radiance"):
        assert text in page.inner_text("#legend-box")
    page.keyboard.press("h")
    alone = shown(page)
    page.keyboard.press("+")
    assert shown(page) == alone
    legend = page.evaluate(
        """(place) => Array.from(document.getElementById('legend').getContext('2d')
        .getImageData(Math.round(place * 251), 5, 1, 1).data).slice(0, 3)""",
        (error + 1) / 2,
    )
    assert alone == pytest.approx(legend, abs=tolerance("a step of the legend"))
    page.keyboard.press("h")
    settle(page)
    assert page.locator("#legend-box").is_hidden()


def test_exposure_is_in_stops_of_light(
    visit: Callable[..., Page], report: str, run: Path, tolerance: Callable[[str], float]
) -> None:
    page = visit(report)
    page.keyboard.press("+")
    page.keyboard.press("+")
    light = 2 * rendered(run, "tsl", 0)[PIXEL[1], PIXEL[0], :3]
    assert shown(page) == pytest.approx(srgb(light).astype(int), abs=tolerance("a code of 8 bit"))
    assert "exposure +1 EV" in page.inner_text("#status")


def test_values_under_the_pointer_are_those_of_the_frame(
    visit: Callable[..., Page], report: str, run: Path, tolerance: Callable[[str], float]
) -> None:
    page = visit(report)
    point(page, PIXEL)
    lines = page.inner_text("#readout").splitlines()
    assert lines[0] == f"pixel {PIXEL}"
    assert [line.split()[0] for line in lines[1:]] == ["tsl", "reference"]
    for line, technique in zip(lines[1:], ["tsl", "reference"], strict=True):
        words = line.split()
        radiance = np.array([float(word) for word in words[2:5]], np.float32)
        assert [int(word) for word in words[6:9]] == truth(run, technique)
        assert srgb(radiance).tolist() == truth(run, technique)
    error = float(lines[1].split()[-1].replace("−", "-"))
    assert error == pytest.approx(error_at(run) * ERROR_RANGE, abs=tolerance("printed error"))


def test_large_pixels_have_their_values_written_in(visit: Callable[..., Page], report: str, run: Path) -> None:
    for zoom, written in ((4, False), (16, True)):
        page = visit(f"{report}#clip=0&a=tsl&b=reference&frame=0&zoom={zoom}&x={60.5 / SIZE[0]}&y={40.5 / SIZE[1]}")
        x, y = place_of(page, PIXEL)
        half = int(page.evaluate("layout().scale") / 2) - 2
        inside = canvas(page)[int(y) - half : int(y) + half, int(x) - half : int(x) + half].reshape(-1, 3)
        assert (len(np.unique(inside, axis=0)) > 1) == written
        assert truth(run, "tsl") in inside.tolist()


def test_zoom_and_drag_move_the_picture(
    visit: Callable[..., Page], report: str, tolerance: Callable[[str], float]
) -> None:
    page = visit(report)
    point(page, (20, 20))
    before = place_of(page, (20, 20))
    page.mouse.wheel(0, -300)
    settle(page)
    assert page.evaluate("state.zoom") > 1
    assert place_of(page, (20, 20)) == pytest.approx(before, abs=tolerance("a CSS pixel"))
    page.mouse.down()
    box = page.locator("#screen").bounding_box()
    assert box
    page.mouse.move(box["x"] + before[0] + 30, box["y"] + before[1] + 12)
    page.mouse.up()
    assert place_of(page, (20, 20)) == pytest.approx(np.add(before, [30, 12]), abs=tolerance("a CSS pixel"))
    page.keyboard.press("Shift+ArrowRight")
    assert place_of(page, (20, 20))[0] == pytest.approx(before[0] + 30 - 48, abs=tolerance("a CSS pixel"))


def test_after_a_choice_from_a_list_keys_are_for_the_viewer(visit: Callable[..., Page], report: str) -> None:
    page = visit(report)
    page.keyboard.press("ArrowRight")
    for letter in "ab":
        page.locator(f"#{letter}").focus()
        page.select_option(f"#{letter}", "tsl")
        assert page.evaluate("document.activeElement.tagName") == "BODY"
        page.keyboard.press("p")
        assert page.evaluate("[state.playing, state.a]") == [True, "tsl"]
        page.keyboard.press("p")


def test_after_a_choice_by_key_the_list_keeps_the_focus(visit: Callable[..., Page], report: str) -> None:
    page = visit(report)
    page.locator("#a").focus()
    page.keyboard.press("r")
    assert page.evaluate("[state.a, document.activeElement.id]") == ["reference", "a"]
