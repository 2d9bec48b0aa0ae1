"""Pictures of texture space: for each segment in sight its normals and its light, as the deck shows them."""

from collections.abc import Callable
from pathlib import Path
from typing import cast

import numpy as np
import warp as wp

from metrics.kernels.launch import Launcher
from swimlab.render.atlas import Held, Pool, Tiles
from swimlab.render.catalogue import model_of
from swimlab.render.inputs import Inputs
from swimlab.render.kernels.texture_space import NEVER, normal_as_colour
from swimlab.render.kernels.tile_table import EPOCH, KEEP, SHADE, START
from swimlab.render.material import load_material
from swimlab.render.plan import Plan
from swimlab.render.shot import Shot
from swimlab.render.target import Lighting, Ways
from swimlab.render.techniques.tsl import INPUTS, TslSettings, planned_alone
from swimlab.runs.files import replacing
from swimlab.runs.frames import COLOUR, Image, png, write_channels
from swimlab.runs.provenance import SWIMLAB
from swimlab.runs.record import RunError

FOLDER = "targets"


NORMALS = Inputs("normals", reflect=cast(wp.Function, normal_as_colour))


def check_targets(plan: Plan) -> None:
    """Raise RunError where a plan has no technique with targets."""
    if "tsl" not in plan.techniques:
        raise RunError("--targets: writes the targets of tsl; add it to --techniques")


def write_targets(run: Path, shot: Shot, metadata: dict[str, str]) -> list[Path]:
    """Write RUN/targets/FRAME/SEGMENT.exr and .png for each segment in sight.

    The EXR holds the light as it is pasted, linear RGBA, row 0 at v = 0. The PNG has the normals at the left and the
    light at the right, both under the deck's square root, v upwards. A tile is shown at the level it was shaded at,
    in the light of its own frame.
    """
    settings = TslSettings.model_validate(shot.sequence.techniques.get("tsl", {}))
    _, tiles = planned_alone(shot, settings)
    lightings = [Lighting(shot, Ways(shot, inputs)) for inputs in (INPUTS[settings.inputs], NORMALS)]
    folder = run / FOLDER / f"{shot.frame:04d}"
    written = []
    for target, segment in enumerate(tiles.layout.segments):
        light, bumps = (picture_of(target, tiles, lighting) for lighting in lightings)
        path = folder / f"{segment:04d}.exr"
        write_channels(path, light, COLOUR, half=False, metadata=metadata)
        both = np.concatenate([bumps[::-1, :, :3], light[::-1, :, :3]], axis=1)
        codes = np.rint(255 * np.sqrt(np.clip(both, 0, 1))).astype(np.uint8)
        with replacing(path.with_suffix(".png")) as temporary:
            temporary.write_bytes(png(codes))
        written.append(path)
    return written


def picture_of(target: int, tiles: Tiles, lighting: Lighting) -> Image:
    """A target as one picture [size, size, 4]: each tile at the level it is shaded at, 0 where it is not."""
    launcher, layout, frame = lighting.shot.launcher, tiles.layout, lighting.shot.frame
    pool, mine = Pool(launcher), layout.of(target)
    shown = Tiles(launcher, layout)
    table, levels = shown.table.host, tiles.table.host[SHADE, mine]
    table[[SHADE, KEEP]], table[EPOCH] = NEVER, frame
    table[SHADE, mine] = table[KEEP, mine] = levels
    table[KEEP, mine.start - 1] = 0
    shown.finest.fill(0)
    jobs = pool.placing(shown, lighting.light(shown), Held.nothing(launcher))()
    for way, rows in jobs.by_way.items():
        lighting.laid_out(way, shown, pool.texels)(rows)
    texels, start = pool.texels.numpy(), table[START]
    across, tile_level = int(layout.across[target]), int(layout.tile_levels[target])
    out = np.zeros((across, across, 1 << tile_level, 1 << tile_level, 4), np.float32)
    for place in np.flatnonzero(levels != NEVER).tolist():
        side = 1 << (tile_level - int(levels[place]))
        first = start[mine.start + place] if side > 1 else start[mine.start - 1] + place
        tile = texels[first : first + side * side].reshape(side, side, 4)
        each = (1 << tile_level) // side
        out[place // across, place % across] = tile.repeat(each, axis=0).repeat(each, axis=1)
    size = int(layout.widths[target])
    return np.ascontiguousarray(out.swapaxes(1, 2)).reshape(size, size, 4)


def write_run_targets(
    plan: Plan, run: Path, *, threads: int | None, device: str, advance: Callable[[], None] = lambda: None
) -> None:
    """Write the targets of every frame of a plan."""
    metadata = {"swimlab:hash": plan.digest(), "swimlab:version": SWIMLAB}
    with Launcher(threads=threads, device=device) as launcher:
        material, model = load_material(plan.sequence, launcher), model_of(plan.sequence)
        for frame in plan.frames:
            write_targets(run, Shot(plan.sequence, frame, material, model, plan.samples, launcher), metadata)
            advance()
