"""Where shading at vertices is closer to the reference than shading at pixels: over sizes of the picture."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

from swimlab.report.charts import Axis, Line
from swimlab.report.palette import inks
from swimlab.studies.page import Section, Table, chart
from swimlab.studies.trials import Stage, Variant

VERTEX, PIXEL = "vertex", "pixel-aniso"
COMPARED = (VERTEX, PIXEL, "vmf", "tsl")


@dataclass(frozen=True)
class Curve:
    """Relative rms error by size of the picture, largest first, and samples shaded a frame, on average."""

    sizes: Sequence[tuple[int, int]]
    error: Sequence[float | None]
    shaded: float


def vertex_study(stage: Stage) -> dict[str, Curve]:
    """Measure the compared techniques on a stage that resizes."""
    sizes = [(picture.rgba.shape[1], picture.rgba.shape[0]) for picture in stage.reference]
    sizes_by_height = {height: (width, height) for width, height in sizes}
    curves = {}
    for name in COMPARED:
        trial = stage.measure(Variant(name, name))
        found = trial.measurement.curves["scale"]
        covered = [sizes_by_height[round(scale * sizes[0][1])] for scale in found["scale"]]
        curves[name] = Curve(covered, found["rmse"], trial.shaded)
    return curves


def crossover(curves: Mapping[str, Curve]) -> tuple[int, int] | None:
    """The largest size from which on down vertices are the closer to the reference; None if there is none."""
    found = None
    pairs = zip(curves[VERTEX].sizes, curves[VERTEX].error, curves[PIXEL].error, strict=True)
    for size, vertex, pixel in reversed(list(pairs)):
        if vertex is None or pixel is None or vertex >= pixel:
            break
        found = size
    return found


def section(curves: Mapping[str, Curve]) -> Section:
    """What the study shows."""
    size = crossover(curves)
    verdict = (
        f"`{VERTEX}` is closer to the reference than `{PIXEL}` from {size[0]}x{size[1]} on down"
        if size
        else f"`{VERTEX}` is nowhere closer to the reference than `{PIXEL}` down to the smallest size"
    )
    ink = inks(list(curves))
    lines = [
        Line(name, [width for width, _ in curve.sizes], curve.error, ink[name].colour, ink[name].dash)
        for name, curve in curves.items()
    ]
    rows = [
        [f"{width}x{height}", *(curve.error[place] for curve in curves.values())]
        for place, (width, height) in enumerate(curves[VERTEX].sizes)
    ]
    return Section(
        "Vertices against pixels",
        [
            "Shading at vertices is the lowest frequency of evaluation, *but not at low resolution* (the deck): a "
            "small picture has fewer pixels than the road has vertices. The same view (`road-scale`) is rendered at "
            f"{len(rows)} sizes; the error is rms over the reference's rms at that size. **{verdict}.** It shades "
            f"{curves[VERTEX].shaded:,.0f} vertices at every size.",
            chart(
                "vertex.svg",
                "Relative error against the width of the picture",
                lines,
                x=Axis("width of the picture, px", "octaves"),
                y=Axis("relative rms error", "log"),
            ),
            Table("vertex", ["size", *curves], rows),
        ],
    )
