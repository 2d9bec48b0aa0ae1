"""Tiles made by hand, for tests of what is done with them."""

from swimlab.render.atlas import Tiles
from swimlab.render.kernels.tile_table import KEEP, SHADE


def tiles_of(launcher, layout, shade=0, keep=0):
    """Tiles of targets that are all in sight."""
    tiles = Tiles(launcher, layout)
    tiles.finest.fill(0)
    tiles.table.host[SHADE], tiles.table.host[KEEP] = shade, keep
    return tiles
