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
# # 1 First look at a sequence
#
# **How do I see that shading flickers, and how do I put a number on it?**
#
# A glossy road slides by under the camera, a fraction of a pixel a frame. Nothing else changes: no light moves, no
# surface changes. So whatever changes *on the road* from frame to frame is a fault of the shading technique. This
# notebook renders the road under four techniques, looks at them, and reads the scores.

# %%
import matplotlib.pyplot as plt

import swimlab

road = swimlab.study(
    "road-shift",
    techniques=["pixel-point", "pixel-aniso", "lod-hack", "tsl"],
    size=(160, 90),
    frames="0-11",
    samples=64,
)

# %% [markdown]
# `study` rendered every technique and a *reference*, here 64 shaded samples a pixel, which stands for the ground truth.
# The four:
#
# - `pixel-point` takes the one texel under the pixel's centre.
# - `pixel-aniso` filters albedo, normal and gloss anisotropically, then shades once. It is what most engines do.
# - `lod-hack` is the same, with normals faded to flat as they get small.
# - `tsl`, texture-space lighting, shades the texels first and filters the light.

# %%
road.compare(zoom=2)

# %% [markdown]
# *What to see:* the reference is covered with even, fine glints. `pixel-aniso` has a bright streak towards the sun
# where there is none in truth, `lod-hack` a broader one. `pixel-point` is a scatter of dots. `tsl` looks like the
# reference.
#
# ## Three frames of one detail
#
# A still picture cannot tell a pattern that rides with the road from one that boils. So here is the detail in which
# the techniques differ most, in three consecutive frames.

# %%
road.compare(frames=[0, 1, 2], region=road.detail(), zoom=4)

# %% [markdown]
# *What to see:* follow one bright dot along a row. In `pixel-point` it is gone in the next frame: this is the
# sparkle that players notice first. In `tsl` and in the reference the same shapes move on a little, to the right
# and down.
#
# ## Where each technique is wrong
#
# The scale is the same for every map and every study, so that two maps may be compared by eye.

# %%
road.errors(zoom=2)

# %% [markdown]
# *What to see:* large areas of one colour are *bias*: a neighbourhood that is too bright (red) or too dark (blue).
# A random mix of red and blue is detail or flicker; one frame cannot tell which.
#
# ## The scores

# %%
road.scores

# %% [markdown]
# The values are rms errors of linear radiance, except `visible flicker`, which counts thresholds of the eye. The
# parts add up as squares, exactly: error² = bias² + detail² + flicker².
#
# - **bias**: the mean of a neighbourhood is off. It stays, and it is calm.
# - **detail**: a pattern is lost or false, and glued to the road.
# - **flicker**: what changes on the road while the road does not. `floor` is the reference's own error, part of all
#   others.

# %%
for row in road.scores.values():
    parts = row["bias"] ** 2 + row["detail"] ** 2 + row["flicker"] ** 2
    assert abs(parts - row["rms error"] ** 2) < 1e-9

aniso, point, hack, tsl = (road.scores[name] for name in ("pixel-aniso", "pixel-point", "lod-hack", "tsl"))
assert point["flicker"] > 0.99 * point["rms error"]  # point sampling: right on average, never right in a frame
assert hack["flicker"] < aniso["flicker"]  # the hack is calmer ...
assert hack["rms error"] > aniso["rms error"]  # ... and further from the reference
assert tsl["rms error"] < aniso["rms error"] / 3

# %%
figure, axes = plt.subplots(figsize=(8, 3), layout="constrained")
left = [0.0] * len(road.scores)
for part, colour in (("bias", "#999999"), ("detail", "#56b4e9"), ("flicker", "#d55e00")):
    energy = [row[part] ** 2 for row in road.scores.values()]
    axes.barh(list(road.scores), energy, left=left, color=colour, label=part)
    left = [a + b for a, b in zip(left, energy, strict=True)]
axes.set_xlabel("squared error, radiance²")
_ = figure.legend(loc="outside right upper")

# %% [markdown]
# *What to see:* two bars of nearly the same length are wholly different faults. `pixel-point` is all flicker;
# `pixel-aniso` is mostly wrong in a way that stands still. A single number such as PSNR calls them equal.
#
# ## Frame by frame

# %%
figure, axes = plt.subplots(figsize=(8, 3), layout="constrained")
for name, rows in road.by_frame.items():
    known = [row for row in rows if row.get("change") is not None]
    axes.plot([row["frame"] for row in known], [row["change"] ** 0.5 for row in known], label=name)
axes.set(xlabel="frame", ylabel="rms change of the error\nsince the last frame, radiance", ylim=(0, None))
_ = figure.legend(loc="outside right upper")

# %% [markdown]
# *What to see:* flat lines. Nothing pops in this clip; each technique flickers as much in every frame. A spike
# would be the frame to look at first.
#
# ## Going on
#
# `road.report()` writes all of this as one HTML file that works offline, `road.clip("tsl")` gives the frames to
# measures of your own, and `swimlab.open("runs/study/road-shift")` opens a run that a command has made. A sequence
# is plain data, and may be changed before it is rendered:

# %%
import sequences

low_sun = sequences.load("road-shift").with_changes(name="low-sun", scene={"sun": {"elevation": 6.0}})
later = swimlab.study(low_sun, ["pixel-aniso", "tsl"], size=(160, 90), frames="0-3", samples=16)
later.compare(zoom=2)

# %% [markdown]
# *What to see:* with the sun at 6° instead of 14° the false streak of `pixel-aniso` is narrower and lies further
# off. It is no less false.
