"""Asphalt: maps of a worn road, made from a seed.

Stones of many sizes stand in bitumen; grain roughens them; water fills the hollows of wet patches; tar seams
and worn paint lie on top. The relief is finer than a distant pixel and its normals tilt further than a
highlight is wide, so the order of filtering and shading decides what is seen.
"""

from typing import NamedTuple

import numpy as np
from numpy.random import Generator
from numpy.typing import NDArray

Plane = NDArray[np.float32]

RADII = np.array((1.5, 2.5, 4.0, 6.0, 10.0))
"""Radii of the stones in texels."""
COVER = np.array((0.10, 0.36, 0.42, 0.33, 0.20))
"""Summed area of the stones of each radius, as a fraction of the map."""


class Maps(NamedTuple):
    """Maps of a surface, float32, tileable in u and v; row 0 is v = 0, v grows forward and u to the right."""

    albedo: Plane
    """[n, n, 3], linear, 0..1."""
    normal: Plane
    """[n, n, 3], unit, tangent space x right, y forward, z up."""
    gloss: Plane
    """[n, n, 2]: Ks, and the power of the highlight, 20..200."""


def make(seed: int, size: int = 1024) -> Maps:
    """Maps of `size` by `size` texels, the same for the same seed. Stones keep their size in texels.

    Raises ValueError if `size` is under 64, which holds no road.
    """
    if size < 64:
        raise ValueError(f"asphalt needs at least 64 texels a side, not {size}")
    rng = np.random.default_rng(seed)
    stones, owner = _stones(rng, size)
    relief = _worn(stones + 0.33 * _noise(rng, size, 4.0, 8.0))
    wet = _smoothstep(0.7, 1.3, _noise(rng, size, 90.0, 400.0))
    seam = np.maximum(_seam(rng, size, 0.31), _seam(rng, size, 0.72).T)
    paint = _lines(size) * _smoothstep(-0.9, -0.5, _noise(rng, size, 6.0, 120.0) + 0.2 * relief)

    filled = wet * 0.75 * _smoothstep(2.1, 0.8, relief)
    smooth = np.maximum.reduce((filled, 0.85 * seam, 0.55 * paint))
    slope_u, slope_v = (_slope(relief, axis) * (1 - smooth) for axis in (1, 0))
    normal = np.stack((-slope_u, -slope_v, np.ones_like(slope_u)), axis=-1)
    normal /= np.linalg.norm(normal, axis=-1, keepdims=True)

    shade = rng.uniform(0.05, 0.13, owner.max() + 1)
    shade[0] = 0.045
    warmth = rng.normal(0.0, 0.06, shade.size)
    tint = np.stack((1 + warmth, np.ones_like(warmth), 1 - warmth), axis=-1)
    albedo = (shade[:, None] * tint)[owner] * (1 + 0.1 * _noise(rng, size, 2.0, 6.0))[..., None]
    albedo = _over(albedo * (1 - 0.45 * wet)[..., None], 0.02, seam)
    albedo = _over(albedo, 0.55 + 0.02 * _noise(rng, size, 3.0, 40.0), paint)

    mottle = _noise(rng, size, 12.0, 200.0)
    strength = _over(0.05 + 0.01 * mottle, 0.07, np.maximum(filled, 0.5 * seam))
    power = np.exp(_over(np.log(40.0) + 0.2 * mottle, np.log(180.0), np.maximum(filled, 0.6 * seam)))
    gloss = np.stack((strength.clip(0.02, 0.2), power.clip(20.0, 200.0)), axis=-1)
    return Maps(*(each.astype(np.float32) for each in (albedo.clip(0.0, 1.0), normal, gloss)))


def _stones(rng: Generator, size: int) -> tuple[NDArray[np.float64], NDArray[np.int64]]:
    """Height in texels [n, n] of the upper envelope of tilted caps, and whose cap it is (0: bitumen)."""
    height = np.zeros(size * size)
    owner = np.zeros(size * size, dtype=np.int64)
    count = np.maximum(1, np.round(COVER * size * size / (np.pi * RADII**2)).astype(int))
    first = 1
    for radius, stones in zip(RADII, count, strict=True):
        place = rng.uniform(0, size, (stones, 2))
        tilt = rng.normal(0.0, 0.16, (stones, 2))
        reach = np.arange(-int(radius) - 1, int(radius) + 2)
        window = np.stack(np.meshgrid(reach, reach, indexing="ij"), axis=-1).reshape(-1, 2)
        texel = np.floor(place).astype(int)[:, None] + window
        offset = texel + 0.5 - place[:, None]
        rise = 0.36 * radius * (1 - (offset**2).sum(-1) / radius**2)
        cap = np.where(rise > 0, rise + (offset * tilt[:, None]).sum(-1) + 0.5, 0.0).ravel()
        where = (texel[..., 0] % size * size + texel[..., 1] % size).ravel()
        np.maximum.at(height, where, cap)
        top = (cap > 0) & (cap == height[where])
        owner[where[top]] = np.repeat(np.arange(first, first + stones), len(window))[top]
        first += stones
    return height.reshape(size, size), owner.reshape(size, size)


def _worn(height: NDArray[np.float64]) -> NDArray[np.float64]:
    """`height` without the edges that no texel can hold: a periodic binomial filter over five texels."""
    for axis in (0, 1, 0, 1):
        height = np.asarray((np.roll(height, 1, axis) + 2 * height + np.roll(height, -1, axis)) / 4)
    return height


def _noise(rng: Generator, size: int, shortest: float, longest: float) -> NDArray[np.float64]:
    """Periodic noise [n, n] of mean 0 and variance 1 with wavelengths between two lengths in texels.

    Amplitudes fall with frequency, as in pink noise. The longest wave that a map can hold is its side.
    """
    frequency = np.hypot(np.fft.fftfreq(size)[:, None], np.fft.rfftfreq(size))
    frequency[0, 0] = np.inf
    band = (frequency <= max(1 / shortest, 2 / size)) & (frequency >= 1 / longest)
    spectrum = np.fft.rfft2(rng.standard_normal((size, size))) * np.where(band, 1 / frequency, 0.0)
    noise = np.fft.irfft2(spectrum, s=(size, size))
    return np.asarray(noise / noise.std())


def _seam(rng: Generator, size: int, place: float) -> NDArray[np.float64]:
    """Coverage [n, n] by a wiggly line of tar across the road, at v = `place`."""
    wave = np.fft.rfftfreq(size, 1 / size)
    phase = np.exp(2j * np.pi * rng.uniform(size=wave.size))
    wiggle = np.fft.irfft(phase * ((wave > 0) & (wave <= 24)) / (1 + wave), n=size)
    centre = size * place + 10.0 * wiggle / wiggle.std()
    texel = np.arange(size)[:, None] + 0.5
    away = np.abs((texel - centre + size / 2) % size - size / 2)
    return _smoothstep(4.0, 2.0, away)


def _lines(size: int) -> NDArray[np.float64]:
    """Coverage [n, n] by fresh paint: two edge lines and a dashed centre line."""
    place = (np.arange(size) + 0.5) / size
    edges = np.abs(np.abs(place - 0.5) - 0.44) < 0.0075
    centre = np.abs(place - 0.5) < 0.0075
    dash = (place > 0.15) & (place < 0.6)
    return (edges[None, :] | (dash[:, None] & centre[None, :])).astype(np.float64)


def _slope(height: NDArray[np.float64], axis: int) -> NDArray[np.float64]:
    """Periodic central difference of `height` along an axis, a texel."""
    return np.asarray((np.roll(height, -1, axis) - np.roll(height, 1, axis)) / 2)


def _smoothstep(low: float, high: float, value: NDArray[np.float64]) -> NDArray[np.float64]:
    """0 at `low`, 1 at `high`, smooth between; falls if `high` is below `low`."""
    t = ((value - low) / (high - low)).clip(0.0, 1.0)
    return np.asarray(t * t * (3 - 2 * t))


def _over(
    below: NDArray[np.float64], above: NDArray[np.float64] | float, cover: NDArray[np.float64]
) -> NDArray[np.float64]:
    """Blend `above` over `below` by `cover` [n, n]; channels of `below` get the same."""
    shape = cover.shape + (1,) * (below.ndim - 2)
    top = np.broadcast_to(above, cover.shape).reshape(shape)
    return below + (top - below) * cover.reshape(shape)
