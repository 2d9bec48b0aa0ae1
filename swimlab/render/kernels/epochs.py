"""Light kept from frame to frame: until when the light of a tile may be kept (see `swimlab.render.reuse`)."""

import warp as wp

from swimlab.render.kernels.shading import half_vector

wp.set_module_options({"enable_backward": False})


@wp.func
def half_at(place: wp.vec3d, eye: wp.vec3d, light: wp.vec3) -> wp.vec3:
    """The half vector at a place, seen from an eye."""
    return half_vector(light, wp.normalize(wp.vec3(eye - place)))


@wp.kernel
def follow(
    first: wp.int32,
    steepness: wp.float32,
    tolerance: wp.float32,
    eyes: wp.array(dtype=wp.vec3d),
    lights: wp.array(dtype=wp.vec3),
    whole: wp.array2d(dtype=wp.int32),
    places: wp.array(dtype=wp.vec3d),
    targets: wp.array(dtype=wp.int32),
    asked: wp.array(dtype=wp.int32),
    epochs: wp.array(dtype=wp.int32),
):
    """From the frame whose light a tile has to the one whose light it has in the last frame, one thread a tile.

    Frames are counted in eyes, lights (directions towards the sun) and whole, [frames, targets]. asked: the first frame
    that may renew the light. It does where the light was not of a whole target, or has changed by more than the
    tolerance: steepness times the turn of the half vector, or the turn of the sun.
    """
    k = first + wp.tid()
    epoch = epochs[k]
    was = half_at(places[k], eyes[epoch], lights[epoch])
    for frame in range(asked[k], eyes.shape[0]):
        now = half_at(places[k], eyes[frame], lights[frame])
        change = wp.max(steepness * wp.length(now - was), wp.length(lights[frame] - lights[epoch]))
        if whole[epoch, targets[k]] == 0 or change > tolerance:
            epoch = wp.int32(frame)
            was = now
    epochs[k] = epoch
