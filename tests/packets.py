"""Samples of all that a packet can hold, and shading them."""

import numpy as np
import warp as wp
from oracle import unit

from metrics.kernels.making import made_once
from swimlab.render.kernels.structs import LANES, Sun

SUN = unit(np.array([0.1, 0.9, 0.4]))


def in_rows(samples):
    """Packets [N / LANES, rows * LANES] of samples [N, rows]."""
    rows = samples.shape[1]
    return np.ascontiguousarray(samples.reshape(-1, LANES, rows).transpose(0, 2, 1)).reshape(-1, rows * LANES)


def half_vectors_at(slope, sun, to_eye):
    """Unit half vectors in the frame of each slope."""
    half = unit(sun + to_eye)
    tilt = 1 / np.sqrt(1 + slope[:, 0] ** 2)
    x, y, z = half.T
    return np.stack([x, (y + slope[:, 0] * z) * tilt, (z - slope[:, 0] * y) * tilt], axis=1)


def materials(random):
    """Samples [N, 12] over all that can occur; the last ones at the ends of powers and angles."""
    count = 40 * LANES
    albedo = random.uniform(0, 1, (count, 3))
    slope = random.uniform(-2, 2, (count, 1))
    to_eye = unit(random.normal(size=(count, 3)) * [1, 1, 0.3] + [0, 0, 0.4])
    power = np.concatenate([[0.0, 0.5, 1.0], np.geomspace(2, 1e5, count - 3)])[:, None]
    # Near the peak of the highlight, where powers matter, in the frame of the slope.
    half = half_vectors_at(slope, SUN, to_eye)
    normal = unit(half + random.normal(size=(count, 3)) / np.sqrt(power + 1)) * random.uniform(0.2, 1, (count, 1))
    normal[-LANES:] = half[-LANES:]
    normal[-2 * LANES : -LANES] *= -1
    to_eye[-3 * LANES] = -SUN
    strength = 1 / np.maximum(power, 1)
    position = -to_eye * random.uniform(0.5, 300, (count, 1))
    return np.concatenate([albedo, normal, strength, power, position, slope], axis=1)


def slope_moments(random):
    """Samples [N, 13] over all covariances, from a sharp highlight's to a rough map's, and all directions."""
    count = 40 * LANES
    variance = 10.0 ** random.uniform(-5, 0, (count, 2))
    correlation = random.uniform(-1, 1, count) * np.sqrt(variance.prod(axis=1))
    correlation[-LANES:] = np.sqrt(variance[-LANES:].prod(axis=1))
    b = random.normal(size=(count, 2)) * 0.3
    columns = [random.uniform(0, 1, (count, 3)), b, variance[:, :1], np.full((count, 1), 0.05), variance[:, 1:]]
    position, slope = random.normal(size=(count, 3)) * 20, random.uniform(-1, 1, (count, 1))
    return np.concatenate([*columns, correlation[:, None], position, slope], axis=1)


def light(random):
    """Samples [N, 8] of premultiplied light, alpha from 0 to 1."""
    samples = random.uniform(0, 1, (4 * LANES, 8))
    samples[:LANES, 3] = random.choice([0.0, 1e-6, 1e-5, 1.0], LANES)
    return samples


SAMPLES = {4: light, 8: materials, 9: slope_moments}
"""Width of a texel -> samples that a packet of such texels is shaded from."""


def shade(launcher, shade_packet, samples):
    """Radiance [N, 3] of samples [N, rows] under SUN, N a multiple of LANES."""
    packets = launcher.array(in_rows(samples.astype(np.float32)), wp.float32)
    sun = Sun()
    sun.direction, sun.diffuse = wp.vec3(*SUN.tolist()), 0.6
    launcher.launch(shading_of(shade_packet, packets.shape[1]), packets.shape[0], [packets, sun])
    rows = packets.numpy().reshape(-1, samples.shape[1], LANES)
    return rows[:, :3].transpose(0, 2, 1).reshape(-1, 3)


@made_once
def shading_of(shade_packet, floats):
    @wp.kernel(module="unique", enable_backward=False)
    def kernel(samples: wp.array2d(dtype=wp.float32), sun: Sun):
        packet = wp.tid()
        lanes = wp.zeros(shape=(floats,), dtype=wp.float32)
        for k in range(floats):
            lanes[k] = samples[packet, k]
        shade_packet(lanes, sun)
        for k in range(floats):
            samples[packet, k] = lanes[k]

    return kernel
