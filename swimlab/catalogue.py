"""What is there to choose from: techniques and reflectance models by name, found in their folders."""

from functools import cache

import swimlab.brdfs
import swimlab.techniques
from sequences import Sequence
from swimlab.brdf import Brdf, Model
from swimlab.registry import discover
from swimlab.settings import Settings
from swimlab.technique import Technique


@cache
def techniques() -> dict[str, Technique]:
    """Every technique by its name."""
    return discover(swimlab.techniques, "TECHNIQUE")


@cache
def brdfs() -> dict[str, Brdf]:
    """Every reflectance model by its name."""
    return discover(swimlab.brdfs, "BRDF")


def model_of(sequence: Sequence) -> Model:
    """The reflectance model of a sequence's material, with its parameters."""
    material = sequence.scene.material
    brdf = brdfs()[material.brdf]
    return brdf.model(brdf.settings.model_validate(material.parameters))


def brdf_settings() -> dict[str, type[Settings]]:
    """The parameters of every reflectance model, to check sequence files by."""
    return {name: brdf.settings for name, brdf in brdfs().items()}


def technique_settings() -> dict[str, type[Settings]]:
    """The settings of every technique, to check sequence files by."""
    return {name: technique.settings for name, technique in techniques().items()}
