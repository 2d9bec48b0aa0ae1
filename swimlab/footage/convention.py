"""What motion vectors mean: their channels, unit, direction and axes. No standard names them, so presets do.

`SOURCES` says of every preset where its meaning is from. A preset is what the engine itself writes or takes; where an
application scales its vectors on the way (as FSR's motionVectorScale and DLSS' InMVScale undo), single options do too.
Unreal's velocity buffer is not what Unreal exports: in version 4 it is `ndc` with the offset 32767/65535 and the scale
1/0.2495; in version 5 it holds square roots, to be decoded first (`EncodeVelocityToTexture` in Common.ush).
"""

from dataclasses import dataclass
from typing import TYPE_CHECKING, Literal

import numpy as np
from numpy.typing import NDArray

Unit = Literal["px", "ndc", "uv"]
Direction = Literal["backward", "forward"]
Vertical = Literal["down", "up"]

_PLAIN = (("motion.X", "motion.Y"), ("X", "Y"), ("x", "y"), ("U", "V"), ("u", "v"), ("R", "G"))


@dataclass(frozen=True)
class Convention:
    """How stored vectors become px, +x right and +y down.

    channels: pairs of channels, the first that a file has counts. unit: px; "ndc": the picture is 2 wide and high;
    "uv": it is 1 wide and high. direction: "backward": how far the surface seen in a pixel moved since the previous
    frame; "forward": how far it moves until the next one. y: which way the second channel is positive.
    scale: factors of x and y; -1 where vectors point to where the surface was. offset: the stored pair that means no
    motion. unwritten: the stored pair where the engine wrote none; None: there is no such pair.
    """

    channels: tuple[tuple[str, str], ...] = _PLAIN
    unit: Unit = "px"
    direction: Direction = "backward"
    y: Vertical = "down"
    scale: tuple[float, float] = (1.0, 1.0)
    offset: tuple[float, float] = (0.0, 0.0)
    unwritten: tuple[float, float] | None = None

    def factors(self, size: tuple[int, int]) -> NDArray[np.float32]:
        """What stored (x, y) less the offset are multiplied with to be px right and down.

        size: width and height of the vectors' own picture, whose px these are.
        """
        share = {"px": (1.0, 1.0), "ndc": (size[0] / 2, size[1] / 2), "uv": (float(size[0]), float(size[1]))}[self.unit]
        down = 1.0 if self.y == "down" else -1.0
        return np.array([share[0] * self.scale[0], down * share[1] * self.scale[1]], np.float32)


_RG = (("R", "G"), ("X", "Y"), ("x", "y"))
_BACK = (-1.0, -1.0)
_UNREAL = "FinalImageMovieRenderQueue_MotionVectors"

_KNOWN: dict[str, tuple[Convention, str]] = {
    "own": (Convention(), "swimlab's run folders: px since the frame before, right and down"),
    "blender": (
        Convention((("Vector.X", "Vector.Y"),), y="up", scale=_BACK),
        "Blender, Cycles' `primitive_motion_vector`: previous - current in X and Y (current - next in Z and W), px of "
        "the raster, y up",
    ),
    "unity": (
        Convention(_RG, unit="uv", y="up"),
        "Unity, URP's `CalcNdcMotionVectorFromCsPositions`: current - previous in uv; y up in the picture as it is "
        "read back, since render targets are flipped where uv starts at the top",
    ),
    "nuke": (
        Convention((("backward.u", "backward.v"),), y="up", scale=_BACK),
        "Foundry, Nuke's VectorGenerator: the offsets at which the previous frame holds the current pixel, px, y up",
    ),
    "nuke-forward": (
        Convention((("forward.u", "forward.v"),), y="up", direction="forward"),
        "Foundry, Nuke's VectorGenerator: as nuke, of the next frame; nuke itself where there is no backward channel",
    ),
    "ndc": (Convention(unit="ndc", y="up"), "a picture 2 wide and high, as clip space after division by w"),
    "uv": (Convention(unit="uv"), "a picture 1 wide and high from its top left, as textures in Direct3D and Vulkan"),
    "unreal": (
        Convention(((f"{_UNREAL}.R", f"{_UNREAL}.G"), *_RG), unit="uv", y="up", scale=(2.0, 2.0), offset=(0.5, 0.5)),
        "Unreal, manual, Cinematic Render Passes: Movie Render Queue stores motion normalised to the screen in 0..1, "
        "0.5 is none. `PostProcessVelocityLookup` in MaterialTemplate.ush, from which the pass is made, gives current "
        "- previous in NDC, y up; public readers of the pass take (value - 0.5) * 2 * size for px: a quarter of NDC",
    ),
    "godot": (
        Convention(_RG, unit="uv", scale=_BACK, unwritten=(-1.0, -1.0)),
        "Godot 4, scene_forward_clustered.glsl: previous - current, halves of clip space without its jitter, y down as "
        "in Vulkan; (-1, -1) is invalid in effects/motion_vector_inc.glsl",
    ),
    "threejs": (
        Convention(_RG, unit="ndc", y="up"),
        "three.js, src/nodes/accessors/VelocityNode.js: NDC now - NDC before; TRAANode.js takes it times (0.5, -0.5) "
        "for uv, so y is up",
    ),
    "fsr": (
        Convention(_RG, scale=_BACK),
        "AMD, FidelityFX-FSR2 README, Providing motion vectors: from a pixel to where it was in the previous frame, "
        "in px of the render size (after motionVectorScale), y down; without jitter unless "
        "FFX_FSR2_ENABLE_MOTION_VECTORS_JITTER_CANCELLATION; FSR 3 the same",
    ),
    "dlss": (
        Convention(_RG, scale=_BACK),
        "NVIDIA, DLSS Programming Guide 3.6: added to a pixel's place they give where it was in the previous frame; "
        "px after InMVScaleX, Y (nvsdk_ngx_helpers.h), at render size with MVLowRes, y down; with jitter if MVJittered",
    ),
}

PRESETS: dict[str, Convention] = {name: convention for name, (convention, _) in _KNOWN.items()}
"""Every preset; `nuke` is `nuke-forward` where a file has no backward channels."""

SOURCES: dict[str, str] = {name: source for name, (_, source) in _KNOWN.items()}
"""Where each preset's meaning is from: project, file or document, and what it says."""

if TYPE_CHECKING:
    Preset = str
else:
    Preset = Literal[tuple(PRESETS)]
    """A preset's name, for commands to choose from."""

_SIGNS = {
    "own": ("motion.X",),
    "blender": ("Vector.X", "Vector.Y"),
    "unreal": (f"{_UNREAL}.R",),
    "nuke": ("backward.u",),
    "nuke-forward": ("forward.u",),
}


def guess(channels: tuple[str, ...]) -> str | None:
    """The preset whose channel names a file has; None if none."""
    for name, signs in _SIGNS.items():
        if all(any(c == sign or c.endswith("." + sign) for c in channels) for sign in signs):
            return name
    return None
