"""All techniques side by side on one sequence: which is closest, which calmest, at which cost; where each fails."""

from collections.abc import Sequence
from dataclasses import dataclass
from math import inf
from statistics import median, quantiles

from metrics import resolved
from metrics.bands import BANDS, describe
from swimlab.render.catalogue import techniques
from swimlab.runs.frames import Image
from swimlab.runs.record import REFERENCE
from swimlab.studies.page import Cell, Figure, Section, Table
from swimlab.studies.sheet import contact_sheet
from swimlab.studies.trials import Stage, Trial, Variant

BASE = "pixel-aniso"
"""What engines do, whose time others are counted in."""

ALLOWANCES = (0.5, 1.25, 2.0, 4.0, 8.0, 16.0, 32.0)
SHIPPED = 2.0
"""Times that a frame may take, as multiples of the time of `BASE`."""

THRIFTY = (
    Variant("tsl, needed texels", "tsl", {"texels": "needed", "inputs": "vmf"}),
    Variant("tsl, fitted targets", "tsl", {"sizes": "fitted", "inputs": "vmf"}),
)
"""Texture-space lighting without its waste."""

KINDS = {
    "bias": "bias: whole neighbourhoods too bright or dark",
    "detail": "detail: a lost or false pattern",
    "flicker": "flicker: sparkle or swimming",
}

SHOWN_FRAMES = 2


@dataclass(frozen=True)
class Row:
    """A technique's trial and the milliseconds of its frames, timed in turns with all others."""

    trial: Trial
    times: Sequence[float]

    @property
    def label(self) -> str:
        return self.trial.variant.label

    @property
    def ms(self) -> float:
        """Median milliseconds a frame."""
        return median(self.times)

    @property
    def error(self) -> float:
        """Rms error."""
        return self.trial.rms() or 0.0

    @property
    def flicker(self) -> float | None:
        """Rms flicker of the error."""
        return self.trial.rms("flicker")


@dataclass(frozen=True)
class Comparison:
    """Rows of all techniques but the reference, the row and rms error of the reference, and a contact sheet."""

    rows: Sequence[Row]
    reference: Row
    floor: float | None
    sheet: bytes


def compare(stage: Stage, *, rounds: int) -> Comparison:
    """Measure and time every technique and the thrifty forms of texture-space lighting."""
    reference = Variant(REFERENCE, REFERENCE)
    variants = [Variant(name, name) for name in techniques() if name != REFERENCE] + list(THRIFTY)
    times = stage.time([*variants, reference], rounds)
    shown: dict[str, list[Image]] = {}
    rows = []
    for variant in variants:
        pictures = stage.pictures(variant)
        shown[variant.label] = [picture.rgba for picture in pictures[:SHOWN_FRAMES]]
        rows.append(Row(stage.measure(variant, pictures=pictures), times[variant.label]))
    ranked = sorted(rows, key=lambda row: row.error, reverse=True)
    sheet = {f"{row.label}\n{row.error:.3f}": shown[row.label] for row in ranked}
    sheet[REFERENCE] = [picture.rgba for picture in stage.reference[:SHOWN_FRAMES]]
    exact = Row(stage.measure(reference, pictures=stage.reference, names=["budget"]), times[REFERENCE])
    return Comparison(rows, exact, rows[0].trial.rms("floor"), contact_sheet(sheet, stage.geometry[0].depth))


def front(rows: Sequence[Row]) -> list[Row]:
    """Rows that none is both faster and closer than, fastest first."""
    ordered = sorted(rows, key=lambda row: (row.ms, row.error))
    return [row for place, row in enumerate(ordered) if all(row.error < other.error for other in ordered[:place])]


def unresolved_from(row: Row, rows: Sequence[Row], score: str = "budget.mse") -> list[str]:
    """Other rows that a score does not tell from this one by more than chance and the reference's error."""
    mine = vars(row.trial.measurement)
    return [
        other.label
        for other in rows
        if other is not row
        and score in other.trial.measurement.scores
        and not resolved(score, mine, vars(other.trial.measurement))
    ]


def answer(rows: Sequence[Row], *, also: Sequence[str] = ()) -> Section:
    """Which technique is closest, calmest and fastest, and which to ship; `also` are other studies' answers."""
    said = "\n".join(f"- {line}" for line in [*_answers(rows), *also])
    return Section("The answer", [said, _allowances(rows)])


def sections(found: Comparison, *, about: str) -> list[Section]:
    """The table of techniques, where they fail, and their pictures; `about` says what was rendered."""
    worst = Section(
        "Where each technique fails",
        [
            "By distance from the eye: the band in which a technique is furthest from the reference, how many times "
            "the least error of any technique there, and which part of the error is the largest. Near is "
            f"{', mid '.join(describe(band) for band in BANDS[:2])}, far {describe(BANDS[2])}.",
            Table(
                "failures",
                ["technique", *BANDS, "worst", "times the closest", "mostly"],
                [_failure(row, found.rows) for row in found.rows],
            ),
        ],
    )
    pictures = Section(
        "What it looks like",
        [
            Figure(
                "techniques.png",
                "Two details in two consecutive frames, from the technique furthest from the reference (rms error "
                "beside its name) to the closest, and the reference last. What differs from one frame to the next "
                "within a row is motion of the picture where the reference has it too, and flicker where it does not.",
                found.sheet,
            )
        ],
    )
    return [_table(found, about), worst, pictures]


def _answers(rows: Sequence[Row]) -> list[str]:
    closest = min(rows, key=lambda row: row.error)
    lines = [
        f"**Closest to the reference: {_named(closest)}**, rms error {closest.error:.3g}, {closest.ms:.3g} ms and "
        f"{closest.trial.shaded:,.0f} shaded samples a frame.{_unresolved(unresolved_from(closest, rows))}"
    ]
    calmest = _calmest(rows, inf)
    if calmest is not None:
        lines.append(
            f"**Calmest: {_named(calmest)}**, rms flicker {calmest.flicker:.3g}, error {calmest.error:.3g}."
            + _unresolved(unresolved_from(calmest, rows, "budget.flicker"))
        )
    fastest = min(rows, key=lambda row: row.ms)
    lines.append(f"**Fastest: {_named(fastest)}**, {fastest.ms:.3g} ms, error {fastest.error:.3g}.")
    efficient = ", ".join(f"{_named(row)} ({row.ms:.3g} ms, {row.error:.3g})" for row in front(rows))
    lines.append(f"Nothing is both faster and closer than: {efficient}.")
    base = _base(rows)
    limit = SHIPPED * base.ms
    chosen = _closest(rows, limit)
    if chosen is not None:
        lines.append(
            f"**To ship** within {SHIPPED:g} times the time of {_named(base)} ({base.ms:.3g} ms, error "
            f"{base.error:.3g}): {_named(chosen)}, {chosen.ms / base.ms:.2f} times the time for "
            f"{chosen.error / base.error:.2f} of the "
            f"error.{_unresolved(unresolved_from(chosen, _within(rows, limit)))} The table has the choice for other "
            "allowances."
        )
    return lines


def _allowances(rows: Sequence[Row]) -> Table:
    base = _base(rows)
    cells: list[list[Cell]] = []
    for allowance in (*ALLOWANCES, inf):
        limit = allowance * base.ms
        chosen, calm = _closest(rows, limit), _calmest(rows, limit)
        if chosen is not None:
            name = "any" if allowance == inf else f"{allowance:g}"
            calm_cells: list[Cell] = ["–", None] if calm is None else [_named(calm), calm.flicker]
            cells.append([name, _named(chosen), chosen.ms, chosen.error, *calm_cells])
    headings = [f"time allowed, of {base.label}", "closest", "ms", "error", "calmest", "flicker"]
    return Table("to ship", headings, cells)


def _table(found: Comparison, about: str) -> Section:
    parts = ("bias", "detail", "flicker")
    cells: list[list[Cell]] = []
    for row in sorted(found.rows, key=lambda row: row.error):
        scores = row.trial.measurement.scores
        low, _, high = quantiles(row.times, n=4) if len(row.times) > 1 else [row.ms] * 3
        cost: list[Cell] = [row.ms, f"{low:.3g}–{high:.3g}", round(row.trial.shaded)]
        budget = [row.error, row.trial.standard_error(), *(row.trial.rms(part) for part in parts)]
        cells.append([_named(row), *cost, *budget, scores.get("visible.flicker"), scores.get("moire.excess")])
    exact = found.reference
    cells.append([_named(exact), exact.ms, "", round(exact.trial.shaded), found.floor, *[None] * 6])
    headings = ["technique", "ms a frame", "quartiles", "shaded a frame", "error", "±", *parts]
    return Section(
        "All techniques",
        [
            f"{about} Closest first; rms of linear radiance over wholly covered pixels. error² = bias² + detail² + "
            "flicker²: *bias* is a neighbourhood's mean that is off, *detail* a lost or false pattern that sticks to "
            "the road, *flicker* what changes in time while the road does not. *±* is the error's standard error. "
            "*Visible flicker* weighs flicker by what the eye sees, in thresholds; *Moiré excess* is energy that the "
            "reference does not have, over the reference's. *Shaded* counts evaluations of the reflectance model: "
            "samples, texels and vertices together. The last row is the reference itself with its own error, below "
            "which no difference counts. To see: which part of the error a technique trades for which.",
            Table("techniques", [*headings, "visible flicker", "Moiré excess"], cells),
        ],
    )


def _failure(row: Row, rows: Sequence[Row]) -> list[Cell]:
    errors = {band: row.trial.rms("mse", band) for band in BANDS}
    known = {band: error for band, error in errors.items() if error is not None}
    if not known:
        return [_named(row), *errors.values(), "–", None, "–"]
    worst = max(known, key=lambda band: known[band])
    least = min(other.trial.rms("mse", worst) or inf for other in rows)
    shares = {kind: row.trial.rms(kind, worst) or 0.0 for kind in KINDS}
    mostly = KINDS[max(shares, key=lambda kind: shares[kind])] if any(shares.values()) else "–"
    return [_named(row), *errors.values(), worst, known[worst] / least, mostly]


def _within(rows: Sequence[Row], limit: float) -> list[Row]:
    return [row for row in rows if row.ms <= limit]


def _closest(rows: Sequence[Row], limit: float) -> Row | None:
    return min(_within(rows, limit), key=lambda row: row.error, default=None)


def _calmest(rows: Sequence[Row], limit: float) -> Row | None:
    known = [row for row in _within(rows, limit) if row.flicker is not None]
    return min(known, key=lambda row: row.flicker or 0.0, default=None)


def _base(rows: Sequence[Row]) -> Row:
    return next(row for row in rows if row.label == BASE)


def _named(row: Row) -> str:
    return f"`{row.label}`"


def _unresolved(labels: Sequence[str]) -> str:
    return (
        f" Not distinguished from it by these frames: {', '.join(f'`{label}`' for label in labels)}." if labels else ""
    )
