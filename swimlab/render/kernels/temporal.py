"""Reuse of the previous frame: where a surface was, the history read there, and how much of it is believed."""

import functools

import warp as wp

from swimlab.render.kernels.footprint import surface_at
from swimlab.render.kernels.geometry import Previous, place_before
from swimlab.render.kernels.raster import inverse_depth, sample_position
from swimlab.render.kernels.structs import Grid, Planes

wp.set_module_options({"enable_backward": False})


@wp.kernel
def reproject(
    first_row: wp.int32,
    grid: Grid,
    planes: wp.array(dtype=Planes),
    visible: wp.array2d(dtype=wp.int32),
    previous: Previous,
    nearness: wp.array2d(dtype=wp.float32),
    places: wp.array2d(dtype=wp.vec4),
):
    """The surface at each pixel's centre: 1/w (1/m) now; its place x, y (px) and 1/w in the previous frame, and the
    slope of 1/w, |d/dx| + |d/dy| a pixel. 0 where there is none."""
    row, i = wp.tid()
    j = first_row + row
    nearness[j, i] = 0.0
    places[j, i] = wp.vec4(0.0, 0.0, 0.0, 0.0)
    triangle = visible[row, i]
    if triangle >= 0:
        plane = planes[triangle]
        p = sample_position(grid, i, j)
        nearness[j, i] = wp.float32(inverse_depth(plane, p))
        before = place_before(previous, surface_at(plane, grid, p).position)
        slope = wp.abs(plane[0, 0] * grid.pitch[0]) + wp.abs(plane[0, 1] * grid.pitch[1])
        places[j, i] = wp.vec4(
            wp.float32(before[0]),
            wp.float32(before[1]),
            wp.float32(wp.float64(1.0) / before[2]),
            wp.float32(slope),
        )


@wp.func
def inside(image: wp.array2d(dtype=wp.float32), i: wp.int32, j: wp.int32) -> wp.bool:
    """Whether a pixel lies in the picture."""
    return i >= 0 and j >= 0 and i < image.shape[1] and j < image.shape[0]


@wp.func
def surface_beside(nearness: wp.array2d(dtype=wp.float32), i: wp.int32, j: wp.int32) -> wp.vec2i:
    """The pixel that a pixel moves with: itself, or the neighbour nearest to the eye where its centre sees none.

    (-1, -1) where no neighbour sees one. So a pixel that the road's edge cuts moves with the road.
    """
    found = wp.vec2i(-1, -1)
    nearest = wp.float32(0.0)
    if nearness[j, i] > 0.0:
        return wp.vec2i(i, j)
    for y in range(j - 1, j + 2):
        for x in range(i - 1, i + 2):
            if inside(nearness, x, y):
                if nearness[y, x] > nearest:
                    nearest = nearness[y, x]
                    found = wp.vec2i(x, y)
    return found


@wp.func
def was_seen(nearness: wp.array2d(dtype=wp.float32), place: wp.vec4) -> wp.bool:
    """Whether the previous frame saw this surface: one of the 3 x 3 pixels about its place has its 1/w.

    The tolerance is a tenth, and the slope of 1/w (constant over a plane) times the distance to the pixel's centre.
    """
    i = wp.int32(wp.floor(place[0]))
    j = wp.int32(wp.floor(place[1]))
    if place[2] <= 0.0 or not inside(nearness, i, j):
        return False
    apart = 0.1 * place[2] + 1.5 * place[3]
    for y in range(j - 1, j + 2):
        for x in range(i - 1, i + 2):
            if inside(nearness, x, y):
                if nearness[y, x] > 0.0 and wp.abs(nearness[y, x] - place[2]) <= apart:
                    return True
    return False


@wp.func
def pixel(image: wp.array2d(dtype=wp.vec4), i: wp.int32, j: wp.int32) -> wp.vec4:
    """A pixel; beyond the border, the nearest on the border."""
    return image[wp.clamp(j, 0, image.shape[0] - 1), wp.clamp(i, 0, image.shape[1] - 1)]


@wp.func
def bilinear_read(image: wp.array2d(dtype=wp.vec4), x: wp.float32, y: wp.float32) -> wp.vec4:
    """The four pixels about a place, px, weighted by nearness."""
    i = wp.int32(wp.floor(x - 0.5))
    j = wp.int32(wp.floor(y - 0.5))
    a = x - 0.5 - wp.float32(i)
    b = y - 0.5 - wp.float32(j)
    upper = pixel(image, i, j) * (1.0 - a) + pixel(image, i + 1, j) * a
    lower = pixel(image, i, j + 1) * (1.0 - a) + pixel(image, i + 1, j + 1) * a
    return upper * (1.0 - b) + lower * b


@wp.func
def catmull_rom(a: wp.float32) -> wp.vec4:
    """Weights of four neighbours for a place `a` of the way from the second to the third (Catmull & Rom 1974)."""
    return wp.vec4(
        ((-0.5 * a + 1.0) * a - 0.5) * a,
        (1.5 * a - 2.5) * a * a + 1.0,
        ((-1.5 * a + 2.0) * a + 0.5) * a,
        (0.5 * a - 0.5) * a * a,
    )


@wp.func
def bicubic_read(image: wp.array2d(dtype=wp.vec4), x: wp.float32, y: wp.float32) -> wp.vec4:
    """The sixteen pixels about a place, px, by Catmull-Rom weights: repeated reading hardly blurs."""
    i = wp.int32(wp.floor(x - 0.5))
    j = wp.int32(wp.floor(y - 0.5))
    across = catmull_rom(x - 0.5 - wp.float32(i))
    down = catmull_rom(y - 0.5 - wp.float32(j))
    total = wp.vec4(0.0, 0.0, 0.0, 0.0)
    for n in range(4):
        line = wp.vec4(0.0, 0.0, 0.0, 0.0)
        for m in range(4):
            line += pixel(image, i - 1 + m, j - 1 + n) * across[m]
        total += line * down[n]
    return total


@wp.func
def to_ycocg(c: wp.vec4) -> wp.vec4:
    """RGBA as Y, Co, Cg, A: brightness varies most, and gets an axis of its own (Karis 2014)."""
    return wp.vec4(
        0.25 * c[0] + 0.5 * c[1] + 0.25 * c[2], 0.5 * c[0] - 0.5 * c[2], 0.5 * c[1] - 0.25 * c[0] - 0.25 * c[2], c[3]
    )


@wp.func
def from_ycocg(c: wp.vec4) -> wp.vec4:
    """The inverse of `to_ycocg`."""
    return wp.vec4(c[0] - c[2] + c[1], c[0] + c[2], c[0] - c[2] - c[1], c[3])


@wp.func
def box_clamp(fresh: wp.array2d(dtype=wp.vec4), i: wp.int32, j: wp.int32, history: wp.vec4) -> wp.vec4:
    """The history within the range of the new frame's 3 x 3 pixels about it, in YCoCg and alpha.

    Karis 2014, High Quality Temporal Supersampling.
    """
    least = to_ycocg(fresh[j, i])
    most = least
    for y in range(j - 1, j + 2):
        for x in range(i - 1, i + 2):
            value = to_ycocg(pixel(fresh, x, y))
            least = wp.min(least, value)
            most = wp.max(most, value)
    return from_ycocg(wp.max(least, wp.min(most, to_ycocg(history))))


@wp.func
def variance_clamp(fresh: wp.array2d(dtype=wp.vec4), i: wp.int32, j: wp.int32, history: wp.vec4) -> wp.vec4:
    """The history within one standard deviation of the mean of the new frame's 3 x 3 pixels, in YCoCg and alpha.

    Salvi 2016, An Excursion in Temporal Supersampling.
    """
    mean = wp.vec4(0.0, 0.0, 0.0, 0.0)
    for y in range(j - 1, j + 2):
        for x in range(i - 1, i + 2):
            mean += to_ycocg(pixel(fresh, x, y)) / 9.0
    variance = wp.vec4(0.0, 0.0, 0.0, 0.0)
    for y in range(j - 1, j + 2):
        for x in range(i - 1, i + 2):
            away = to_ycocg(pixel(fresh, x, y)) - mean
            variance += wp.cw_mul(away, away) / 9.0
    spread = wp.vec4(wp.sqrt(variance[0]), wp.sqrt(variance[1]), wp.sqrt(variance[2]), wp.sqrt(variance[3]))
    return from_ycocg(wp.max(mean - spread, wp.min(mean + spread, to_ycocg(history))))


@wp.func
def no_clamp(fresh: wp.array2d(dtype=wp.vec4), i: wp.int32, j: wp.int32, history: wp.vec4) -> wp.vec4:
    """The history unchanged."""
    return history


@wp.func
def premultiplied(c: wp.vec4) -> wp.vec4:
    """The colour without a cubic's overshoot: no negative light, and alpha within 0..1."""
    if c[3] <= 0.0:
        return wp.vec4(0.0, 0.0, 0.0, 0.0)
    return wp.max(c, wp.vec4(0.0, 0.0, 0.0, 0.0)) / wp.max(c[3], 1.0)


READS = {"bicubic": bicubic_read, "bilinear": bilinear_read}
CLAMPS = {"box": box_clamp, "variance": variance_clamp, "none": no_clamp}


@functools.cache
def resolve_with(read: wp.Function, clamp: wp.Function) -> wp.Kernel:
    """The kernel that blends a new frame into the history, or keeps it where the history saw another surface.

    `fresh` and `history` are premultiplied [H, W]; `nearness` and `places` are `reproject`'s of the new frame,
    `nearness_before` is the frame before's.
    """

    @wp.kernel(module="unique", enable_backward=False)
    def resolve(
        first_row: wp.int32,
        blend: wp.float32,
        fresh: wp.array2d(dtype=wp.vec4),
        nearness: wp.array2d(dtype=wp.float32),
        places: wp.array2d(dtype=wp.vec4),
        history: wp.array2d(dtype=wp.vec4),
        nearness_before: wp.array2d(dtype=wp.float32),
        picture: wp.array2d(dtype=wp.vec4),
    ):
        row, i = wp.tid()
        j = first_row + row
        picture[j, i] = fresh[j, i]
        owner = surface_beside(nearness, i, j)
        if owner[0] >= 0:
            place = places[owner[1], owner[0]]
            x = place[0] + wp.float32(i - owner[0])
            y = place[1] + wp.float32(j - owner[1])
            on_screen = x >= 0.0 and y >= 0.0 and x <= wp.float32(fresh.shape[1]) and y <= wp.float32(fresh.shape[0])
            if on_screen and was_seen(nearness_before, place):
                kept = premultiplied(clamp(fresh, i, j, read(history, x, y)))
                picture[j, i] = kept + (fresh[j, i] - kept) * blend

    return resolve
