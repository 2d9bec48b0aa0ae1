"""How much of a flicker is nothing but the rounding of frames to the codes that they are stored in."""

from collections.abc import Sequence

import numpy as np

from metrics.measurement import Measurement, Metric

SCORES = {
    "quantisation.floor": Metric(
        "radiance^2",
        "information",
        "flicker that rounding to the stored codes makes by itself; none of 32-bit floats",
        "a code's step^2 / 12 (Bennett 1948, Spectra of Quantized Signals)",
        "mean of step^2 / 12 over pixels and frames, step in radiance",
    )
}


def quantisation(floors: Sequence[float | None], count: int) -> Measurement:
    """The score from the mean squared rounding errors of some of a clip's frames, radiance^2, None of 32-bit floats.

    count: frames of the clip. The standard error is that of a sample of so many (Cochran 1977, eq. 2.20).
    """
    found = Measurement()
    known = [floor for floor in floors if floor is not None]
    if not known:
        found.absent["quantisation.floor"] = "32-bit floats have no steps that matter"
        return found
    spread = float(np.std(known, ddof=1)) if len(known) > 1 else 0.0
    error = spread * np.sqrt(max(0.0, 1 - len(known) / count) / len(known))
    found.put("quantisation.floor", float(np.mean(known)), "", error=error)
    return found
