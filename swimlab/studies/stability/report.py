"""The report on hard cases: what single precision costs where formulas are stretched, and the flicker it makes."""

from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any, NamedTuple

from metrics.kernels.launch import Launcher
from sequences.asphalt import make
from swimlab.render.inputs import Maps
from swimlab.runs.provenance import provenance
from swimlab.studies.page import Cell, Section, Table, tables, write_page
from swimlab.studies.stability import frames, lobes, measures, memory, moments, slivers
from swimlab.studies.stability.limits import limits
from swimlab.studies.stability.twin import Error

NAME = "stability"
"""Of the report's file."""
MAP_SIDE = 256
"""Of the asphalt that frames are rendered with, texels."""
ERROR = ("error", "largest", "flicker alone", "NaN or Inf")
OPENING = (
    "Rendering is done in single precision where that is enough. Here it is put to the cases that break naive code, "
    "and compared with the same formulas in double precision, restated in numpy without shared code. In all tables, "
    "*error* is the root mean square of the difference and *largest* its largest value, as fractions of what the text "
    "names; *flicker alone* is the rms change of that difference from one frame to the next, the flicker that rounding "
    "would make if all else stood still. For scale: half a step of an 8-bit display is 2e-3 of white, and the "
    "techniques of the deck flicker by .1 and more of the mean radiance."
)


class Bench(NamedTuple):
    """What the cases are run with."""

    launcher: Launcher
    maps: Maps
    threads: int | None


Case = Callable[[Bench], Section]


def write_stability_report(
    folder: Path,
    *,
    threads: int | None = None,
    command: str = "",
    advance: Callable[[str], None] = lambda _: None,
) -> dict[str, Any]:
    """Run every case, write `folder`/stability.md, and return the numbers of its tables with their provenance.

    `advance` is called with the title of each of `CASES` when it is done.
    """
    sections = []
    with Launcher(threads=threads) as launcher:
        bench = Bench(launcher, Maps(*make(0, MAP_SIDE)), threads)
        for case in CASES:
            sections.append(case(bench))
            advance(sections[-1].title)
    about = provenance(command)
    made = (
        f"Made by `{command or 'swimlab bench stability'}` on {about['date']}: {about['machine']}, swimlab "
        f"{about['swimlab']}, Warp {about['warp']}, NumPy {about['numpy']}, Python {about['python']}."
    )
    write_page(folder / f"{NAME}.md", "Hard cases: numerical stability", f"{OPENING}\n\n{made}", sections)
    return {"provenance": about, "tables": tables(sections)}


def errors_table(name: str, first: str, errors: Mapping[Any, Error]) -> Table:
    """A table of errors by case."""
    return Table(name, [first, *ERROR], [[_named(key), *_cells(error)] for key, error in errors.items()])


def _cells(error: Error) -> list[Cell]:
    return [error.rms, error.largest, error.flicker, error.bad]


def _named(key: Any) -> Cell:
    return key if isinstance(key, str) else f"{key:,g}" if abs(key) < 1e6 else f"{key:.0e}"


def _powers(bench: Bench) -> Section:
    columns = ["power", "dot and pow: error", "its flicker", "plain: error", "its flicker", "shipped: error"]
    columns += ["largest", "flicker alone", "NaN or Inf"]
    rows: list[list[Cell]] = [
        [_named(power), e.naive.rms, e.naive.flicker, e.plain.rms, e.plain.flicker, *_cells(e.native)]
        for power, e in lobes.powers(bench.launcher).items()
    ]
    text = (
        "Blinn-Phong's (N.H)^p within the highlight at 20 m, as fractions of its peak; between two frames the eye goes "
        "1 mm. A dot product near 1 has lost the digits that a large power multiplies. *Shipped* takes the power of "
        "the sine between N and H, and takes the rounding of lengths off L + V; *plain* is the form that other "
        "reflectance models share, without the latter. To read: up to powers of 1e5 the shipped highlight is off by "
        "millionths."
    )
    return Section("Large powers", [text, Table("powers", columns, rows)])


def _low_suns(bench: Bench) -> Section:
    columns = ["power", "distance, m", "dot and pow: error", "plain: error", "shipped: error", "largest"]
    columns += ["flicker alone", "NaN or Inf"]
    rows: list[list[Cell]] = [
        [_named(power), _named(distance), e.naive.rms, e.plain.rms, *_cells(e.native)]
        for (power, distance), e in lobes.low_suns(bench.launcher).items()
    ]
    text = (
        "Towards a sun on the horizon L and V come to be opposite, and their sum is hardly longer than their rounding. "
        "Fractions of the highlight's peak. L + V of unit vectors has nothing along L - V; what it has there is "
        "rounding of their lengths, and is taken off, which wins a factor of ten here. The rest is the rounding of "
        "places in single precision: to read, beyond some kilometres towards a setting sun powers of 1e4 are good to a "
        "thousandth only. The other reflectance models have the plain form's error."
    )
    return Section("Light and eye nearly opposite", [text, Table("opposite", columns, rows)])


def _degenerate(bench: Bench) -> Section:
    rows: list[list[Cell]] = [
        [each.name, each.expected, each.plain, each.native] for each in lobes.degenerate(bench.launcher)
    ]
    sound: list[list[Cell]] = [
        [f"`{name}`", each.evaluations, each.bad, each.negative]
        for name, each in lobes.soundness(bench.launcher).items()
    ]
    return Section(
        "0/0 and 0^0",
        [
            "Cases whose formula has no value of its own: what it is by its limit (0^0 is 1), and what the plain and "
            "the vectorised form give. A normal of length 0 shades black.",
            Table("degenerate", ["case", "by its limit", "plain", "vectorised"], rows),
            "Every reflectance model under every combination of normals (upright, flat, upside down, shortened, of "
            "length 0), lights and eyes (also opposite, and 1e-6 off the horizon), Ks of 0 and 1, powers of 0..1e5:",
            Table("soundness", ["model", "evaluations", "NaN or Inf", "negative"], sound),
        ],
    )


def _cancelled(bench: Bench) -> Section:
    text = (
        "Means of two normals that all but cancel, as fractions of the radiance's rms; in the second frame another "
        "pair has the same mean. What is left of a mean of length l has a direction to 6e-8 / l: no formula can bring "
        "back what the mean has lost. To read: means shorter than a thousandth would begin to "
        "sparkle under a filter of inputs."
    )
    return Section(
        "Normals that cancel",
        [text, errors_table("cancelled", "length of the mean", lobes.cancelled(bench.launcher))],
    )


def _lean(bench: Bench) -> Section:
    columns = ["mean slope", "variance", "16-bit, about 0", "about 0", "shipped: CLEAN", "shipped: LEAN"]
    rows: list[list[Cell]] = [
        [_named(mean), _named(variance), *found]
        for (mean, variance), found in moments.lean_variances(bench.launcher).items()
    ]
    text = (
        "LEAN and CLEAN keep sums of squared slopes and subtract the squared mean, which cancels where slopes lean far "
        "and vary little. Relative error of the standard deviation of slopes that a chain's last texel gives (1: "
        "nothing is left). Shipped moments are about the map's mean slope. To read: without that, half floats are "
        "useless and single precision loses the highlights of tilted mirrors. A map that leans several ways, each "
        "smooth, has the column *about 0* in its parts."
    )
    return Section("Variances of slopes", [text, Table("lean", columns, rows)])


def _eight_bit(bench: Bench) -> Section:
    del bench
    columns = ["power", "divides by 0 or less", "lengths cut at 1: power too low by", "rms of its log"]
    columns += ["shipped: power too low by"]
    rows: list[list[Cell]] = [[_named(power), *found] for power, found in moments.eight_bit().items()]
    text = (
        "Decoded 8-bit normals have lengths of .993 to 1.007. Toksvig's formula takes a short mean normal for a rough "
        "one: on single codes of a smooth map, as published it divides by 0 or less for a share of them; with lengths "
        "cut at 1 it widens the highlights of the others by up to the factor given, code by code, a pattern that is "
        "not there. Shipped chains are built from unit normals: a factor of 1 is right."
    )
    return Section("8-bit normals", [text, Table("8-bit", columns, rows)])


def _footprints(bench: Bench) -> Section:
    text = (
        "Anisotropic filters of up to 16 probes over random texels of 0..1, by the footprint's aspect; in the second "
        "frame the footprint has gone 1/1024 of its length. Fractions of 1. Axes are singular values in double "
        "precision, whose product is taken from the determinant, so that it does not cancel. To read: the aspect does "
        "not matter."
    )
    return Section(
        "Stretched footprints", [text, errors_table("footprints", "aspect", frames.footprints(bench.launcher))]
    )


def _views(bench: Bench) -> Section:
    columns = ["view", *(f"{name}: {each}" for name in ("bilinear", "aniso") for each in ERROR)]
    rows: list[list[Cell]] = [
        [name, *_cells(bilinear), *_cells(aniso)]
        for name, (bilinear, aniso) in frames.views(bench.launcher, bench.maps).items()
    ]
    text = (
        "Whole frames of pixel-bilinear and pixel-aniso, from rays to radiance, as fractions of their rms, over two "
        "frames 23/32 and 19/32 px apart unless said. The endless road ends at 10 km, where a pixel's footprint is "
        "200,000 times as long as wide. Below the road the sun leaves next to no light, of which rounding is a larger "
        "share. To read: no view makes rounding visible."
    )
    return Section("Horizons and suns", [text, Table("views", columns, rows)])


def _drives(bench: Bench) -> Section:
    columns = ["technique", "metres", "largest", "flicker alone", "largest, hills", "naive: texels off"]
    rows: list[list[Cell]] = [
        [f"`{name}`", f"{metres:,g}", *found]
        for name in ("pixel-aniso", "tsl", "reference")
        for metres, found in frames.drives(bench.launcher, bench.maps, name).items()
    ]
    text = (
        "Frames after whole segments against the same at the start: they should not differ. Fractions of the brightest "
        "pixel and, for flicker, of the rms. Positions are relative to the eye, origins in double precision, texture "
        "coordinates begin again with every segment; the last column is what coordinates along the road in single "
        "precision would be off by, texels of a map of 1024. To read: 10,000 km (1e7 m) change a pixel by millionths, "
        "where naive coordinates are off by whole texels."
    )
    return Section("10,000 km of driving", [text, Table("driving", columns, rows)])


def _tiny_steps(bench: Bench) -> Section:
    rows: list[list[Cell]] = [
        [n, each.error, ("yes" if each.same else "no") if n % 1024 == 0 else None]
        for n, each in frames.tiny_steps(bench.launcher, bench.maps).items()
    ]
    text = (
        "The picture slides by 1/1024 px a frame. Error of the sample places, found from what they see of the road; "
        "and whether after whole pixels it is the first picture, moved, to the bit."
    )
    return Section("Steps of 1/1024 px", [text, Table("steps", ["frame", "place off by, px", "same bits"], rows)])


def _slivers(bench: Bench) -> Section:
    columns = [
        "width, px",
        "triangles",
        "samples of wrong owner",
        "place off by, px",
        "naive: samples of no or two owners",
    ]
    rows: list[list[Cell]] = [[_named(width), *found] for width, found in slivers.strips(bench.launcher).items()]
    text = (
        "A surface in perspective cut into slivers: every sample should have exactly one owner and see the surface "
        "where it is. Edge functions are homogeneous and in double precision, opposite to the bit along a shared edge. "
        "To read: slivers of 1e-4 px tear no hole; *naive* are edge functions of projected corners in single precision."
    )
    return Section("Slivers", [text, Table("slivers", columns, rows)])


def _crossings(bench: Bench) -> Section:
    columns = ["view", "pixels of road", "NaN or Inf", "off the road, m"]
    rows: list[list[Cell]] = [[name, *each] for name, each in frames.crossings(bench.launcher, bench.maps).items()]
    text = (
        "Eyes 5 cm above the road, whose polygons run through the eye plane and behind the camera. How far the place "
        "that a pixel sees is off the polygons of the road there."
    )
    return Section("Views through the eye plane", [text, Table("crossings", columns, rows)])


def _single_texels(bench: Bench) -> Section:
    columns = ["technique", "1x1", "8x1", "1x8", "NaN or Inf"]
    rows: list[list[Cell]] = [
        [f"`{name}`", *(error for error, _ in found), sum(bad for _, bad in found)]
        for name, found in frames.single_texels(bench.launcher).items()
    ]
    text = (
        "A road of one colour without a highlight from maps of so many texels, whose chains end at once: the largest "
        "relative error of a pixel. To read: single precision rounds to 6e-8."
    )
    return Section("Maps of one texel", [text, Table("one texel", columns, rows)])


def _alpha(bench: Bench) -> Section:
    thin: list[list[Cell]] = [[_named(f), *found] for f, found in frames.thin_charts(bench.launcher).items()]
    faint: list[list[Cell]] = [
        [side, alpha, error] for side, (alpha, error) in frames.faint_texels(bench.launcher).items()
    ]
    return Section(
        "Targets that are hardly covered",
        [
            "Texture-space lighting of a road of one colour that ends just after a segment begins: that segment's "
            "target is covered to the fraction given. Largest relative error of a pixel, with the seam to the next "
            "target in view. A chart narrower than a texel is widened to one, so alpha is never less than 1/size.",
            Table("thin charts", ["fraction of the segment", "largest", "NaN or Inf"], thin),
            "One lit texel in a target: alpha of the chain's last level, and the relative error of the light after "
            "division by it. The deck divides where alpha is above 1e-5; an error of 1 is light that was left "
            "undivided, all but black. Charts as they are drawn here do not come so low.",
            Table("faint texels", ["texels a side", "alpha", "error"], faint),
        ],
    )


def _memory(bench: Bench) -> Section:
    columns = ["technique", "size", "bytes for a pixel more", "peak of the process, MB", "seconds"]
    rows: list[list[Cell]] = [
        [f"`{name}`", f"{width}x{height}", each.per_pixel, each.peak / 1e6, each.seconds]
        for (name, width, height), each in memory.large_frames(bench.threads).items()
    ]
    text = (
        "Frames are rendered in strips of 32 rows of samples, whose buffers stay as they are however large the frame: "
        "what grows is the picture itself, 16 bytes a pixel (RGBA in single precision), 16 more for the reference's "
        "error, and for texture-space lighting which segment each pixel sees. Each in a process of its own, "
        f"{memory.SAMPLES} samples a pixel for the reference; the largest if there is {memory.SPARE} times its memory."
    )
    return Section("Frames of 16,384 pixels", [text, Table("memory", columns, rows)])


def _measures(bench: Bench) -> Section:
    del bench
    rows: list[list[Cell]] = [[_named(level), *each] for level, each in measures.bright_flicker().items()]
    answers: list[list[Cell]] = [[name, answer] for name, answer in measures.refused().items()]
    return Section(
        "Measures",
        [
            "Flicker of deviation 1 on a still picture of some brightness: relative error of its variance as the mean "
            "of squares less the square of the mean, and as `residual.flicker`.",
            Table("bright flicker", ["brightness", "naive", "shipped"], rows),
            "Frames that cannot be measured are refused:",
            Table("refused", ["a frame with", "is answered with"], answers),
        ],
    )


def _limits(bench: Bench) -> Section:
    rows: list[list[Cell]] = [[*each] for each in limits(bench.launcher, bench.maps)]
    text = (
        "Where a formula has no value, or rounding would decide, a limit is left. *Touched* is the share of texels of "
        "asphalt, in all levels of its chains, or of other inputs as said, that it changes."
    )
    return Section("Limits that are left", [text, Table("limits", ["limit", "why", "touched", "what it does"], rows)])


CASES: tuple[Case, ...] = (
    _powers,
    _low_suns,
    _degenerate,
    _cancelled,
    _lean,
    _eight_bit,
    _footprints,
    _views,
    _drives,
    _tiny_steps,
    _slivers,
    _crossings,
    _single_texels,
    _alpha,
    _memory,
    _measures,
    _limits,
)
"""The report's sections in order."""
