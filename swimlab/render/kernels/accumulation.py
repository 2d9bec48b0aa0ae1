"""Temporal accumulation: a new sample of each pixel with its place in the frame before, and the blend with that."""

import warp as wp

from metrics.kernels.forms import Form, Twins, form
from metrics.kernels.making import made_once
from swimlab.render.kernels.clamp import Clamp
from swimlab.render.kernels.geometry import Previous
from swimlab.render.kernels.history import premultiplying
from swimlab.render.kernels.samples import draw_row
from swimlab.render.kernels.structs import TEXELS, Chain, Edges, Grid, Planes, Sun
from swimlab.render.kernels.temporal import placing, reprojecting

wp.set_module_options({"enable_backward": False})


@made_once
def sample_with(fill: wp.Function, shade_packet: wp.Function, width: int, device: str) -> wp.Kernel:
    """The kernel that draws rows of new samples, and finds where the previous frame saw what lies at pixels' centres.

    One thread a row. `origin` is that of the picture's grid (see `draw_row`), which is else `grid`, that of the
    centres, of which `nearness` and `places` are filled (see `reprojecting`). `visible` is scratch.
    """
    texel_type = TEXELS[width]
    draw, reproject = draw_row(fill, shade_packet, width), reprojecting(device)

    @wp.kernel(module="unique", enable_backward=False)
    def kernel(
        first_row: wp.int32,
        origin: wp.vec2d,
        grid: Grid,
        previous: Previous,
        edges: wp.array(dtype=Edges),
        planes: wp.array(dtype=Planes),
        bounds: wp.array(dtype=wp.vec2d),
        texels: wp.array(dtype=texel_type),
        chain: Chain,
        sun: Sun,
        picture: wp.array2d(dtype=wp.vec4),
        shaded: wp.array(dtype=wp.int32),
        nearness: wp.array2d(dtype=wp.float32),
        places: wp.array2d(dtype=wp.vec4),
        visible: wp.array2d(dtype=wp.int32),
    ):
        j = first_row + wp.tid()
        row = wp.tid() % visible.shape[0]
        samples = grid
        samples.origin = origin
        # One sample a pixel has no error, which nothing is written to.
        shaded[j] = draw(row, j, 1, samples, edges, planes, bounds, texels, chain, sun, picture, picture, visible)
        reproject(row, j, grid, edges, planes, bounds, previous, nearness, places, visible)

    return kernel


ANY_NEAR = """
    float most = 0.0f;
    for (int y = j > 0 ? j - 1 : 0; y <= j + 1 && y < nearness.shape[0]; ++y) {
        const float* __restrict line = (const float*)((const char*)nearness.data + (long)y*nearness.strides[0]);
        float found[16] = {};
        int i = 0;
        for (; i + 16 <= nearness.shape[1]; i += 16)
            for (int k = 0; k < 16; ++k) found[k] = line[i + k] > found[k] ? line[i + k] : found[k];
        for (; i < nearness.shape[1]; ++i) most = line[i] > most ? line[i] : most;
        for (int k = 0; k < 16; ++k) most = found[k] > most ? found[k] : most;
    }
    return most > 0.0f;
"""


@form()
def any_near() -> Twins:
    """The function that tells whether a pixel of row j, or of the rows above and below it, sees a surface."""

    @wp.func(module="unique")
    def near(nearness: wp.array2d(dtype=wp.float32), j: wp.int32) -> wp.bool:
        for y in range(wp.max(j - 1, 0), wp.min(j + 2, nearness.shape[0])):
            for i in range(nearness.shape[1]):
                if nearness[y, i] > 0.0:
                    return True
        return False

    return Twins(near, ANY_NEAR)


@form()
def copying() -> Twins:
    """The function that copies row j of a picture."""

    @wp.func(module="unique")
    def copy(image: wp.array2d(dtype=wp.vec4), j: wp.int32, out: wp.array2d(dtype=wp.vec4)):
        for i in range(image.shape[1]):
            out[j, i] = image[j, i]

    return Twins(
        copy,
        "__builtin_memcpy((char*)out.data + (long)j*out.strides[0], (char*)image.data + (long)j*image.strides[0],"
        " 16*image.shape[1]);",
    )


@made_once
def resolve_with(history_read: Form, history_clamp: Clamp, device: str) -> wp.Kernel:
    """The kernel that blends rows of a new frame into the history, or keeps them where that saw another surface.

    `fresh` and `history` are premultiplied [H, W]; `nearness` and `places` are those of the new frame,
    `nearness_before` is the frame before's. `ranges`, two rows for each row that is worked on at once, is scratch.
    """

    read, find, hold = (each.on(device) for each in (history_read, history_clamp.find, history_clamp.hold))
    place, near, copy, possible = (each().on(device) for each in (placing, any_near, copying, premultiplying))

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
        ranges: wp.array2d(dtype=wp.vec4),
    ):
        j = first_row + wp.tid()
        row = wp.tid() % (ranges.shape[0] / 2)
        if not near(nearness, j):
            copy(fresh, j, picture)
            return
        find(fresh, j, row, ranges)
        for i in range(fresh.shape[1]):
            colour = fresh[j, i]
            at = place(nearness, places, nearness_before, i, j)
            if at[2] > 0.0:
                kept = possible(hold(read(history, at[0], at[1]), ranges[2 * row, i], ranges[2 * row + 1, i]))
                colour = kept + (colour - kept) * blend
            picture[j, i] = colour

    return resolve
