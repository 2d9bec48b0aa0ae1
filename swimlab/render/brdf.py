"""What a reflectance model is."""

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any, NamedTuple

import warp as wp

from swimlab.render.kernels.table import Table
from swimlab.render.settings import Settings


class Model(NamedTuple):
    """A reflectance model with its settings chosen.

    evaluate: (albedo, Ks, power, light, view, diffuse) -> radiance in the local frame, where the normal is (0, 0, 1)
        and the tangent (1, 0, 0): the model as it is read. Roughness is the power of Blinn-Phong in every model, so
        that filters of roughness serve all.
    native: (lanes, sun), the same over a packet of samples of 8-float texels in a form that a CPU compiler vectorises.
    slopes_are_gaussian: its lobe is the deck's power (N.H)^power, close to a Gaussian of slopes, as LEAN takes it.
    anisotropic: it changes as the tangent turns about the normal, so that a map of twist matters.
    tables: those that an evaluation looks up, each once.
    """

    evaluate: wp.Function
    native: wp.Function | None = None
    slopes_are_gaussian: bool = False
    anisotropic: bool = False
    tables: tuple[Table, ...] = ()


@dataclass(frozen=True)
class Brdf:
    """A reflectance model as the sequence file names it.

    model: settings -> Model; the same one for the same settings, for kernels are made per Model.
    """

    name: str
    summary: str
    source: str
    model: Callable[[Any], Model]
    settings: type[Settings] = Settings
