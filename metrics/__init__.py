"""Measures of the stability of frames: what is glued to the surface, what flickers, swims or is aliased."""

from metrics.bloom import Bloom
from metrics.clip import Clip, ClipError
from metrics.display import Display
from metrics.measurement import Measurement, Metric
from metrics.quantisation import quantisation
from metrics.ratios import resolved
from metrics.reference_frames import ReferenceFrames
from metrics.registry import METRICS
from metrics.scale import measure_scales
from metrics.score import Measuring, measure
from metrics.spans import Alignment, align

__all__ = [
    "METRICS",
    "Alignment",
    "Bloom",
    "Clip",
    "ClipError",
    "Display",
    "Measurement",
    "Measuring",
    "Metric",
    "ReferenceFrames",
    "align",
    "measure",
    "measure_scales",
    "quantisation",
    "resolved",
]
