"""The pictures of the concepts, drawn from small clips that are rendered and measured here, in some seconds."""

import math
import re
from typing import Any

import numpy as np

import swimlab
from metrics import Clip, measure
from metrics.synthetic import KINDS, Waves, centres, error_clips, error_frame, texture, zone_plate
from swimlab.notebook.picture import Picture, enlarge, on_scale, sheet
from swimlab.notebook.study import Study
from swimlab.report.charts import Axis, Bar, Plane, drawing, stacked_bars
from swimlab.report.class_maps import class_map
from swimlab.report.display import srgb
from swimlab.report.palette import PARTS
from swimlab.studies.page import STYLE

COUNT = 32
MOTION = (23 / 32, 19 / 32)
ROAD = ("pixel-point", "pixel-aniso", "lod-hack", "vmf")
SLOW_ROAD = {"size": (240, 136), "frames": "0-11", "samples": 64}


def drawn() -> dict[str, bytes]:
    """Path on the site -> content, of every picture."""
    road = swimlab.study("road-shift", ROAD, **SLOW_ROAD)
    made = {
        "errors.png": five_errors(),
        "shares.svg": shares(),
        "budget.svg": budget(road),
        "detail.png": road.compare((*ROAD[:3], "reference"), [0, 1, 2], region=road.detail(), zoom=3).png,
        "plates.png": plates(),
        "orders.svg": orders(),
        "errorbars.svg": errorbars(),
        "residual.svg": residual(road),
        **posts(),
    }
    return {f"concepts/{name}": content for name, content in made.items()}


def five_errors() -> bytes:
    """A row of each kind of error over time, on the screen and on the moving surface."""
    wrong, (x, y) = texture(2), centres(1, 140)
    rows = []
    for kind in KINDS:
        panels = []
        for where, (dx, dy) in (("screen", (0.0, 0.0)), ("surface", MOTION)):
            lines = [error_frame(kind, wrong, t, (x + t * dx, y + 60 + t * dy), MOTION)[0, :, 0] for t in range(COUNT)]
            panels.append((f"{kind}, {where}", enlarge(on_scale(np.clip(np.stack(lines) / 2.5, -1, 1)), 2)))
        rows.append(panels)
    return Picture(sheet(rows), "").png


def shares() -> bytes:
    """What the budget says of each kind."""
    bars = []
    for kind in KINDS:
        test, reference = error_clips(kind, count=COUNT, motion=MOTION)
        found = measure(test, reference, names=["budget"]).scores
        bars.append(_parts(kind, {part: found[f"budget.{part}"] for part in ("bias", "detail", "flicker")}))
    return standalone(stacked_bars(bars, label="rms error; grey bias, blue detail, red flicker", title="Five errors"))


def budget(road: Study) -> bytes:
    """What the budget says of techniques."""
    found = road.scores.to_dict()
    parts = ("bias", "detail", "flicker")
    bars = [_parts(name, {part: found[name][f"budget.{part}"] for part in parts}) for name in ROAD]
    return standalone(stacked_bars(bars, label="rms error; grey bias, blue detail, red flicker", title="A road"))


def residual(road: Study) -> bytes:
    """Flicker that is measured without a reference, beside the flicker of the error."""
    found = road.scores.to_dict()
    bars = []
    for name in ROAD:
        for label, score, colour in (("error", "budget", PARTS["flicker"]), ("frames", "residual", PARTS["order 2"])):
            rms = math.sqrt(found[name][f"{score}.flicker"])
            bars.append(Bar(f"{name}, {label}", [(label, rms, colour, f"{rms:.3g} rms")]))
    own = math.sqrt(found[ROAD[0]]["residual.flicker.reference"])
    bars.append(Bar("reference", [("frames", own, PARTS["bias"], f"{own:.3g} rms")]))
    return standalone(stacked_bars(bars, label="rms flicker, linear radiance", title="With and without a reference"))


def plates() -> bytes:
    """A zone plate beyond the pixel Nyquist, by one sample a pixel and by many, in two frames."""
    rows = []
    for label, samples in (("1 sample a pixel", 1), ("12x12 samples", 12)):
        clip = zone_plate(0.85, math.radians(20), samples=samples, count=COUNT, size=(160, 100), motion=MOTION)
        panels = []
        for t in (0, 8):
            codes = srgb(np.moveaxis(np.asarray(clip.planes(t)), 0, 2) / 4)
            panels.append((f"{label}, frame {t}", enlarge(codes, 2)))
        rows.append(panels)
    return Picture(sheet(rows), "").png


def orders() -> bytes:
    """Where the energy of drifting waves lies, by how many samples a pixel takes."""
    names = {"on": "on the plane", "order1": "order 1", "order2": "order 2", "off": "off every plane"}
    bars = []
    for samples in (1, 2, 4, 16):
        found = measure(Waves().clip(samples, 0.375), names=["plane"]).scores
        parts = [
            (name, found[f"plane.{key}"], PARTS[name], f"{found[f'plane.{key}']:.1%}")
            for key, name in names.items()
            if f"plane.{key}" in found
        ]
        bars.append(Bar(f"{samples} a pixel", parts))
    label = "share of the energy; blue moves with the surface, red is order 1"
    return standalone(stacked_bars(bars, label=label, title="Alias orders"))


def posts() -> dict[str, bytes]:
    """A frame with posts and rails, and the classes of its pixels."""
    study = swimlab.study("road-posts", ["pixel-aniso"], size=(320, 180), frames="0-7", samples=16)
    entry: dict[str, Any] = {
        "curves": study.curves["pixel-aniso"],
        "scores": study.scores.to_dict()["pixel-aniso"],
    }
    return {"posts.png": study.show("pixel-aniso", 4, exposure=1.0).png, "classes.svg": standalone(class_map(entry)[0])}


def glints(seed: int) -> tuple[Clip, Clip]:
    """A grey picture on which one pixel in 500 glints, anew in every frame; and the same without glints."""
    random = np.random.default_rng(seed)
    grey = np.full((96, 128, 3), 0.2, np.float32)
    frames = [grey + (random.random((96, 128, 1)) < 0.002) for _ in range(8)]
    return Clip(lambda t: frames[t].astype(np.float32), 8), Clip(lambda _: grey, 8)


def errorbars() -> bytes:
    """One score of 16 clips of one kind that differ by chance alone, with the standard error that each clip states."""
    found = [measure(*glints(seed), names=["budget"]) for seed in range(16)]
    values = [each.scores["budget.flicker"] * 1e3 for each in found]
    errors = [each.errors["budget.flicker"] * 1e3 for each in found]
    ends = [value + sign * error for value, error in zip(values, errors, strict=True) for sign in (-1, 1)]
    x, y = Axis("clip"), Axis("budget.flicker, 0.001 radiance²")
    plane = Plane([0, len(found) + 1], [0, *ends], x=x, y=y)
    body = plane.drawn()
    for place, (value, error) in enumerate(zip(values, errors, strict=True), 1):
        across, low = plane.place(place, value - error)
        _, high = plane.place(place, value + error)
        _, middle = plane.place(place, value)
        body.append(f'<path class="line" stroke="#0072b2" d="M{across:.1f} {low:.1f}V{high:.1f}"/>')
        body.append(f'<circle cx="{across:.1f}" cy="{middle:.1f}" fill="#0072b2"/>')
    left, level = plane.place(0, float(np.mean(values)))
    body.append(f'<path class="line" stroke="#d55e00" d="M{left:.1f} {level:.1f}H{plane.box[2]:.1f}"/>')
    return standalone(drawing(plane.size, "Standard errors", body))


def standalone(svg: str) -> bytes:
    """A chart of the report as a file of its own."""
    width, height = re.findall(r'viewBox="0 0 (\S+) (\S+)"', svg)[0]
    head = f'<svg xmlns="http://www.w3.org/2000/svg" width="{width}" height="{height}" '
    paper = f'<style>{STYLE}.cells{{image-rendering:pixelated}}</style><rect width="100%" height="100%" fill="white"/>'
    start = svg.index(">") + 1
    return (head + svg[len("<svg ") : start] + paper + svg[start:] + "\n").encode()


def _parts(label: str, energies: dict[str, float]) -> Bar:
    total = sum(energies.values())
    rms = math.sqrt(total)
    return Bar(
        label, [(part, rms * value / total, PARTS[part], f"{value / total:.0%}") for part, value in energies.items()]
    )
