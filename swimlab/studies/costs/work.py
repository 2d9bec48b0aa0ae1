"""The work of a frame: texels that are read, evaluations of the model, and what both cost at the least here."""

import time
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from functools import partial
from typing import Any

import numpy as np
import warp as wp

from metrics.kernels.launch import Launcher, Strip
from swimlab.render.inputs import BOX
from swimlab.render.kernels.inspection import count_reads, filtered_samples, shaded_samples
from swimlab.render.kernels.packet import PLACES
from swimlab.render.kernels.structs import LANES
from swimlab.render.kernels.texture_filter import anisotropic_to
from swimlab.render.shot import Shot
from swimlab.render.triangles import visibility
from swimlab.studies.trials import Variant

PROBES = 16
"""Probes of every footprint that the rate of reading is measured over."""
PACKETS = 128
"""Packets that rates are measured over: few enough to stay in a core's cache."""


@dataclass(frozen=True)
class Sight:
    """What the pixels of a shot read under the filters; each is counted once."""

    shot: Shot
    _known: dict[tuple[int, int], int] = field(default_factory=dict)

    def anisotropic(self, most: int, n: int = 1) -> int:
        """Texels that up to `most` probes of n x n samples a pixel read; most = 0: those of trilinear filtering."""
        if (most, n) not in self._known:
            self._known[most, n] = self._count(most, n)
        return self._known[most, n]

    def _count(self, most: int, n: int) -> int:
        launcher, shot, grid = self.shot.launcher, self.shot, self.shot.grid(n)
        visible = visibility(launcher, shot.triangles, grid, Strip(0, shot.view.height), n)
        reads = launcher.empty(grid.height, wp.int32)
        inputs = [most, grid, visible, shot.triangles.planes, shot.material.chain(BOX).shape, reads]
        launcher.launch(count_reads, grid.height, inputs)
        return int(reads.numpy().sum(dtype=np.int64))


Reads = Callable[[Sight, Any, int], int]


def _stretched(sight: Sight, settings: Any, shaded: int) -> int:
    return sight.anisotropic(settings.anisotropy)


READS: Mapping[str, Reads] = {
    "pixel-point": lambda sight, settings, shaded: shaded,
    "pixel-bilinear": lambda sight, settings, shaded: 4 * shaded,
    "pixel-trilinear": lambda sight, settings, shaded: sight.anisotropic(0),
    **dict.fromkeys(("pixel-aniso", "lod-hack", "toksvig", "vmf", "clean", "lean", "taa"), _stretched),
    "specular-aa": lambda sight, settings, shaded: 3 * sight.anisotropic(settings.anisotropy),
    "supersample": lambda sight, settings, shaded: sight.anisotropic(settings.anisotropy, round(settings.samples**0.5)),
    "reference": lambda sight, settings, shaded: 4 * shaded,
    "vertex": lambda sight, settings, shaded: 4 * shaded,
    # Texels are shaded at one level of the maps, and pasted as a texture of about their size.
    "tsl": lambda sight, settings, shaded: 4 * shaded + sight.anisotropic(settings.anisotropy),
}
"""Technique -> (what is in sight, settings, evaluations of the model) -> texels that a frame must read at the least.

Pixels of a history are not texels; other techniques' reads are not known.
"""


def reads_of(variant: Variant, settings: Any, sight: Sight, shaded: int) -> int | None:
    """Texels that a frame of a variant must read; None for a technique that is not known here."""
    known = READS.get(variant.technique)
    return None if known is None else known(sight, settings, shaded)


@dataclass(frozen=True)
class Rates:
    """Nanoseconds of one core: to read a texel and weigh it, to evaluate the model; everything in the core's cache."""

    read_ns: float
    shade_ns: float

    def least_ms(self, reads: int, shaded: int) -> float:
        """What reading and shading cost at these rates."""
        return 1e-6 * (reads * self.read_ns + shaded * self.shade_ns)


def measured_rates(shot: Shot, *, rounds: int) -> Rates:
    """The best of some rounds of this program's own filter and of the shot's reflectance model."""
    launcher, chain = shot.launcher, shot.material.chain(BOX)
    width, count = chain.floats, LANES * PACKETS
    out = launcher.empty((PACKETS, width * LANES), wp.float32)
    fill = anisotropic_to(PROBES).fill(width, launcher.device)
    inputs = [chain.texels, chain.shape, LANES, launcher.array(_footprints(shot), wp.float64), out]
    read = partial(launcher.launch, filtered_samples(fill, width), PACKETS, inputs)
    texels, colours = launcher.empty(count, chain.texels.dtype), launcher.empty(count, wp.vec3)
    texels.assign(chain.texels[:count] if len(chain.texels) >= count else np.ones((count, width), np.float32))
    towards = np.random.default_rng(0).normal((0, 20, -2), size=(count, 3))
    arguments = [texels, launcher.array(towards.astype(np.float32), wp.vec3), shot.sun, colours]
    kernel = shaded_samples(shot.shade_packet(BOX, width), width)
    shade = partial(launcher.launch, kernel, PACKETS, arguments)
    return Rates(_best(launcher, read, rounds) / (count * PROBES * 8), _best(launcher, shade, rounds) / count)


def _footprints(shot: Shot) -> Any:
    """Places [PACKETS, PLACES] of footprints of PROBES probes between two levels, side by side as pixels are."""
    width, height = shot.material.size
    at, step = np.indices((PACKETS, LANES)), 1.5
    rows = np.zeros((PACKETS, 6, LANES))
    rows[:, 0], rows[:, 1] = at[1] * step / width, at[0] * step * PROBES / height % 1.0
    rows[:, 2], rows[:, 5] = step / width, step * PROBES / height
    return rows.reshape(PACKETS, PLACES)


def _best(launcher: Launcher, work: Callable[[], None], rounds: int) -> float:
    """Least nanoseconds of some calls, after one that compiles."""
    work()
    spent = []
    for _ in range(rounds):
        wp.synchronize_device(launcher.device)
        started = time.perf_counter()
        work()
        wp.synchronize_device(launcher.device)
        spent.append(1e9 * (time.perf_counter() - started))
    return min(spent)
