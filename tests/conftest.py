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
    "surface in double": Tolerance(1e-9, "double precision, planes of metres over a road of 240 m, once inverted"),
    "mean of uniform numbers": Tolerance(0.03, "5 standard errors over 2304 draws"),
    "correlation of random numbers": Tolerance(0.1, "5 standard errors over 2304 draws"),
    "ellipse": Tolerance(1e-10, "double precision, |det J| of an aspect of 1e4 loses four digits and s2 another two"),
    "derivative by differences": Tolerance(1e-6, "central differences over 1e-4 px where a pixel is 1 m and less"),
    "filter in float32": Tolerance(4e-5, "values of 0..1: uv of up to 3 in float32 are off by 2e-5 of a texel of 64"),
    "weights in float32": Tolerance(1e-6, "weights that sum to 1, up to 16 probes"),
    "kelly": Tolerance(1e-5, "published check values have six digits"),
    "visible grating": Tolerance(0.02, "the tile's window smears the grating over a bin of 1/64 cycles/px"),
    "cubic in float32": Tolerance(3e-6, "terms of up to 10 that cancel: 1.1e-6 measured"),
    "mip in float32": Tolerance(1e-6, "six or seven means of four, values of 0..1"),
    "power of a cosine": Tolerance(2e-7, "of 1; h.x^2 + h.y^2 does not cancel: 7e-8 measured, p up to 1e5"),
    "root of a grazing cosine": Tolerance(
        2e-4, "1 - sin^2 loses a cosine of 1e-3; powers under 2 raise that to 1.1e-4"
    ),
    "agreement with the oracle": Tolerance(1e-5, "relative rms; float32 shading of doubles: 5e-6 measured at most"),
    "equal pixels": Tolerance(0.995, "fraction; a sample may lie on the border of two texels to within rounding"),
    "equal to a pixel": Tolerance(1e-3, "relative; one pixel at a texel's border has a wholly other colour"),
    "slope variance": Tolerance(0.03, "relative; 65536 slopes have a standard error of .55%"),
    "closed form of a widened lobe": Tolerance(0.01, "relative; 65536 normals, chains in float32"),
    "light on a coarse target of hills": Tolerance(3e-3, "of 1; slopes are linear over a texel: 1.5e-3 measured"),
    "error of needed texels": Tolerance(1.25, "times the error of all texels; 1.11 to 1.14 measured"),
    "technique that acts": Tolerance(0.9, "times pixel-aniso's error; .61 to .69 measured, .852 for specular-aa"),
    "native lean, relative": Tolerance(2e-5, "polynomial exp2 against exp; 5e-6 measured"),
    "native filter against plain": Tolerance(2e-5, "of 1; float logarithm: lod to 1e-6; float uv of 3: 1e-5 of a texel"),
    "half a code": Tolerance(0.5 / 255 + 1e-6, "8 bit"),
    "half float": Tolerance(1e-3, "relative; a half has 11 bits: 4.9e-4 at worst"),
    "smallest half": Tolerance(6e-8, "halves under 6e-5 are multiples of 2^-24"),
    "reference against its stated error": Tolerance(1.5, "times the stated error; .94 to 1.04 measured in four views"),
    "mean of a picture": Tolerance(4.0, "standard errors; about one seed in 16000 goes beyond"),
    "running mean": Tolerance(2e-6, "relative to the brightest; a dozen blends in float32"),
    "constant light": Tolerance(2e-6, "sums of up to 16 probes and 10 levels of one float32 value, divided by alpha"),
    "linear light": Tolerance(2e-5, "as agreement with the oracle, where two float32 orders of the same sums differ"),
    "road in double": Tolerance(1e-8, "m; origins of 1e7 m are rounded to 2e-9"),
    "picture far from the origin": Tolerance(1e-6, "1e7 m are rounded to 2e-9, a millionth of a texel"),
    "depth": Tolerance(1e-6, "relative; rounded to float32"),
    "motion": Tolerance(1e-5, "px; rounded to float32 at a few px, once more at hundreds"),
    "place under motion": Tolerance(1e-5, "m; motion in float32 to 4e-6 px, pixels of up to a metre"),
    "cubic interpolation": Tolerance(
        1e-3, "of an amplitude of 1 over 11 rows a wave: 5e-4; motion off by .01 px: 6e-3"
    ),
    "light within a pixel": Tolerance(0.05, "relative rms; a segment that is missing makes .1 and more"),
    "motion from float32 depth": Tolerance(2e-3, "px; depth in float32 at 1 m from the eye, moved by a metre"),
    "debug against release": Tolerance(1e-5, "relative to the brightest; other optimisation, other rounding"),
    "decoded 8 bit": Tolerance(1e-6, "the formula in float32"),
    "native against plain": Tolerance(3e-5, "peak of 1: sqrt(p) 1e-7 each, p up to 1e5; 1.3e-5 measured"),
    "power of two in float32": Tolerance(2e-6, "relative; an exponent of 13 rounded to float32"),
    "coverage": Tolerance(0.125, "8 x 8 cells: a straight edge strays by 1/16, a corner has two"),
    "coverage on the whole": Tolerance(1 / 64, "rms over the pixels of edges: one cell"),
    "depth of chords": Tolerance(1e-3, "relative; chords 2e-5 m off the sine, seen at angles down to a fiftieth"),
    "interpolated light": Tolerance(2e-3, "relative rms of a power of 12 between vertices 1/64 of a segment apart"),
    "second order": Tolerance(0.15, "relative; orders above the second still show on the coarser of the meshes"),
    "radiance in float32": Tolerance(2e-5, "powers of 200 amplify the rounding of a half vector a hundred times"),
    "rounding": Tolerance(1e-9, "sums of some thousand doubles"),
    "parseval": Tolerance(1e-6, "relative; one transform of a tile in single precision, 1e-7 measured"),
    "budget": Tolerance(1e-12, "relative; the parts add up to rounding in double precision"),
    "glued": Tolerance(1e-6, "share of the energy; float32 frames, windows leak 4e-7 at .3 cycles/px at most"),
    "moving": Tolerance(0.9, "share that must be flicker where an error travels 25 px against the surface"),
    "residual is flicker": Tolerance(1e-3, "relative; the reference's own leak is of one in a million, times 100"),
    "part of a picture": Tolerance(0.5, "relative; 16 sinusoids over the few tiles that an occluder leaves"),
    "chance of static noise": Tolerance(0.02, "share; chance over some 1000 coefficients of the lowest octave"),
    "equal rms": Tolerance(0.1, "relative; 24 sinusoids over a few tiles interfere"),
    "window leak": Tolerance(1e-3, "relative; a tile's window spreads a line over a few bins"),
    "float32": Tolerance(1e-6, "relative; values rounded to float32"),
    "plane": Tolerance(1e-4, "fractions of energy; 2e-5 measured: the lowest wave leaks into the mean level"),
    "beating orders": Tolerance(0.01, "fractions of energy; 3e-3 measured where two orders are not told apart"),
    "single precision": Tolerance(1e-5, "projections are held in float32"),
    "noise": Tolerance(0.1, "relative; 1/32 of the energy of 25000 independent values"),
    "peak": Tolerance(0.02, "relative; .1% measured"),
    "srgb": Tolerance(1e-5, "the given codes have so many digits"),
    "percent rounding": Tolerance(1e-9, "percent; means of doubles"),
    "rounding of means": Tolerance(1e-6, "relative"),
    "spread of 60": Tolerance(0.45, "relative; 9% for 60 clips, and the overlap of few tiles is overrated by 25%"),
    "octave of a standard error": Tolerance(1.0, "log2 of a ratio: a factor of 2; 16% for 20 clips"),
    "wave in its octave": Tolerance(0.75, "share; the window spreads a wave of 1.4 bins over three"),
    "error of an error": Tolerance(1e-6, "relative; the spread about a mean, of sums in another order"),
    "unwarped glued": Tolerance(1e-4, "share of the energy; a quintic spline at .3 cycles/px, 2e-6 measured"),
    "alignment floor": Tolerance(0.03, "share of the energy; 1e-11 measured below a quarter of the pixel Nyquist"),
    "occluded": Tolerance(0.01, "share of the energy; 2e-4 measured where an edge of slow surfaces is crossed"),
    "correspondence": Tolerance(1e-3, "px; four fields in float32, inverted to 1e-4 px each"),
    "published FLIP": Tolerance(5e-5, "float32 transforms: OpenImageIO is off by 4.3e-5"),
    "two FLIPs": Tolerance(1e-3, "two implementations in float32"),
    "8 bit code": Tolerance(0.006, "linear; half an sRGB step is .0045 near white"),
    "warped picture": Tolerance(0.03, "of the deviation; cubic spline at .1 cycles/px, vectors linear between pixels"),
    "estimated motion": Tolerance(0.15, "px; DIS flow on 8-bit codes of a road at 160x90: .05 measured"),
    "video code": Tolerance(0.03, "linear; 8-bit codes of limited range and lossy chroma: .021 measured at .5"),
    "bloom at an octave": Tolerance(1e-7, "the radius differs by 2e-9; radiance up to 8"),
    "bloom at another size": Tolerance(0.01, "of the peak; .007 measured: small pixels are means, cut later"),
    "power of a filtered lobe": Tolerance(1e-4, "relative; float32 normals: p 1e-7 for p up to 1024"),
    "lobe over Gaussian slopes": Tolerance(0.02, "relative; of 2 sigma^2, and 64 quantiles: .010 measured"),
    "reflectance in float32": Tolerance(
        5e-4, "times the lobe's median; p up to 1e5, half vectors of nearly opposite directions: 4e-4 measured"
    ),
    "reciprocity": Tolerance(1e-4, "as above, both ways"),
    "peak of a lobe": Tolerance(1e-4, "relative; the half vector is rounded"),
    "table, rms": Tolerance(2e-3, "of the lobe's rms"),
    "table of a root": Tolerance(0.03, "of the lobe's rms; exponents under 1 end at the horizon in a vertical"),
    "table, largest": Tolerance(2e-2, "of the lobe's value"),
    "turned tangent": Tolerance(1e-4, "of the brightest; another frame, other roundings"),
    "mean spread": Tolerance(0.1, "relative; 2000 draws have 1.2%, and lobes of 1e5 lose some near the horizon"),
    "equal highlights": Tolerance(0.1, "relative; means of two frames of 16 samples a pixel"),
    "normalised strands": Tolerance(0.01, "of 1; the factor is the first term of a series: .9% at p = 0"),
    "energy by quadrature": Tolerance(1e-3, "relative"),
    "three decimals": Tolerance(1e-3, "the given values have so many digits"),
    "mean over strata": Tolerance(1e-5, "relative; a million strata, the last of an endless tail"),
    "Gaussian highlight": Tolerance(2e-3, "relative; 1/power is off by 2/power^2, power 1000 and slopes of .3"),
    "mean of dither": Tolerance(5.0, "standard errors, the largest of 64"),
}


@pytest.fixture(scope="session")
def tolerance() -> Callable[[str], float]:
    """Look a tolerance up by its name."""
    return lambda name: TOLERANCES[name].value
