"""How wide a highlight moment chains make of rough normals, against the normals themselves, drawn at random."""

from collections.abc import Sequence
from dataclasses import dataclass
from math import sqrt

import numpy as np
from numpy.typing import NDArray

from metrics.kernels.launch import Launcher
from swimlab.render.inputs import Inputs, Maps
from swimlab.render.kernels.inspection import resolve_coarsest
from swimlab.render.material import Material
from swimlab.render.techniques import clean, lean, toksvig, vmf
from swimlab.report.charts import Axis, Line
from swimlab.report.palette import TECHNIQUES
from swimlab.studies.page import Section, Table, chart

CHAINS = (toksvig.INPUTS, vmf.INPUTS, clean.INPUTS, lean.INPUTS)
SIGMAS = (0.02, 0.05, 0.1, 0.15, 0.2, 0.25, 0.3)
TABLED = (0.02, 0.1, 0.2, 0.3)
POWERS = (10.0, 1e3, 1e5)
CHARTED = 1e3
SIDE = 256
STRATA = 1_000_000


@dataclass(frozen=True)
class Row:
    """A chain at one roughness and power, as ratios less 1.

    variance: what it adds to 1/power over the variance of the drawn slopes. peak: of the highlight over the mean of
    the shaded peaks of all drawn normals.
    """

    sigma: float
    power: float
    chain: str
    variance: float
    peak: float


def drawn(sigma: float) -> NDArray[np.float64]:
    """SIDE x SIDE slopes, normal with deviation sigma along each axis, in pairs about 0, [SIDE, SIDE, 2]."""
    half = np.random.default_rng(0).normal(size=(SIDE // 2, SIDE, 2)) * sigma
    return np.concatenate([half, -half])


def moment_study(launcher: Launcher, sigmas: Sequence[float] = SIGMAS, powers: Sequence[float] = POWERS) -> list[Row]:
    """Filter maps of drawn normals down to one texel and compare."""
    rows = []
    for sigma in sigmas:
        slopes = drawn(sigma)
        normal = np.concatenate([slopes, np.ones((SIDE, SIDE, 1))], axis=2)
        normal /= np.linalg.norm(normal, axis=2, keepdims=True)
        spread = float(np.mean(slopes**2))
        for power in powers:
            exact = mean_peak(sigma, power)
            for chain in CHAINS:
                found = effective_power(launcher, chain, normal, power)
                rows.append(Row(sigma, power, chain.name, (1 / found - 1 / power) / spread - 1, found / exact - 1))
    return rows


def mean_peak(sigma: float, power: float) -> float:
    """Mean of power (N.z)^power, the highlights' peaks with the deck's normalisation, over Gaussian slopes.

    Squared slopes are exponential, and drawn by strata: at a power of 1e5 one in 10,000 of them shines.
    """
    squared = -2 * sigma**2 * np.log((np.arange(STRATA) + 0.5) / STRATA)
    return float(np.mean(power * (1 + squared) ** (-power / 2)))


def effective_power(launcher: Launcher, inputs: Inputs, normal: NDArray[np.float64], power: float) -> float:
    """The power, and with the deck's normalisation the peak, of the highlight that a whole map comes to."""
    size = normal.shape[:2]
    gloss = np.broadcast_to(np.array([1, power], np.float32), (*size, 2))
    maps = Maps(np.zeros((*size, 3), np.float32), normal.astype(np.float32), gloss)
    chain = Material(launcher, maps).chain(inputs)
    if inputs.resolve is None:
        raise ValueError(f"{inputs.name}: filters no moments")
    out = launcher.empty(1, chain.texels.dtype)
    launcher.launch(resolve_coarsest(inputs.resolve), 1, [chain.shape, chain.texels, out])
    texel = out.numpy()[0].astype(np.float64)
    if inputs.reflect is not None:  # a covariance in the place of the power
        return float(1 / sqrt(texel[5] * texel[7] - texel[8] ** 2))
    return float(texel[7])


def percent(share: float) -> float:
    """In hundredths, to two decimals."""
    return round(100 * share, 2) + 0.0


def section(rows: Sequence[Row]) -> Section:
    """What the study shows."""
    names = [chain.name for chain in CHAINS]
    by_place = {(row.sigma, row.power, row.chain): row for row in rows}
    places = sorted({(row.power, row.sigma) for row in rows if row.sigma in TABLED})
    table = Table(
        "moments",
        ["power", "sigma", *(f"{name}: variance, %" for name in names), *(f"{name}: peak, %" for name in names)],
        [
            [
                int(power),
                sigma,
                *(percent(by_place[sigma, power, name].variance) for name in names),
                *(percent(by_place[sigma, power, name].peak) for name in names),
            ]
            for power, sigma in places
        ],
    )
    off = {name: max((row for row in rows if row.chain == name), key=lambda row: abs(row.variance)) for name in names}
    said = ", ".join(f"`{name}` {percent(row.variance):+.3g} %" for name, row in off.items())
    charts = [
        chart(
            f"moments-{what}.svg",
            f"{title} against the deviation of the slopes, power {CHARTED:g}",
            [
                Line(
                    name,
                    [row.sigma for row in rows if (row.power, row.chain) == (CHARTED, name)],
                    [100 * getattr(row, what) for row in rows if (row.power, row.chain) == (CHARTED, name)],
                    colour,
                )
                for name, colour in zip(names, TECHNIQUES, strict=False)
            ],
            x=Axis("deviation of the slopes"),
            y=Axis("error, %"),
        )
        for what, title in (("variance", "Error of the added variance"), ("peak", "Error of the highlight's peak"))
    ]
    return Section(
        "What a moment chain knows of roughness",
        [
            "A rough patch that shrinks under a pixel must become a wider highlight. Slopes of normals are drawn at "
            f"random ({SIDE * SIDE:,} of them, Gaussian) and filtered by each chain down to one texel. *Variance* is "
            "how far the width that it adds is off the variance of the slopes that were drawn; *peak* is how far its "
            "highlight's brightest point is off the mean of the highlights of all normals, shaded one by one. 0 is the "
            f"reference. The variances are off by at most: {said}.",
            *charts,
            table,
        ],
    )
