"""What reflectance models cost: the deck's two tables, and ours beside them, measured."""

import functools
import time
from collections.abc import Callable
from dataclasses import dataclass, field
from statistics import median
from typing import Any, cast

import numpy as np
import warp as wp
from numpy.typing import NDArray

from metrics.kernels.launch import Launcher
from sequences import asphalt
from swimlab.render.brdf import Model
from swimlab.render.catalogue import brdfs
from swimlab.render.kernels.inspection import cosines, evaluations, shaded_samples
from swimlab.render.kernels.packet import plain_packet
from swimlab.render.kernels.shading import in_local_frame
from swimlab.render.kernels.structs import LANES, TEXELS, Sun

Floats = NDArray[np.float32]

TEXELS_NEEDED = {False: 8, True: 10}
"""Floats of a texel without and with a twist, by whether a model is anisotropic."""
MAPS = {8: 3, 10: 4}
"""Maps that are interleaved in a texel: albedo, normal, gloss, and twist."""
POWERS = (10, 100, 1_000, 10_000, 100_000)
"""Powers at which tables are compared with formulas."""


@dataclass(frozen=True)
class Form:
    """A row of the deck's tables: a model under some parameters, and the deck's texture and ALU costs.

    minimal, varied: (fetches, instructions) with minimal and with surface variation, as the deck writes them.
    """

    brdf: str
    minimal: tuple[str, str]
    varied: tuple[str, str]
    parameters: dict[str, Any] = field(default_factory=dict)
    note: str = ""

    @property
    def label(self) -> str:
        """The model's name, and what is special about its parameters."""
        return f"{self.brdf} ({self.note})" if self.note else self.brdf

    @property
    def model(self) -> Model:
        """The model with its parameters."""
        brdf = brdfs()[self.brdf]
        return brdf.model(brdf.settings.model_validate(self.parameters))


LOBES = [{"x": x, "y": x, "z": z, "exponent": n} for x, z, n in ((-1, 1, 0.25), (-1, 0.9, 0.125), (0.9, 1, 0.0625))]
ENERGY = {"normalisation": "energy"}
STRANDS = ENERGY | {"exponent": 0.25}
FORMS = (
    Form("blinn-phong", ("0", "7"), ("1", "15")),
    Form("blinn-phong-factored", ("1", "2"), ("2", "10")),
    Form("banks", ("0", "12"), ("1", "25"), STRANDS),
    Form("banks-factored", ("1", "5"), ("2", "18"), STRANDS),
    Form("ashikhmin-shirley", ("0", "40"), ("2", "50 (60)"), {"anisotropy": 4.0}),
    Form("ashikhmin-shirley-factored", ("4", "10"), ("6", "30"), {"anisotropy": 4.0}),
    Form("lafortune", ("0", "10+5n"), ("2", "30+5n"), ENERGY, "1 lobe"),
    Form("lafortune", ("0", "10+5n"), ("2", "30+5n"), ENERGY | {"lobes": LOBES}, "3 lobes"),
    Form("cook-torrance", ("0", "35"), ("1", "40")),
)
"""The rows. Models that may go without normalisation have one, and highlights are as wide over slopes as Blinn-Phong's:
what moment chains widen is the power."""


@dataclass(frozen=True)
class Cost:
    """A row of ours: what a form reads, and ns an evaluation on one thread.

    lookups, table_bytes: of its own tables. maps, texel_bytes: what surface variation reads, in one fetch of an
    interleaved texel. minimal, varied, native: ns, the last in the vectorised form where there is one.
    """

    form: str
    lookups: int
    table_bytes: int
    maps: int
    texel_bytes: int
    minimal: float
    varied: float
    native: float | None


LOOP = "the loop alone"
"""Row of a model that only adds up its cosines: what reading samples and the local frame cost by themselves."""


def time_models(
    launcher: Launcher, *, samples: int = 16384, rounds: int = 61, advance: Callable[[str], None] = lambda _: None
) -> list[Cost]:
    """Time every form on the same samples in one run; medians over rounds that take the forms in turn, on one thread.

    samples: a multiple of 64, few enough that most calls end within a time slice of the system's scheduler. Half
        vectors lie about the normal as widely as the highlights of asphalt do.
    `advance` is called with each round.
    """
    models = {form.label: form.model for form in FORMS} | {LOOP: Model(cast(wp.Function, cosines))}
    runs: dict[tuple[str, str], Callable[[], None]] = {}
    scene = _Samples(launcher, samples)
    for label, model in models.items():
        width = TEXELS_NEEDED[model.anisotropic]
        runs[label, "minimal"] = scene.minimal(model)
        runs[label, "varied"] = scene.varied(plain_packet(in_local_frame(model.evaluate, width), width), width)
        if model.native is not None:
            runs[label, "native"] = scene.varied(model.native, width)
    for run in runs.values():
        run()
    times: dict[tuple[str, str], list[float]] = {key: [] for key in runs}
    for round_ in range(rounds):
        for key, run in runs.items():
            started = time.perf_counter()
            run()
            times[key].append(1e9 * (time.perf_counter() - started) / samples)
        advance(f"round {round_ + 1}")
    return [
        _cost(label, model, {how: median(ns) for (of, how), ns in times.items() if of == label})
        for label, model in models.items()
    ]


def _cost(label: str, model: Model, ns: dict[str, float]) -> Cost:
    width = TEXELS_NEEDED[model.anisotropic]
    return Cost(
        form=label,
        lookups=len(model.tables),
        table_bytes=sum(table.values.nbytes for table in model.tables),
        maps=MAPS[width],
        texel_bytes=4 * width,
        minimal=ns["minimal"],
        varied=ns["varied"],
        native=ns.get("native"),
    )


class _Samples:
    """Samples of asphalt under a sun, on the device: texels, positions, and directions in the local frame."""

    def __init__(self, launcher: Launcher, count: int) -> None:
        rng = np.random.default_rng(0)
        maps = np.concatenate(asphalt.make(0, 256), axis=2).reshape(-1, 8)
        texels = maps[rng.integers(0, len(maps), count)]
        turn = rng.uniform(0, 2 * np.pi, count)
        twist = np.stack([np.cos(turn), np.sin(turn)], axis=1)
        light, view = about_highlights(texels[:, 7], seed=1)
        self._launcher, self._count = launcher, count
        self._light, self._view = (launcher.array(each, wp.vec3) for each in (light, view))
        self._texels = {
            8: launcher.array(texels, TEXELS[8]),
            10: launcher.array(np.concatenate([texels, twist], axis=1).astype(np.float32), TEXELS[10]),
        }
        self._positions = launcher.array(-20 * view, wp.vec3)
        sun: Any = Sun()
        sun.direction, sun.diffuse = wp.vec3(*light.mean(axis=0).tolist()), 0.6
        self._sun = sun
        self._out, self._colours = launcher.empty(count // LANES, wp.float32), launcher.empty(count, wp.vec3)

    def minimal(self, model: Model) -> Callable[[], None]:
        """Evaluate a model under one albedo, Ks and power in the local frame."""
        inputs = [wp.vec3(0.1, 0.1, 0.1), 0.05, 60.0, 0.6, self._light, self._view, self._out]
        return functools.partial(self._launcher.launch, evaluations(model.evaluate), self._count // LANES, inputs)

    def varied(self, shade_packet: wp.Function, width: int) -> Callable[[], None]:
        """Fill packets with texels and shade them in their own frames."""
        inputs = [self._texels[width], self._positions, self._sun, self._colours]
        kernel = shaded_samples(shade_packet, width)
        return functools.partial(self._launcher.launch, kernel, self._count // LANES, inputs)


def about_highlights(power: NDArray[Any], *, seed: int) -> tuple[Floats, Floats]:
    """Unit directions to light and eye [N, 3] for powers [N], N.L and N.V > .05.

    Their half vectors lie about the normal as a lobe of the power spreads them.
    """
    rng = np.random.default_rng(seed)
    count = len(power)
    light, view = np.empty((count, 3)), np.empty((count, 3))
    left = np.arange(count)
    while left.size:
        towards = rng.normal(size=(left.size, 3))
        towards[:, 2] = np.abs(towards[:, 2])
        spread = rng.normal(size=(left.size, 2)) / np.sqrt(power[left, None] + 1)
        half = np.concatenate([spread, np.ones((left.size, 1))], axis=1)
        towards, half = (each / np.linalg.norm(each, axis=1, keepdims=True) for each in (towards, half))
        light[left] = towards
        view[left] = 2 * (half * towards).sum(axis=1, keepdims=True) * half - towards
        left = left[np.minimum(light[left, 2], view[left, 2]) < 0.05]
    return light.astype(np.float32), view.astype(np.float32)


@dataclass(frozen=True)
class TableError:
    """How far a factored form's highlight is from its formula's at a power: rms by the formula's rms, and the largest
    difference by the formula's value, or by its median where that is larger."""

    form: str
    power: int
    rms: float
    largest: float


def table_errors(launcher: Launcher, *, samples: int = 65536) -> list[TableError]:
    """Compare every factored form with its formula about highlights of `POWERS`, at Ks = .3 and no diffuse."""
    found = []
    direct = {form.brdf: form for form in FORMS}
    for form in FORMS:
        if not form.model.tables:
            continue
        formula = direct[form.brdf.removesuffix("-factored")]
        for power in POWERS:
            light, view = about_highlights(np.full(samples, power), seed=2)
            exact, table = (_highlights(launcher, each.model, power, light, view) for each in (formula, form))
            difference = table - exact
            rms = float(np.sqrt(np.mean(difference**2) / np.mean(exact**2)))
            largest = float((np.abs(difference) / np.maximum(exact, np.median(exact))).max())
            found.append(TableError(form.label, power, rms, largest))
    return found


def _highlights(launcher: Launcher, model: Model, power: float, light: Floats, view: Floats) -> NDArray[np.float64]:
    """Radiance of each sample [N]."""
    out = launcher.empty(len(light), wp.float32)
    directions = [launcher.array(each, wp.vec3) for each in (light, view)]
    inputs = [wp.vec3(0.0, 0.0, 0.0), 0.3, power, 0.6, *directions, out]
    launcher.launch(evaluations(model.evaluate, each=1), len(light), inputs)
    return np.asarray(out.numpy(), np.float64)
