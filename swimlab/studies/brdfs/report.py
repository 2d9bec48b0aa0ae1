"""The report on reflectance models: the deck's cost tables with measured columns, table errors, and road-shift."""

from collections.abc import Callable
from pathlib import Path
from typing import Any

from metrics.kernels.launch import Launcher
from swimlab.runs.provenance import provenance
from swimlab.studies.brdfs.cost import FORMS, LOOP, POWERS, Cost, TableError, table_errors, time_models
from swimlab.studies.brdfs.scene import FRAMES, SAMPLES, SIZE, Row, brdf_study
from swimlab.studies.page import Cell, Section, Table, tables, write_page

ROUNDS = 61
STEPS = ROUNDS + 1 + len(FORMS)
"""How often `advance` is called."""


def write_brdf_report(
    page: Path,
    *,
    threads: int | None = None,
    command: str = "",
    advance: Callable[[str], None] = lambda _: None,
) -> dict[str, Any]:
    """Time and measure every form, write the page, and return the numbers of its tables with their provenance.

    `advance` is called `STEPS` times with a word on what is done.
    """
    with Launcher(threads=threads) as launcher:
        costs = time_models(launcher, rounds=ROUNDS, advance=advance)
        errors = table_errors(launcher)
        advance("tables")
        rows = brdf_study(launcher, advance=advance)
    sections = [*_cost_sections(costs), _table_section(errors), _road_section(rows)]
    about = provenance(command)
    opening = (
        "Every reflectance model of the deck *Implementation of Reflectance Models for Games*, evaluated in the "
        "per-pixel local frame, directly and where the deck lists it factored into textures; what its tables estimate "
        "and what is measured here.\n\n"
        f"Made by `{command or 'swimlab bench brdfs'}` on {about['date']}: {about['machine']}, swimlab "
        f"{about['swimlab']}, Warp {about['warp']}, NumPy {about['numpy']}, Python {about['python']}."
    )
    write_page(page, "Reflectance models: cost, table error, error and flicker", opening, sections)
    return {"provenance": about, "tables": tables(sections)}


def _cost_sections(costs: list[Cost]) -> list[Section]:
    by_label = {cost.form: cost for cost in costs}
    loop = by_label[LOOP]
    minimal: list[list[Cell]] = []
    varied: list[list[Cell]] = []
    for form in FORMS:
        cost = by_label[form.label]
        name = f"`{form.label}`"
        kilobytes = cost.table_bytes / 1024
        minimal.append([name, *form.minimal, cost.lookups, kilobytes, cost.minimal, cost.minimal - loop.minimal])
        reads: list[Cell] = [1 + cost.lookups, cost.maps, cost.texel_bytes]
        varied.append([name, *form.varied, *reads, cost.varied, cost.varied - loop.varied, cost.native])
    minimal.append([LOOP, None, None, 0, 0, loop.minimal, None])
    varied.append([LOOP, None, None, 1, loop.maps, loop.texel_bytes, loop.varied, None, None])
    deck = ["model", "deck: textures", "deck: ALU"]
    method = (
        "Times are on one thread, medians over rounds in which every model takes its turn: their ratios count, and "
        f"a second run moves them. *Less the loop* takes off what `{LOOP}` costs."
    )
    return [
        Section(
            "Minimal surface variation",
            [
                "One albedo, Ks and power for all, directions in the local frame. To read: a table pays where its *ns* "
                "are fewer than the formula's in the row above; the deck's columns say where it expected that. "
                f"{method}",
                Table(
                    "minimal variation",
                    [*deck, "table lookups", "tables, KB", "ns an evaluation", "less the loop, ns"],
                    minimal,
                ),
            ],
        ),
        Section(
            "With surface variation",
            [
                "Texels of their own for every sample, turned into the frame of their normal and tangent, in packets "
                "of 64. The deck counts a fetch for each map; here maps lie interleaved in one texel, so *fetches* are "
                "one and the table lookups. *Maps* and *bytes a texel* are the data and the content to author: albedo, "
                "normal and gloss, and for anisotropic models the twist. To read: what a model costs in a scene is its "
                "*ns*; *vectorised* is a form of it written for the CPU's vector units, where there is one.",
                Table(
                    "surface variation",
                    [
                        *deck,
                        "fetches",
                        "maps",
                        "bytes a texel",
                        "ns an evaluation",
                        "less the loop, ns",
                        "vectorised, ns",
                    ],
                    varied,
                ),
            ],
        ),
    ]


def _table_section(errors: list[TableError]) -> Section:
    found: dict[str, list[Cell]] = {}
    for error in errors:
        found.setdefault(f"`{error.form}`", []).append(f"{error.rms:.1e} / {error.largest:.1e}")
    return Section(
        "What the tables lose",
        [
            "The factored form's highlight against the formula's, for directions about the highlight of each power p: "
            "rms of the difference over the formula's rms / largest difference, as a fraction of the value there or of "
            "the median, whichever is larger. To read: 4e-3 is one code of 8 bits at white; below that a table is as "
            "good as its formula.",
            Table(
                "table error", ["model", *(f"p = {power:,}" for power in POWERS)], [[n, *e] for n, e in found.items()]
            ),
        ],
    )


def _road_section(rows: list[Row]) -> Section:
    cells: list[list[Cell]] = []
    for row in rows:
        *direct, chain = row.techniques
        line: list[Cell] = [f"`{row.form}`", row.strength, row.mean]
        for quality in direct:
            line += [quality.error, quality.flicker]
        cells.append([*line, f"`{chain.technique}`", chain.error, chain.flicker, row.floor])
    return Section(
        "On the road",
        [
            f"`road-shift` at {SIZE[0]}x{SIZE[1]}, {FRAMES} frames, reference of {SAMPLES} samples a pixel, TSL "
            "targets of 512: rms of error and of its flicker, as fractions of the mean radiance of the reference, over "
            "wholly covered pixels; *reference* is the reference's own error, below which no difference counts. Ks is "
            "Blinn-Phong's factor, for Ashikhmin-Shirley and Cook-Torrance the reflectance at normal incidence; where "
            "it has no unit it is scaled until the highlight is as bright as Blinn-Phong's (*Ks times*). Anisotropic "
            "models have a map of twist. The moment chain is the one with the least error of toksvig, vmf, clean and, "
            "for Blinn-Phong, lean. To read: compare techniques along a row; the larger the gap between pixel-aniso "
            "and TSL, the less a model commutes with filtering, and what the moment chain wins of that gap is what its "
            "widened power can stand for. Chains reckon that a tilt of the normal turns it as much against the half "
            "vector. Where light and eye graze, as here, a sideways tilt moves what Banks and Lafortune mirror by only "
            "N.L + N.V of it: their chains widen too much, and may win calm at the price of error.",
            Table(
                "road-shift",
                [
                    "model",
                    "Ks times",
                    "mean",
                    "pixel-aniso: error",
                    "flicker",
                    "tsl: error",
                    "tsl: flicker",
                    "moment chain",
                    "its error",
                    "its flicker",
                    "reference",
                ],
                cells,
            ),
        ],
    )
