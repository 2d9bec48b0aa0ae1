"""Light that is kept from frame to frame: what it saves, what it costs, and how late it is."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from swimlab.render.atlas import Held, Pool
from swimlab.render.kernels.tile_table import EPOCH
from swimlab.render.shot import Shot
from swimlab.render.target import Lighting, Relighting, Ways, pasting
from swimlab.render.technique import Image, to_image
from swimlab.render.techniques.tsl import INPUTS, TslSettings, planned_alone
from swimlab.studies.page import Cell, Section, Table
from swimlab.studies.trials import Stage, Trial, Variant
from swimlab.studies.turns import Time, cpu, frame_task, in_turns

SEQUENCES = ("road-shift", "road-turn", "road-drive", "road-sun")
FRAMES = (2, 4, 8, 16)
TOLERANCES = (0.1, 0.3)
ALWAYS = 1e9
"""A tolerance that leaves all to the schedule."""
SOME = 0.05
"""Of the texels: settings that differ by less tell nothing of what lighting them costs."""
WANTED = 1.05
"""Times the error of light that is made anew that a saving may cost."""

THRIFTY = {"texels": "needed", "inputs": "vmf"}
"""Settings of `tsl` under which light is kept for some frames."""
PLAIN = Variant("each frame anew", "tsl", THRIFTY)
PIXELS = Variant("pixel-aniso", "pixel-aniso")


def kept(frames: int, tolerance: float) -> Variant:
    """Needed texels whose light is kept."""
    name = f"{frames} frames" + (f", {tolerance:g}" if tolerance < ALWAYS else ", any")
    return Variant(name, "tsl", THRIFTY | {"reuse": frames, "tolerance": tolerance})


KEPT = tuple(kept(frames, tolerance) for frames in FRAMES for tolerance in (*TOLERANCES, ALWAYS))


@dataclass(frozen=True)
class Row:
    """A variant's scores, its times, and by how many frames its light is late, None where light does not change."""

    trial: Trial
    times: Sequence[Time]
    lag: float | None


def reuse_study(stage: Stage, *, rounds: int) -> dict[str, Row]:
    """By label: needed texels lit anew in each frame, and kept for some frames up to some change."""
    times = in_turns({v.label: frame_task(stage, v) for v in (PIXELS, PLAIN, *KEPT)}, rounds)
    now = stage.pictures(PLAIN)
    settings = TslSettings.model_validate(THRIFTY)
    before = [late(stage.shot(frame), settings) for frame in stage.frames]
    drift = [a - b.rgba for a, b in zip(before, now, strict=True)]
    rows = {PIXELS.label: Row(stage.measure(PIXELS, names=["budget"]), times[PIXELS.label], None)}
    for variant in (PLAIN, *KEPT):
        pictures = now if variant is PLAIN else stage.pictures(variant)
        lag = lateness([a.rgba - b.rgba for a, b in zip(pictures, now, strict=True)], drift)
        trial = stage.measure(variant, names=["budget"], pictures=pictures)
        rows[variant.label] = Row(trial, times[variant.label], lag)
    return rows


def late(shot: Shot, settings: TslSettings) -> Image:
    """A frame under the light of the frame before: its eye and its sun, seen from where the camera is now."""
    screen, tiles = planned_alone(shot, settings)
    pool, before = Pool(shot.launcher), shot.at(shot.frame - 1)
    tiles.table.host[EPOCH] = before.frame
    lighting = Lighting(before, Ways(before, INPUTS[settings.inputs]))
    jobs = pool.placing(tiles, lighting.light(tiles), Held.nothing(shot.launcher))()
    Relighting(tiles, pool.texels, lighting)(jobs)
    return to_image(pasting(screen, tiles, pool.texels)())


def lateness(change: Sequence[Image], drift: Sequence[Image]) -> float | None:
    """Frames by which light is late: how often `drift`, what light of one frame ago changes, is in a change.

    By least squares over RGB; light that is late by so little that its change is linear reads its age. None where light
    does not drift.
    """
    pairs = [(a[..., :3].astype(np.float64), b[..., :3].astype(np.float64)) for a, b in zip(change, drift, strict=True)]
    whole = sum(float(np.sum(b * b)) for _, b in pairs)
    return sum(float(np.sum(a * b)) for a, b in pairs) / whole if whole > 0 else None


def answers(found: Mapping[str, Mapping[str, Row]]) -> list[str]:
    """What keeping light saves, in words, a line a sequence."""
    return [f"**What keeping light saves** on `{name}`: {_verdict(rows)}" for name, rows in found.items()]


def section(found: Mapping[str, Mapping[str, Row]]) -> Section:
    """What the study shows, by sequence."""
    parts: list[str | Table] = [
        "Light depends on the eye and the sun, not on where the camera looks. A tile is lit when it comes into sight; "
        "`reuse` keeps its light for N frames at most, tiles taking turns, and `tolerance` bounds by how much it may "
        "have changed meanwhile, as a part of the peak of the highlight of the maps' highest power. Where light "
        "changes the first frame, too, follows others whose light it keeps. All rows but the first are "
        '`texels = "needed"` with moments (`vmf`). *Lag* is by how many frames light is late: how often the '
        "difference that light of one frame ago makes is in the picture.",
    ]
    for sequence, rows in found.items():
        parts += [f"`{sequence}`: {_verdict(rows)}", _table(sequence, rows)]
    parts.append(
        "It fails where light itself moves: under a sun that sweeps by a degree a frame nothing can be kept within the "
        "tolerance, and what the schedule keeps is an error several times as large. Where the eye stands still it "
        "saves nearly all shading, and the light stays exact. Wires and posts are always lit anew, segments while the "
        "road's end cuts them and hills while they turn away. What binds is what no kept light saves: finding which "
        "texels are read, and pasting them by footprints that are new in each frame."
    )
    return Section("Light kept from frame to frame", parts)


def _verdict(rows: Mapping[str, Row]) -> str:
    """The cheapest setting within 5 % of the error, and what is left where hardly anything is lit anew, in words."""
    plain, pixels = rows[PLAIN.label], rows[PIXELS.label]
    kept = [rows[variant.label] for variant in KEPT]
    able = [row for row in kept if (row.trial.rms() or 0.0) <= WANTED * (plain.trial.rms() or 0.0)]
    best = min(able, key=lambda row: cpu(row.times), default=plain)
    least = min(kept, key=lambda row: row.trial.shaded)
    whole = max(plain.trial.shaded, 1.0)
    binds = (
        f" The least that was tried to be lit anew, {least.trial.shaded / whole:.2f} of the texels "
        f"(`{least.trial.variant.label}`), takes {cpu(least.times) / cpu(plain.times):.2f} of the time."
    )
    shaded = np.array([row.trial.shaded for row in kept])
    if np.ptp(shaded) > SOME * whole:
        _, none = np.polyfit(shaded, [cpu(row.times) for row in kept], 1)
        binds += (
            f" With none lit anew it would be {none / cpu(plain.times):.2f}, by a straight line through all that keep "
            "light (least squares): no more can be saved."
        )
    if cpu(best.times) >= cpu(plain.times):
        return f"nothing that was tried is cheaper within {WANTED:g} times the error.{binds}"
    return (
        f"within {WANTED:g} times the error the cheapest is `{best.trial.variant.label}`: "
        f"{cpu(best.times) / cpu(plain.times):.2f} of the time of lighting anew, "
        f"{cpu(best.times) / cpu(pixels.times):.1f} times `pixel-aniso`, "
        f"{best.trial.shaded / whole:.2f} of the texels.{binds}"
    )


def _table(sequence: str, rows: Mapping[str, Row]) -> Table:
    plain, pixels = rows[PLAIN.label], rows[PIXELS.label]
    cells: list[list[Cell]] = []
    for label, row in rows.items():
        ms, error, whole = cpu(row.times), row.trial.rms(), plain.trial.rms()
        cost: list[Cell] = [label, round(row.trial.shaded), ms, ms / cpu(pixels.times)]
        of_plain = error / whole if error is not None and whole else None
        cells.append([*cost, error, of_plain, row.trial.rms("flicker"), row.lag])
    headings = ["light", "texels a frame", "ms of all cores", "of `pixel-aniso`", "error", "of anew", "flicker", "lag"]
    return Table(f"tsl reuse {sequence}", headings, cells)
