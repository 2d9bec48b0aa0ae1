# ---
# jupyter:
#   jupytext:
#     formats: ipynb,py:percent
#   kernelspec:
#     display_name: Python 3
#     language: python
#     name: python3
# ---

# %% [markdown]
# # 4 Measure your engine's frames
#
# **What do I have to write out of my engine to know how much of its picture flickers?**
#
# All you need is what an engine can write: frames, and motion vectors. With a reference (the same shot with many
# samples) there is the whole error budget; without one there is residual flicker. This notebook plays both parts:
# it makes an engine's frames, writes them as an engine would, and measures them as footage.

# %%
from pathlib import Path
from tempfile import TemporaryDirectory

import matplotlib.pyplot as plt
import numpy as np

import sequences
import swimlab
from swimlab.runs.frames import FrameError, frame_path, read_frame, read_geometry, write_channels

# %% [markdown]
# ## The engine's part
#
# A camera drives along a road, shaded by `vmf`. We write RGB as half floats, alpha, and vectors as Unity's motion
# pass has them: how far a surface moved since the last frame, in **uv** (1 is the width or height of the picture),
# **y up**.

# %%
camera = {"pitch": -28.0}  # degrees: the camera looks down, so that the road fills the picture
shot = sequences.load("road-drive").with_changes(camera=camera)
truth = swimlab.study(shot, ["vmf"], size=(160, 90), frames="0-11", samples=64)
temporary = TemporaryDirectory(prefix="swimlab-engine-")  # gone when Python ends
engine = Path(temporary.name)
for frame in truth.frames:
    for name, folder in (("vmf", "shot"), ("reference", "truth")):
        pixels = read_frame(frame_path(truth.folder, name, frame))
        write_channels(engine / f"{folder}.{frame:04d}.exr", pixels, ("R", "G", "B", "A"), half=True, metadata={})
    motion = read_geometry(frame_path(truth.folder, "geometry", frame)).motion  # px, right and down
    height, width = motion.shape[:2]
    unity = motion / np.array([width, -height], np.float32)
    write_channels(engine / f"motion.{frame:04d}.exr", unity, ("R", "G"), half=False, metadata={})

frames, reference, motion = engine / "shot.####.exr", engine / "truth.####.exr", engine / "motion.####.exr"

# %% [markdown]
# Two rules when you write your own: motion vectors have to be **32-bit floats** (a half loses .016 px at 64 px),
# and the compression has to be lossless (`zip`, not `dwaa`), for lossy compression flickers by itself.
#
# ## Measure
#
# `alpha="mask"` measures only pixels that the road covers wholly; there is no motion of the sky.

# %%
own = swimlab.measure_frames(
    frames,
    reference=reference,
    motion=motion,
    convention="unity",
    fps=60,
    alpha="mask",
    pixels_per_degree=60,
    luminance=30,
)
own

# %% [markdown]
# *What to see:* a row of scores, and how the motion was **verified**: earlier frames were warped onto later ones
# under every reading of the vectors. The first residual, *as given*, is the smallest; only reading them forward in
# time is nearly as good, as the camera moves so evenly. The scores are those of the run folder itself:

# %%
direct = truth.scores["vmf"]
for part in ("rms error", "flicker"):
    assert abs(own.scores["test"][part] - direct[part]) < 0.03 * direct["rms error"]

# %% [markdown]
# ## A wrong convention is refused
#
# The commonest mistake is to take y the wrong way round. The result would be a plausible table of nonsense.
# Instead:

# %%
try:
    swimlab.measure_frames(frames, reference=reference, motion=motion, convention="uv", alpha="mask")
except FrameError as error:
    refusal = str(error)
assert "flipped" in refusal
refusal

# %% [markdown]
# The message names the reading that fits, and the setting that chooses it. Settings are named as the command line
# has them. In Python a convention is a value with the same parts:

# %%
from dataclasses import replace

from swimlab.footage.convention import PRESETS

mended = replace(PRESETS["uv"], y="up")
again = swimlab.measure_frames(frames, reference=reference, motion=motion, convention=mended, alpha="mask")
assert again.scores["test"]["rms error"] == own.scores["test"]["rms error"]

# %% [markdown]
# Other engines: `blender` (Vector pass: px, y up, pointing backwards), `unreal`, `godot`, `threejs`, `fsr`, `dlss`,
# `nuke`, `ndc` (the picture is 2 wide), and `own`, swimlab's (px, right and down, since the last frame);
# `swimlab list conventions` says what each means, and from which source.
#
# ## What if there are no vectors?
#
# Leaving motion out claims that nothing moves. Then all that moves counts as flicker. `motion="estimate"` finds
# motion by optical flow; that is labelled, since a flow that follows the aliases hides part of their swimming.

# %%
residual = {
    "vectors": own.scores["test"]["residual"],
    "estimated": swimlab.measure_frames(frames, motion="estimate", alpha="mask").scores["test"]["residual"],
    "left out": swimlab.measure_frames(frames, alpha="mask").scores["test"]["residual"],
}
assert residual["left out"] > 1.2 * residual["vectors"]
assert residual["estimated"] < 0.8 * residual["vectors"]

figure, axes = plt.subplots(figsize=(8, 2), layout="constrained")
axes.barh(list(residual), list(residual.values()), color="#d55e00")
_ = axes.set_xlabel("residual flicker, rms of linear radiance")

# %% [markdown]
# *What to see:* the same frames, three answers. Only the one with true vectors is the shading's own flicker; the
# estimated motion hides a third of it.
#
# The same from a shell:
#
# ```sh
# swimlab info 'shot.####.exr'
# swimlab measure --test 'shot.####.exr' --reference 'truth.####.exr' --motion 'motion.####.exr' \
#     --motion-convention unity --fps 60 --alpha mask
# ```
