"""What is there to choose from: techniques and reflectance models by name, found in their folders."""

from functools import cache

import swimlab.brdfs
import swimlab.techniques
from swimlab.brdf import Brdf
from swimlab.registry import discover
from swimlab.technique import Settings, Technique


@cache
def techniques() -> dict[str, Technique]:
    """Every technique by its name."""
    return discover(swimlab.techniques, "TECHNIQUE")


@cache
def brdfs() -> dict[str, Brdf]:
    """Every reflectance model by its name."""
    return discover(swimlab.brdfs, "BRDF")


def technique_settings() -> dict[str, type[Settings]]:
    """The settings of every technique, to check sequence files by."""
    return {name: technique.settings for name, technique in techniques().items()}
