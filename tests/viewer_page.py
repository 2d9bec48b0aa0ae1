"""What the tests ask of the report's viewer in a browser."""

import base64
from pathlib import Path

import cv2
import numpy as np
from playwright.sync_api import Page

from swimlab.report.display import ERROR_STEPS, error_codes, srgb
from swimlab.runs.frames import Image, frame_path, read_frame

PIXEL = (60, 40)
LAPTOP = {"viewport": {"width": 1000, "height": 900}}
PHONE = {"viewport": {"width": 360, "height": 740}, "has_touch": True, "is_mobile": True}


def settle(page: Page) -> None:
    """Wait until all pictures asked for are there and drawn."""
    page.evaluate("""new Promise((done) => {
        const next = window.requestAnimationFrame;
        const look = () => (pending.size ? next(look) : next(() => next(done)));
        next(look);
    })""")


def canvas(page: Page) -> np.ndarray:
    """What the screen shows, [H, W, 3] sRGB codes."""
    return _codes(page.locator("#screen").screenshot())


def inset(page: Page) -> np.ndarray:
    """What is drawn beside the screen, [H, W, 3] sRGB codes."""
    return _codes(base64.b64decode(page.evaluate("inset.toDataURL()").partition(",")[2]))


def _codes(png: bytes) -> np.ndarray:
    return cv2.imdecode(np.frombuffer(png, np.uint8), cv2.IMREAD_COLOR)[..., ::-1].astype(int)


def shown(page: Page, pixel: tuple[int, int] = PIXEL, panel: int = 0) -> list[int]:
    """The sRGB codes in which a pixel of the picture is drawn in one panel, at its middle."""
    settle(page)
    x, y = place_of(page, pixel, panel)
    return [int(code) for code in canvas(page)[int(y), int(x)]]


def place_of(page: Page, pixel: tuple[int, int], panel: int = 0) -> tuple[float, float]:
    at = page.evaluate(
        """([column, row, panel]) => { const at = layout(), [left, top] = at.place(panel); return [
        left + at.wide / 2 + (column + 0.5 - state.x * at.width) * at.scale,
        top + at.high / 2 + (row + 0.5 - state.y * at.height) * at.scale]; }""",
        [*pixel, panel],
    )
    return at[0], at[1]


def point(page: Page, pixel: tuple[int, int]) -> None:
    """Move the mouse to a pixel of the picture."""
    box = page.locator("#screen").bounding_box()
    assert box
    x, y = place_of(page, pixel)
    page.mouse.move(box["x"] + x, box["y"] + y)
    settle(page)


def rendered(run: Path, technique: str, frame: int) -> Image:
    return read_frame(frame_path(run, technique, frame))


def truth(run: Path, technique: str, frame: int = 0, pixel: tuple[int, int] = PIXEL) -> list[int]:
    """The sRGB codes of a pixel of the EXR."""
    return [int(code) for code in srgb(rendered(run, technique, frame)[pixel[1], pixel[0], :3])]


def error_at(run: Path, pixel: tuple[int, int] = PIXEL) -> float:
    """The coded error of tsl in frame 0, as a fraction of the range."""
    codes = error_codes(rendered(run, "tsl", 0), rendered(run, "reference", 0))
    return (int(codes[pixel[1], pixel[0]]) - ERROR_STEPS - 1) / ERROR_STEPS
