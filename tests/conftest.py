"""Every tolerance of the test suite, each with its reason. A test asks for one by name: `tolerance("edge")`."""

from collections.abc import Callable
from typing import NamedTuple

import pytest


class Tolerance(NamedTuple):
    value: float
    reason: str


TOLERANCES: dict[str, Tolerance] = {
    "rotation": Tolerance(1e-15, "sine and cosine in double precision, a few roundings"),
    "closed form": Tolerance(1e-12, "a handful of double-precision operations"),
    "central difference of hills": Tolerance(1e-5, "step 1e-4 m: third derivative (5 m, 5 m wave) and rounding"),
    "step over a map's edge": Tolerance(1.2, "times the 99th percentile of 512 rows; for unrelated normals it is 5"),
    "unit in float32": Tolerance(2e-7, "components rounded to float32"),
    "printed number": Tolerance(0.0051, "three significant digits"),
    "drawn length": Tolerance(1e-3, "lengths of some hundred units are written with two decimals"),
    "error code": Tolerance(1e-6, "1 + error is rounded to float32"),
}


@pytest.fixture(scope="session")
def tolerance() -> Callable[[str], float]:
    """Look a tolerance up by its name."""
    return lambda name: TOLERANCES[name].value
