"""What it means that the motion of some pairs of frames is wrong: jitter in all, wrong throughout, or single frames."""

from collections.abc import Callable
from typing import Literal

import numpy as np

from swimlab.footage.check.events import FEW, MENDED, Stray
from swimlab.footage.check.jitter import integrated
from swimlab.footage.check.lucas_kanade import Values
from swimlab.footage.check.pairs import PairFit
from swimlab.footage.check.weighing import POOR
from swimlab.footage.pattern import frame_range

Misfit = Literal["", "jitter", "most", "frames"]
"""Nothing; a jitter; wrong in most frames; wrong in those that stray."""

_FURTHEST = 2.0
"""A jitter moves the picture by less than this, px: half a pixel at an upscaler's render size."""


def misfit_of(strays: list[Stray], pairs: list[PairFit]) -> Misfit:
    """What strays among the pairs come from."""
    if not strays:
        return ""
    if len(strays) > FEW * len(pairs) and _is_jitter(pairs):
        return "jitter"
    return "most" if len(_unfit(strays, pairs)) > len(pairs) / 2 else "frames"


def _unfit(strays: list[Stray], pairs: list[PairFit]) -> list[PairFit]:
    """Pairs that leave much, and far more than strays do under the motion that explains those: it is not noise."""
    level = float(np.median([stray.left for stray in strays]))
    return [pair for pair in pairs if pair.given > POOR and (1 - MENDED) * pair.given**2 > level**2]


def jitter_of(pairs: list[PairFit]) -> float:
    """px rms of the jitter that the motion has and the frames have not."""
    return float(np.sqrt((_offsets(pairs) ** 2).sum(axis=1).mean()))


def most_said(strays: list[Stray], pairs: list[PairFit]) -> str:
    """That a motion is wrong in most frames, in words."""
    return (
        f"does not fit most frames: in {len(_unfit(strays, pairs))} of {len(pairs)} it leaves more than half of the "
        "change. Check its channels, unit and scale, and that each frame has its own vectors"
    )


def frames_said(strays: list[Stray], number: Callable[[int], int]) -> str:
    """Frames whose vectors are wrong, in words."""
    named = frame_range([number(stray.late) for stray in strays])
    furthest = "{:.2g},{:.2g}".format(*(max(strays, key=lambda stray: stray.length).lacking + 0.0))
    return f"does not fit frames {named}: the picture moves there by up to {furthest} px more. Mend these vectors"


def _is_jitter(pairs: list[PairFit]) -> bool:
    """Whether a shift of each frame, none of them far, takes most of what is left away."""
    given, rigid = (float(np.median([getattr(pair, name) for pair in pairs])) for name in ("given", "rigid"))
    cured = rigid**2 <= (1 - MENDED) * given**2
    return cured and float(np.hypot(*_offsets(pairs).T).max()) < _FURTHEST


def _offsets(pairs: list[PairFit]) -> Values:
    """[n, 2] px, of each pair's later frame."""
    first = pairs[0].early
    seen = [first, *(pair.late for pair in pairs)]
    return np.asarray(integrated(pairs, seen[-1] + 1)[seen])
