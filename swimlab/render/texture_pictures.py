"""Pictures of texture space: for each segment in sight its normals and its light, as the deck shows them."""

from collections.abc import Callable
from pathlib import Path
from typing import Any, cast

import numpy as np
import warp as wp

from metrics.kernels.launch import Launcher
from swimlab.render.catalogue import model_of
from swimlab.render.inputs import Inputs
from swimlab.render.kernels.texture_space import NEVER, normal_as_colour
from swimlab.render.material import load_material
from swimlab.render.plan import Plan
from swimlab.render.shot import Shot
from swimlab.render.target import Lighting, Need, Screen
from swimlab.render.techniques.tsl import TslSettings, lit_targets
from swimlab.render.texture import MipChain
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
    light at the right, both under the deck's square root, v upwards. A tile is shown at the level it was shaded at.
    """
    settings = TslSettings.model_validate(shot.sequence.techniques.get("tsl", {}))
    screen = Screen.of(shot, settings.anisotropy)
    normals = Lighting(shot, NORMALS)
    folder = run / FOLDER / f"{shot.frame:04d}"
    written = []
    for lit in lit_targets(shot, settings, screen):
        light = flattened(lit.target, lit.need)
        bumps = flattened(normals.light(lit.segment, lit.target.shape.width, lit.need)[0], lit.need)
        path = folder / f"{lit.segment:04d}.exr"
        write_channels(path, light, COLOUR, half=False, metadata=metadata)
        both = np.concatenate([bumps[::-1, :, :3], light[::-1, :, :3]], axis=1)
        codes = np.rint(255 * np.sqrt(np.clip(both, 0, 1))).astype(np.uint8)
        with replacing(path.with_suffix(".png")) as temporary:
            temporary.write_bytes(png(codes))
        written.append(path)
    return written


def flattened(target: MipChain, need: Need) -> Image:
    """A target as one picture [size, size, 4]: each tile at the level it was shaded at, 0 where it was not."""
    size = target.shape.width
    texels, offsets = target.texels.numpy(), target.shape.offsets.numpy()
    levels = np.kron(need, np.ones((size // len(need),) * 2, np.int32))
    out = np.zeros((size, size, 4), np.float32)
    for level in np.unique(need[need != NEVER]).tolist():
        side = size >> level
        first = int(offsets[level])
        picture = texels[first : first + side * side].reshape(side, side, 4)
        mine: Any = levels == level
        out[mine] = picture.repeat(1 << level, axis=0).repeat(1 << level, axis=1)[mine]
    return out


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
