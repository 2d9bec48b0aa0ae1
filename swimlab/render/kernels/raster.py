"""The rasteriser: which triangle each sample of a grid sees.

Homogeneous rasterisation (Olano & Greer 1997, Triangle Scan Conversion using 2D Homogeneous Coordinates): edge
functions come from clip-space positions, so a triangle that crosses the eye plane needs no clipping polygon and its
near part is cut off sample by sample. Two triangles that share an edge hold bitwise opposite edge functions, so that
with the top-left rule exactly one of them owns a sample on it.
"""

import warp as wp

from metrics.kernels.forms import Twins, form
from swimlab.render.kernels.structs import Edges, Grid, Planes

NEAR = 0.01
"""Distance of the near plane along the camera axis, m."""

wp.set_module_options({"enable_backward": False})


@wp.func
def sample_position(grid: Grid, i: wp.int32, j: wp.int32) -> wp.vec2d:
    """Place of the sample of cell (i, j) in the image plane, px. A jittered place depends on (seed, i, j) alone."""
    x = wp.float64(0.5)
    y = wp.float64(0.5)
    if grid.jittered == 1:
        bits = wp.randu(wp.rand_init(grid.seed, j * grid.width + i))
        x = (wp.float64(bits & wp.uint32(65535)) + x) / wp.float64(65536.0)
        y = (wp.float64(bits >> wp.uint32(16)) + y) / wp.float64(65536.0)
    return wp.vec2d(
        grid.origin[0] + (wp.float64(i) + x) * grid.pitch[0],
        grid.origin[1] + (wp.float64(j) + y) * grid.pitch[1],
    )


@wp.func
def owns(value: wp.float64, a: wp.float64, b: wp.float64) -> wp.bool:
    """Whether a sample with this edge value is the triangle's: inside, or on a top or left edge (a x + b y + c = 0)."""
    if value != wp.float64(0.0):
        return value > wp.float64(0.0)
    return a > wp.float64(0.0) or (a == wp.float64(0.0) and b > wp.float64(0.0))


@wp.func
def covers(edges: Edges, p: wp.vec2d) -> wp.bool:
    """Whether a triangle owns the sample at p."""
    for k in range(3):
        value = edges[k, 0] * p[0] + edges[k, 1] * p[1] + edges[k, 2]
        if not owns(value, edges[k, 0], edges[k, 1]):
            return False
    return True


@wp.func
def inverse_depth(planes: Planes, p: wp.vec2d) -> wp.float64:
    """1/w of the triangle's plane at p."""
    return planes[0, 0] * p[0] + planes[0, 1] * p[1] + planes[0, 2]


@wp.func
def row_span(edges: Edges, grid: Grid, j: wp.int32) -> wp.vec2i:
    """First and one past the last cell of row j that a triangle may own samples in (a superset by a cell or two)."""
    top = grid.origin[1] + wp.float64(j) * grid.pitch[1]
    first = wp.float64(0.0)
    last = wp.float64(grid.width)
    for k in range(3):
        a = edges[k, 0] * grid.pitch[0]
        # The edge's value over the row, at its largest for any y of the row.
        c = edges[k, 2] + edges[k, 0] * grid.origin[0]
        c += wp.max(edges[k, 1] * top, edges[k, 1] * (top + grid.pitch[1]))
        if a > wp.float64(0.0):
            first = wp.max(first, wp.min(-c / a, last) - wp.float64(2.0))
        elif a < wp.float64(0.0):
            last = wp.min(last, wp.max(-c / a, wp.float64(0.0)) + wp.float64(2.0))
        elif c < wp.float64(0.0):
            last = wp.float64(0.0)
    return wp.vec2i(wp.int32(first), wp.int32(wp.ceil(last)))


@wp.func
def inner_span(edges: Edges, planes: Planes, grid: Grid, j: wp.int32) -> wp.vec2i:
    """First and one past the last cell of row j that a triangle owns wholly, whose samples need no test (a subset)."""
    top = grid.origin[1] + wp.float64(j) * grid.pitch[1]
    bottom = top + grid.pitch[1]
    first = wp.float64(0.0)
    last = wp.float64(grid.width)
    for k in range(3):
        a = edges[k, 0] * grid.pitch[0]
        # The edge's value over the row, at its smallest for any y of the row.
        c = edges[k, 2] + edges[k, 0] * grid.origin[0] + wp.min(edges[k, 1] * top, edges[k, 1] * bottom)
        if a > wp.float64(0.0):
            first = wp.max(first, wp.min(-c / a, last) + wp.float64(2.0))
        elif a < wp.float64(0.0):
            last = wp.min(last, wp.max(-c / a, wp.float64(0.0)) - wp.float64(2.0))
        elif c <= wp.float64(0.0):
            last = wp.float64(0.0)
    left = grid.origin[0] + first * grid.pitch[0]
    right = grid.origin[0] + last * grid.pitch[0]
    nearest = wp.max(
        wp.max(inverse_depth(planes, wp.vec2d(left, top)), inverse_depth(planes, wp.vec2d(right, top))),
        wp.max(inverse_depth(planes, wp.vec2d(left, bottom)), inverse_depth(planes, wp.vec2d(right, bottom))),
    )
    if last <= first or nearest * wp.float64(NEAR) >= wp.float64(1.0):
        return wp.vec2i(0, 0)
    return wp.vec2i(wp.int32(wp.ceil(first)), wp.int32(last))


CLAIM = """
    int* __restrict cell = (int*)((char*)visible.data + (long)row*visible.strides[0]);
    int taken = 0;
    for (int i = first; i < last; ++i) {
        taken += cell[i] >= 0;
        cell[i] = cell[i] >= 0 ? cell[i] : value;
    }
    return taken == 0;
"""


@form()
def claiming() -> Twins:
    """The function that writes `value` to the cells of a run that hold none >= 0 yet. True: it wrote all of them."""

    @wp.func(module="unique")
    def claim(
        visible: wp.array2d(dtype=wp.int32), row: wp.int32, first: wp.int32, last: wp.int32, value: wp.int32
    ) -> wp.bool:
        taken = wp.int32(0)
        for i in range(first, last):
            if visible[row, i] >= 0:
                taken += 1
            else:
                visible[row, i] = value
        return taken == 0

    return Twins(claim, CLAIM)


CLEAR = """
    int* cell = (int*)((char*)visible.data + (long)row*visible.strides[0]);
    for (int i = 0; i < cells; ++i) cell[i] = -1;
"""


@form()
def clearing() -> Twins:
    """The function that writes -1 to a row."""

    @wp.func(module="unique")
    def clear(visible: wp.array2d(dtype=wp.int32), row: wp.int32, cells: wp.int32):
        for i in range(cells):
            visible[row, i] = -1

    return Twins(clear, CLEAR)


REACHING = """
    const double* __restrict y = (const double*)bounds.data;
    const int count = bounds.shape[0];
    int k = first;
    while (k < count && !(y[2*k] <= bottom && y[2*k + 1] >= top)) ++k;
    return k;
"""


@form()
def next_reaching() -> Twins:
    """The function that finds the first triangle from `first` on that reaches into a row; their number if none."""

    @wp.func(module="unique")
    def reaching(bounds: wp.array(dtype=wp.vec2d), first: wp.int32, top: wp.float64, bottom: wp.float64) -> wp.int32:
        k = wp.int32(first)
        while k < bounds.shape[0]:
            if bounds[k][0] <= bottom and bounds[k][1] >= top:
                return k
            k += 1
        return k

    return Twins(reaching, REACHING)


claim, clear, reaching = claiming().native, clearing().native, next_reaching().native

SHORT = 16
"""Cells of a span in which each sample is tested, as finding out which need no test would cost more."""


@wp.func
def see_row(
    row: wp.int32,
    j: wp.int32,
    grid: Grid,
    edges: wp.array(dtype=Edges),
    planes: wp.array(dtype=Planes),
    bounds: wp.array(dtype=wp.vec2d),
    visible: wp.array2d(dtype=wp.int32),
):
    """Fill a row of a visibility buffer with row j of the grid: the index of the nearest triangle, -1 for none.

    `bounds` gives each triangle's y range, px.
    """
    top = grid.origin[1] + wp.float64(j) * grid.pitch[1]
    bottom = top + grid.pitch[1]
    clear(visible, row, grid.width)
    k = reaching(bounds, 0, top, bottom)
    while k < edges.shape[0]:
        span = row_span(edges[k], grid, j)
        stop = wp.min(span[1], grid.width)
        inner = wp.vec2i(0, 0)
        if stop - span[0] > SHORT:
            inner = inner_span(edges[k], planes[k], grid, j)
        whole = claim(visible, row, inner[0], inner[1], k)
        i = wp.int32(span[0] - 1)
        while i + 1 < stop:
            i += 1
            if whole and i == inner[0] and inner[1] > i:
                i = inner[1] - 1
                continue
            if visible[row, i] == k:
                continue
            p = sample_position(grid, i, j)
            if covers(edges[k], p):
                nearness = inverse_depth(planes[k], p)
                if nearness * wp.float64(NEAR) <= wp.float64(1.0):
                    other = visible[row, i]
                    if other < 0:
                        visible[row, i] = k
                    elif nearness > inverse_depth(planes[other], p):
                        visible[row, i] = k
        k = reaching(bounds, k + 1, top, bottom)


@wp.kernel
def rasterise(
    first_row: wp.int32,
    grid: Grid,
    edges: wp.array(dtype=Edges),
    planes: wp.array(dtype=Planes),
    bounds: wp.array(dtype=wp.vec2d),
    visible: wp.array2d(dtype=wp.int32),
):
    """Fill a visibility buffer, one thread a row: its row 0 is row `first_row` of the grid."""
    row = wp.tid()
    see_row(row, first_row + row, grid, edges, planes, bounds, visible)
