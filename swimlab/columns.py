"""The columns of a table of scores."""

from math import sqrt

COLUMNS = {
    "rms error": ("budget.mse", sqrt),
    "bias": ("budget.bias", sqrt),
    "detail": ("budget.detail", sqrt),
    "flicker": ("budget.flicker", sqrt),
    "floor": ("budget.floor", sqrt),
    "residual": ("residual.flicker", sqrt),
    "of reference": ("residual.flicker.reference", sqrt),
    "visible": ("visible.flicker", float),
    "quantised": ("quantisation.floor", sqrt),
    "on plane": ("plane.on", float),
    "order 1": ("plane.order1", float),
    "order 2": ("plane.order2", float),
    "scale rmse": ("scale.rmse", float),
    "mean drift %": ("scale.mean_drift", float),
    "highlight": ("scale.highlight", float),
    "FLIP": ("flip.mean", float),
    "FLIP (oiio)": ("flip-oiio.mean", float),
    "JOD": ("vdp.jod", float),
}
"""Heading -> the score behind it and how it is shown; squared radiance is shown as its root, as radiance."""
