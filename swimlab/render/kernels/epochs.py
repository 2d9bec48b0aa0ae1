"""Light kept from frame to frame: until when the light of a tile may be kept (see `swimlab.render.reuse`)."""

import warp as wp

from swimlab.render.kernels.placing import EPOCH, SHADE
from swimlab.render.kernels.shading import half_vector
from swimlab.render.kernels.texture_space import NEVER

wp.set_module_options({"enable_backward": False})


@wp.func
def half_at(place: wp.vec3d, eye: wp.vec3d, light: wp.vec3) -> wp.vec3:
    """The half vector at a place, seen from an eye."""
    return half_vector(light, wp.normalize(wp.vec3(eye - place)))


@wp.kernel
def follow(
    first_row: wp.int32,
    oldest: wp.int32,
    steepness: wp.float32,
    tolerance: wp.float32,
    eyes: wp.array(dtype=wp.vec3d),
    lights: wp.array(dtype=wp.vec3),
    whole: wp.array2d(dtype=wp.bool),
    width: wp.float64,
    rows: wp.array(dtype=wp.vec4i),
    places: wp.array(dtype=wp.vec2d),
    before: wp.array(dtype=wp.int32),
    now: wp.array2d(dtype=wp.int32),
    last: wp.array2d(dtype=wp.int32),
):
    """Fill EPOCH of the tiles that are shaded, one thread a row of tiles.

    Frames are counted from `oldest` on in eyes, lights (directions towards the sun) and whole, [frames, targets].
    width: m, of the road. rows: of each row its target, its first entry, how many tiles it has and which row it is.
    places: y and z (m) of its tiles' middles. before: its first entry in `last`, or -1.

    A tile's light is made anew in turn. Between, a frame renews it where it was not of a whole target, or has changed
    by more than the tolerance: steepness times the turn of the half vector, or the turn of the sun.
    """
    k = first_row + wp.tid()
    row = rows[k]
    frames = eyes.shape[0]
    for i in range(row[2]):
        if now[SHADE, row[1] + i] != NEVER:
            # Frames since the tile's turn: less than all, as remainders are where that is negative.
            turn = (oldest + frames - 1 - i - 3 * row[3]) % frames
            if turn < 0:
                turn += frames
            epoch = frames - 1 - turn
            asked = epoch + 1
            if before[k] >= 0:
                was_of = last[EPOCH, before[k] + i] - oldest
                if last[SHADE, before[k] + i] != NEVER and was_of >= epoch:
                    epoch = was_of
                    asked = frames - 1
            u = (wp.float64(i) + wp.float64(0.5)) / wp.float64(row[2])
            place = wp.vec3d((u - wp.float64(0.5)) * width, places[k][0], places[k][1])
            was = half_at(place, eyes[epoch], lights[epoch])
            for frame in range(asked, frames):
                now_half = half_at(place, eyes[frame], lights[frame])
                change = wp.max(steepness * wp.length(now_half - was), wp.length(lights[frame] - lights[epoch]))
                if not whole[epoch, row[0]] or change > tolerance:
                    epoch = wp.int32(frame)
                    was = now_half
            now[EPOCH, row[1] + i] = oldest + epoch
