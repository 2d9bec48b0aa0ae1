"""Light kept from frame to frame: until when the light of a tile may be kept (see `swimlab.render.reuse`)."""

import warp as wp

from swimlab.render.kernels.shading import half_vector
from swimlab.render.kernels.texture_space import NEVER
from swimlab.render.kernels.tile_table import EPOCH, KEEP, SHADE

OTHER, CUT, WHOLE = range(3)
"""What a target is of: no segment of the road, or one that was cut or turned away in part one frame ago, or was
whole."""

wp.set_module_options({"enable_backward": False})


@wp.func
def half_at(place: wp.vec3d, eye: wp.vec3d, light: wp.vec4) -> wp.vec3:
    """The half vector at a place, seen from an eye."""
    return half_vector(wp.vec3(light[0], light[1], light[2]), wp.normalize(wp.vec3(eye - place)))


@wp.kernel
def follow(
    first_row: wp.int32,
    frame: wp.int32,
    steepness: wp.float32,
    tolerance: wp.float32,
    eyes: wp.array(dtype=wp.vec3d),
    lights: wp.array(dtype=wp.vec4),
    states: wp.array(dtype=wp.int32),
    width: wp.float64,
    rows: wp.array(dtype=wp.vec4i),
    places: wp.array(dtype=wp.vec2d),
    before: wp.array(dtype=wp.int32),
    now: wp.array2d(dtype=wp.int32),
    last: wp.array2d(dtype=wp.int32),
):
    """Set EPOCH and KEEP of the tiles whose light is kept, one thread a row of tiles.

    eyes, lights: where the eye was, and the direction towards the sun with its diffuse part, of all frames whose light
    may be kept, up to `frame`. states: of each target. width: m, of the road. rows: of each row its target, its first
    entry, how many tiles it has and which row it is. places: y and z (m) of its tiles' middles. before: its first entry
    in `last`, or -1.

    A tile's light is kept while the tile is shaded at the same level and no finer one is wanted, until its turn, or
    until it has changed by more than the tolerance: steepness times the turn of the half vector, or the change of the
    sun.
    """
    k = first_row + wp.tid()
    row = rows[k]
    state = states[row[0]]
    frames = eyes.shape[0]
    if before[k] < 0 or state == OTHER:
        return
    for i in range(row[2]):
        entry = row[1] + i
        was = before[k] + i
        epoch = last[EPOCH, was]
        keeps = (
            now[SHADE, entry] != NEVER and last[SHADE, was] == now[SHADE, entry] and last[KEEP, was] <= now[KEEP, entry]
        )
        keeps = keeps and (frame - i - 3 * row[3]) % frames != 0 and (state == WHOLE or epoch < frame - 1)
        if keeps:
            age = frame - epoch
            u = (wp.float64(i) + wp.float64(0.5)) / wp.float64(row[2])
            place = wp.vec3d((u - wp.float64(0.5)) * width, places[k][0], places[k][1])
            then, present = lights[frames - 1 - age], lights[frames - 1]
            turn = half_at(place, eyes[frames - 1], present) - half_at(place, eyes[frames - 1 - age], then)
            if wp.max(steepness * wp.length(turn), wp.length(present - then)) <= tolerance:
                now[EPOCH, entry] = epoch
                now[KEEP, entry] = last[KEEP, was]
