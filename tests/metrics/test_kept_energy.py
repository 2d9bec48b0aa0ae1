"""Noise reads its own energy under any motion: what interpolation takes of it is given back."""

import numpy as np
import pytest
from scipy import ndimage

from metrics import Clip, measure
from metrics.kernels.gains import table
from metrics.octaves import OCTAVES, WHITE
from metrics.synthetic import Rotation, centres

WIDTH, HEIGHT, COUNT, RMS = 320, 192, 10, 0.02
X, Y = np.broadcast_arrays(*centres(HEIGHT, WIDTH))


def zoom(rate):
    field = np.stack([rate * (X - WIDTH / 2) + 1, rate * (Y - HEIGHT / 2)], axis=2)
    return lambda _: field


def receding(_):
    """A ground plane that is left behind: its rows come together towards the horizon above the picture."""
    near = Y / HEIGHT * 30 + 10
    return np.stack([(X - WIDTH / 2) * near / 2000, near * 0.03], axis=2)


MOTIONS = {
    "still but for one pixel": zoom(1e-5),
    "zoom": zoom(0.01),
    "zoom out": zoom(-0.015),
    "rotation": Rotation(2.0, (WIDTH, HEIGHT)).motion,
    "perspective": receding,
}


def white(t):
    return RMS * np.random.default_rng(t).standard_normal((HEIGHT, WIDTH, 3))


def top_octave(t):
    """Between 1/4 and 1/2 cycles/px."""
    radius = np.hypot(np.fft.fftfreq(HEIGHT)[:, None], np.fft.fftfreq(WIDTH)[None, :])
    inside = (radius >= OCTAVES[-2]) & (radius < OCTAVES[-1])
    return np.fft.ifft2(np.fft.fft2(white(t), axes=(0, 1)) * inside[..., None], axes=(0, 1)).real


@pytest.mark.parametrize("motion", MOTIONS)
@pytest.mark.parametrize("noise", [white, top_octave], ids=["white", "top octave"])
@pytest.mark.checks("budget.mse", "budget.flicker", "residual.flicker")
def test_noise_reads_its_own_energy(motion, noise, tolerance):
    flat = np.full((HEIGHT, WIDTH, 3), 0.5)
    test = Clip(lambda t: flat + noise(t), COUNT, motion=MOTIONS[motion])
    found = measure(test, Clip(lambda _: flat, COUNT), names=["budget", "residual"], reference_error=noise)
    energy = np.mean([np.mean(noise(t) ** 2) for t in range(COUNT)])
    for name in ("budget.mse", "budget.flicker", "residual.flicker"):
        assert found.scores[name] == pytest.approx(energy, rel=tolerance("kept energy")), name
    frames = [row[key] for row in found.frames for key in ("mse", "change") if key in row]
    assert np.mean(frames) == pytest.approx(energy, rel=tolerance("kept energy"))
    strip = np.square(np.array(found.curves["budget.strip"]["error"], float)).sum(axis=0)
    assert strip.mean() == pytest.approx(energy, rel=tolerance("kept energy"))
    if noise is white:
        assert found.scores["budget.floor"] == pytest.approx(energy, rel=tolerance("kept energy"))


def test_white_noise_keeps_what_the_spline_keeps_of_it(tolerance):
    """On average over all places, by the sums of the squared cardinal spline (Unser 1999, eq. 12)."""
    steps = np.arange(32)
    left = table()[np.minimum(steps, 32 - steps)][:, np.minimum(steps, 32 - steps)].mean(axis=(0, 1))
    assert table()[0, 0] == pytest.approx(np.ones(len(left)), abs=tolerance("a table of a spline"))
    kept = WHITE[: -len(left)].sum() + WHITE[-len(left) :] @ left
    assert kept == pytest.approx(spline_energy(), abs=tolerance("a table of a spline"))


def spline_energy():
    """The same from an impulse that is taken between pixels."""
    impulse = np.zeros(65)
    impulse[32] = 1.0
    places = np.arange(0, 64, 1 / 64)
    taken = ndimage.map_coordinates(impulse, [places], order=5, mode="mirror")
    return (np.square(taken).sum() / 64) ** 2
