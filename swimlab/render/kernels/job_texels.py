"""Where the texels of a job lie, and whose they are (see `swimlab.render.kernels.tiles`)."""

import warp as wp

from metrics.kernels.forms import Twins, form
from swimlab.render.kernels.raster import covers
from swimlab.render.kernels.structs import LANES, Edges, Pages, Planes

wp.set_module_options({"enable_backward": False})


@wp.func
def centre(tiles: wp.array(dtype=wp.int32), first: wp.int32, pages: Pages, level: wp.int32, s: wp.int32) -> wp.vec2d:
    """Centre in the target, 0..1, of texel `s` of the tiles of a job, counted tile by tile and row by row."""
    depth = pages.tile_level - level
    entry = tiles[first + (s >> (2 * depth))] - pages.first
    across = pages.width >> pages.tile_level
    mask = (1 << depth) - 1
    i = ((entry % across) << depth) + (s & mask)
    j = ((entry / across) << depth) + ((s >> depth) & mask)
    pitch = wp.float64(1.0) / wp.float64(pages.width >> level)
    return wp.vec2d((wp.float64(i) + wp.float64(0.5)) * pitch, (wp.float64(j) + wp.float64(0.5)) * pitch)


@wp.func
def owner_of(edges: wp.array(dtype=Edges), range: wp.vec2i, guess: wp.int32, p: wp.vec2d) -> wp.int32:
    """The triangle of a chart that owns p, sought outwards from `guess`; -1 for none."""
    for step in range(range[1] - range[0]):
        if guess + step < range[1] and covers(edges[guess + step], p):
            return guess + step
        if guess - step >= range[0] and covers(edges[guess - step], p):
            return guess - step
    return -1


LOCATE = """
    const double (*p)[3] = planes.data;
    double* __restrict q = places.data;
    float* __restrict a = lanes.data + WIDTH*LANES;
    const int depth = pages.tile_level - level, mask = (1 << depth) - 1;
    const int across = pages.levels - 1 - pages.tile_level, within = (1 << across) - 1;
    const double pitch = 1.0/(double)(pages.width >> level);
    const double ux = p[1][0]*pitch, vx = p[2][0]*pitch, uy = p[1][1]*pitch, vy = p[2][1]*pitch;
    int column[LANES], row[LANES];
    if (2*depth >= PACKET) {
        const int entry = tiles.data[first + (s >> 2*depth)] - pages.first;
        const int left = (entry & within) << depth, top = (entry >> across) << depth;
        for (int k = begin; k < end; ++k) {
            column[k] = left + ((s + k) & mask);
            row[k] = top + (((s + k) >> depth) & mask);
        }
    } else {
        for (int k = begin; k < end; ++k) {
            const int entry = tiles.data[first + ((s + k) >> 2*depth)] - pages.first;
            column[k] = ((entry & within) << depth) + ((s + k) & mask);
            row[k] = ((entry >> across) << depth) + (((s + k) >> depth) & mask);
        }
    }
    #pragma clang loop vectorize(assume_safety)
    for (int k = begin; k < end; ++k) {
        const double x = ((double)column[k] + 0.5)*pitch, y = ((double)row[k] + 0.5)*pitch;
        q[k] = p[1][0]*x + p[1][1]*y + p[1][2]; q[LANES + k] = p[2][0]*x + p[2][1]*y + p[2][2];
        q[2*LANES + k] = ux; q[3*LANES + k] = vx; q[4*LANES + k] = uy; q[5*LANES + k] = vy;
        a[k] = (float)(p[3][0]*x + p[3][1]*y + p[3][2]);
        a[LANES + k] = (float)(p[4][0]*x + p[4][1]*y + p[4][2]);
        a[2*LANES + k] = (float)(p[5][0]*x + p[5][1]*y + p[5][2]);
        a[3*LANES + k] = (float)(p[6][0]*x + p[6][1]*y + p[6][2]);
    }
""".replace("PACKET", str(LANES.bit_length() - 1))


@form(cases=[(8,), (9,)])
def locate_texels(width: int) -> Twins:
    """The function that locates texels s + begin ... s + end of a job on a triangle, in lanes begin ... end.

    In texture space planes are not seen in perspective: 1/w is 1, and derivatives are constant.
    """

    @wp.func(module="unique")
    def locate(
        planes: Planes,
        tiles: wp.array(dtype=wp.int32),
        first: wp.int32,
        pages: Pages,
        level: wp.int32,
        s: wp.int32,
        begin: wp.int32,
        end: wp.int32,
        places: wp.array(dtype=wp.float64),
        lanes: wp.array(dtype=wp.float32),
    ):
        pitch = wp.float64(1.0) / wp.float64(pages.width >> level)
        for k in range(begin, end):
            p = centre(tiles, first, pages, level, s + k)
            for axis in range(2):
                row = axis + 1
                places[axis * LANES + k] = planes[row, 0] * p[0] + planes[row, 1] * p[1] + planes[row, 2]
                places[(2 + axis) * LANES + k] = planes[row, 0] * pitch
                places[(4 + axis) * LANES + k] = planes[row, 1] * pitch
            for value in range(4):
                row = value + 3
                found = planes[row, 0] * p[0] + planes[row, 1] * p[1] + planes[row, 2]
                lanes[(width + value) * LANES + k] = wp.float32(found)

    return Twins(locate, LOCATE.replace("WIDTH", str(width)).replace("LANES", str(LANES)), width)
