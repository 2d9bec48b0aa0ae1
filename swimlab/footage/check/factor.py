"""The factor that fits a motion: whether it is off, how it is said, and the setting that mends it."""

from typing import TypeGuard

import numpy as np
from numpy.typing import NDArray

from swimlab.footage.check.baseline import LEAST, Scale, ScaledMotion
from swimlab.footage.motion import FieldMotion, Motion, UniformMotion
from swimlab.footage.warping import Reading
from swimlab.runs.counting import counted

SURE = 6.0
"""Standard errors by which a factor is off."""
OFF = 0.1
"""... and px over the baseline."""
NOTICED = 0.1
"""... and share of what is left that it explains: less is no fault that scores show."""
MOST = 0.53
"""... and of this share of the points: half do by chance, or where a few points rule."""
UNSURE = 0.05
"""A factor is known if it is so within a standard error of this."""


def off(scale: Scale | None) -> NDArray[np.bool_]:
    """[2] whether the motion is off along x and y, beyond what noise makes."""
    if scale is None or scale.explained < NOTICED or scale.better < MOST:
        return np.zeros(2, np.bool_)
    return np.asarray((scale.off > OFF) & (scale.off > SURE * scale.unsure))


def known(scale: Scale | None) -> bool:
    """Whether the factor of the axis that travels most is known."""
    return scale is not None and bool(scale.error[np.argmax(scale.travel)] <= UNSURE)


def right(scale: Scale | None) -> TypeGuard[Scale]:
    """Whether the factor of the axis that travels most is known to be 1, within what a factor must be known."""
    return scale is not None and known(scale) and bool(abs(scale.factor[np.argmax(scale.travel)] - 1) <= UNSURE)


def told(scale: Scale | None) -> tuple[float | None, float | None]:
    """The factors of x and y; None for an axis that does not travel, or where the picture does not tell."""
    if scale is None:
        return None, None
    tells = (scale.travel >= LEAST) & np.isfinite(scale.error)
    x, y = (float(factor) if tell else None for factor, tell in zip(scale.factor, tells, strict=True))
    return x, y


def said(scale: Scale) -> str:
    """Each axis with its standard error."""
    axes = []
    for axis, factor, drift, error, travel in zip(
        "xy", scale.factor, scale.drift, scale.error, scale.travel, strict=True
    ):
        if not np.isfinite(error):
            axes.append(f"{axis} not told")
        elif travel >= LEAST:
            axes.append(f"{axis} {factor:.4f} ± {error:.4f}")
        else:
            axes.append(f"{axis} {drift + 0.0:+.4f} ± {error:.4f} px a frame")
    return f"factor that fits over {counted(scale.apart, 'frame')}: {', '.join(axes)}"


def fitted(motion: Motion, scale: Scale | None) -> dict[str, tuple[str, Reading]]:
    """The motion that fits, as `Motion.variants` has it; empty where the given one is not off, or none at all."""
    if scale is None or not off(scale).any() or (scale.travel < LEAST).all():
        return {}
    factor = np.where(off(scale), scale.factor, 1.0)
    drift = np.where(off(scale), scale.drift, 0.0)
    longer = "{:.4g},{:.4g} times as long".format(*factor) if (factor != 1).any() else ""
    further = "{:.3g},{:.3g} px a frame further".format(*drift) if drift.any() else ""
    name = " and ".join(filter(None, (longer, further)))
    return {name: (_setting(motion, factor, drift), ScaledMotion(motion, factor, drift))}


def per_new_frame(motion: Motion, share: float) -> dict[str, tuple[str, Reading]]:
    """The motion taken as one from a new frame to the next, as `Motion.variants` has it.

    share: of the frames that are new; the others repeat the one before.
    """
    factor, none = np.full(2, share), np.zeros(2)
    return {"from one new frame to the next": (_setting(motion, factor, none), ScaledMotion(motion, factor, none))}


def _setting(motion: Motion, factor: NDArray[np.float64], drift: NDArray[np.float64]) -> str:
    if isinstance(motion, UniformMotion):
        x, y = np.array(motion.velocity) * factor + drift / motion.apart
        return f"--motion {x:.4g},{y:.4g}"
    if isinstance(motion, FieldMotion) and not drift.any():
        x, y = np.array(motion.convention.scale) * factor
        return f"--motion-scale {x:.4g}" if f"{x:.4g}" == f"{y:.4g}" else f"--motion-scale {x:.4g},{y:.4g}"
    return "vectors that are {:.4g},{:.4g} times as long, and {:.3g},{:.3g} px more".format(*factor, *drift)
