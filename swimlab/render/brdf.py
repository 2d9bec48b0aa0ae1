"""Reflectance models: the plain data of one."""

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any, NamedTuple

import warp as wp

from swimlab.render.kernels.table import Table
from swimlab.render.settings import Settings


class Model(NamedTuple):
    """A reflectance model with its settings chosen.

    evaluate: (albedo, Ks, power, light, view, diffuse) -> radiance in the local frame, where the normal is (0, 0, 1)
        and the tangent (1, 0, 0): the plain form. Every model takes roughness as the power of Blinn-Phong, so that
        filters of roughness work for all.
    native: (lanes, sun), the native form over a packet of 8-float texels; None where there is none.
    slopes_are_gaussian: its lobe is the deck's (N.H)^power, close to the Gaussian of slopes that LEAN assumes.
    anisotropic: it depends on the tangent, so that a map of twist matters.
    tables: the tables that an evaluation looks up, each once.
    """

    evaluate: wp.Function
    native: wp.Function | None = None
    slopes_are_gaussian: bool = False
    anisotropic: bool = False
    tables: tuple[Table, ...] = ()


@dataclass(frozen=True)
class Brdf:
    """A reflectance model as the sequence file names it.

    model: settings -> Model; the same Model for the same settings, as kernels are made per Model.
    """

    name: str
    summary: str
    source: str
    model: Callable[[Any], Model]
    settings: type[Settings] = Settings
