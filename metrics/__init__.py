"""Measures of the stability of frames: what is glued to the surface, what flickers, swims or is aliased."""

from metrics.clip import Clip, ClipError
from metrics.measurement import Measurement, Metric
from metrics.ratios import resolved
from metrics.registry import METRICS
from metrics.scale import measure_scales
from metrics.score import measure
from metrics.spans import Alignment, align

__all__ = [
    "METRICS",
    "Alignment",
    "Clip",
    "ClipError",
    "Measurement",
    "Metric",
    "align",
    "measure",
    "measure_scales",
    "resolved",
]
