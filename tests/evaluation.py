"""Radiance of reflectance models at given directions, for tests."""

import numpy as np
import warp as wp

from metrics.kernels.launch import Launcher
from metrics.kernels.making import made_once
from swimlab.render.catalogue import brdfs


@made_once
def kernel_of(evaluate):
    @wp.kernel(module="unique", enable_backward=False)
    def kernel(
        albedo: wp.float32,
        ks: wp.float32,
        diffuse: wp.float32,
        power: wp.array(dtype=wp.float32),
        light: wp.array(dtype=wp.vec3),
        view: wp.array(dtype=wp.vec3),
        out: wp.array(dtype=wp.float32),
    ):
        i = wp.tid()
        out[i] = evaluate(wp.vec3(albedo, albedo, albedo), ks, power[i], light[i], view[i], diffuse)[0]

    return kernel


def evaluated(launcher: Launcher, name, light, view, *, power, ks=1.0, albedo=0.0, diffuse=1.0, **parameters):
    """Radiance [N] of a grey surface, float32 as the kernel has it; light, view [N, 3] or [3]; power, [N] or one."""
    brdf = brdfs()[name]
    model = brdf.model(brdf.settings(**parameters))
    light, view = np.broadcast_arrays(np.atleast_2d(light), np.atleast_2d(view))
    powers = np.broadcast_to(np.float32(power), len(light))
    out = launcher.empty(len(light), wp.float32)
    arrays = [launcher.array(powers, wp.float32)]
    arrays += [launcher.array(np.ascontiguousarray(each, np.float32), wp.vec3) for each in (light, view)]
    launcher.launch(kernel_of(model.evaluate), len(light), [albedo, ks, diffuse, *arrays, out])
    return out.numpy()
