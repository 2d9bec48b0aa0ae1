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
# # 3 The deck's claims, one by one
#
# **Is it true that filtered inputs are wrong and that texture-space lighting is right, and at what cost?**
#
# *Implementation of Reflectance Models for Games, Part II: Techniques* by Peter-Pike Sloan and Dan Baker argues
# that filtering the inputs of a non-linear shading is wrong, and that lighting should be done in texture space.
# Each claim is told here in our words and held to our numbers, which say whether it holds.
#
# The clips are small so that this runs in seconds; [Beyond the deck](../beyond-the-deck.md) has the same at full
# size.

# %%
import matplotlib.pyplot as plt
import numpy as np

import swimlab
from sequences.asphalt import make

TECHNIQUES = ["pixel-point", "pixel-trilinear", "pixel-aniso", "lod-hack", "tsl"]
road = swimlab.study("road-shift", TECHNIQUES, size=(240, 135), frames="0-7", samples=64)
scores = road.scores
scores

# %% [markdown]
# ## A small move of the triangle changes its samples altogether
#
# With maps of fine variation, neighbouring sample points give radiances that have nothing to do with each other.
#
# **Holds.** With point samples nearly all of the error is flicker. On average over time the picture is right: its
# bias is next to nothing.

# %%
point = scores["pixel-point"]
assert point["flicker"] > 0.95 * point["rms error"]
assert point["bias"] < 0.1 * point["rms error"]
road.compare(["pixel-point", "reference"], frames=[0, 1, 2, 3], region=road.detail(), zoom=4)

# %% [markdown]
# *What to see:* the upper row is another picture every time. In the lower row one pattern moves on.
#
# ## The mean colour of a neighbourhood should keep still
#
# So the deck explains texture swimming. The flicker by spatial frequency shows how large a neighbourhood has to be
# before its mean keeps still.

# %%
figure, axes = plt.subplots(figsize=(8, 3), layout="constrained")
for name in TECHNIQUES:
    bands = road.curves[name]["budget.bands"]
    flicker = np.sqrt(np.divide(bands["flicker"][1:], np.array(bands["static"][1:]) + bands["flicker"][1:]))
    axes.plot(bands["frequency"][1:], flicker, marker="o", label=name)
axes.set(
    xlabel="spatial frequency, cycles/px, from this octave's lower end on",
    ylabel="flicker's share\nof the rms error",
    ylim=(0, 1.02),
)
axes.set_xscale("log", base=2)
_ = figure.legend(loc="outside right upper")

# %% [markdown]
# **Holds as a criticism of point samples**, whose errors all flicker, however coarse the pattern. *What to see:*
# with filtered inputs the coarse errors, on the left, stand still: there the picture is wrong, but calmly so. Of
# what `tsl` gets wrong most flickers, too, but that is six times less.
#
# ## Texture filters are linear, reflectance is not
#
# The deck's formula, by hand. Take the road's normals and light them in the direction of a mirror reflection, for
# one light. Compare the mean of the shaded texels, which is right, with shading the mean texel, which is what a mip
# map does.

# %%
maps = make(0, 256)
normal, power = maps.normal.reshape(-1, 3), maps.gloss[..., 1].ravel()
flat = np.array([0.0, 0.0, 1.0])
tilted = np.array([np.sin(np.radians(30)), 0.0, np.cos(np.radians(30))])


def diffuse(n, light):
    return np.clip(n @ light, 0, None)


def specular(n, p, half):
    return p * np.clip(n @ half, 0, 1) ** p


def ratio(wrong, right):
    return float(np.mean(wrong) / np.mean(right))


mean = normal.mean(axis=0) / np.linalg.norm(normal.mean(axis=0))
ratios = {
    "diffuse, light overhead": ratio(diffuse(normal.mean(axis=0), flat), diffuse(normal, flat)),
    "specular, looking into the mirror": ratio(specular(mean, power.mean(), flat), specular(normal, power, flat)),
    "specular, 30° beside it": ratio(specular(mean, power.mean(), tilted), specular(normal, power, tilted)),
}
assert abs(ratios["diffuse, light overhead"] - 1) < 1e-3
assert ratios["specular, looking into the mirror"] > 2
assert ratios["specular, 30° beside it"] < 0.1
{name: f"{value:.3f} times the reference" for name, value in ratios.items()}

# %% [markdown]
# **Holds, and so does its companion**, that diffuse light may be filtered before: it is linear in the normal and
# comes out right. The specular lobe comes out several times too bright towards the mirror direction and
# all but vanishes beside it. In the picture this is a false mirror streak:

# %%
assert scores["pixel-aniso"]["bias"] > 10 * scores["tsl"]["bias"]
road.errors(["pixel-trilinear", "pixel-aniso", "tsl"], zoom=2)

# %% [markdown]
# *What to see:* red, too bright, along the line to the sun, blue, too dark, on both sides of it. `tsl` has neither.
#
# ## Filtered inputs buy some stability, and no more
#
# **Holds for filtered inputs**: against point samples flicker falls to less than half, and bias rises.

# %%
for name in ("pixel-trilinear", "pixel-aniso"):
    assert scores[name]["flicker"] < 0.5 * point["flicker"]
    assert scores[name]["bias"] > 10 * point["bias"]

# %% [markdown]
# **And it is worse than the deck says**: the total error of filtered inputs is no less than that of point samples.
# They buy calm with a wrong picture.

# %%
assert scores["pixel-aniso"]["rms error"] > 0.9 * point["rms error"]
assert scores["pixel-trilinear"]["rms error"] > point["rms error"]

# %% [markdown]
# ## The level-of-detail hack is calm and inaccurate
#
# **Holds.** It is the calmest of all that shade once a pixel, and the furthest from the reference.

# %%
hack = scores["lod-hack"]
once = ["pixel-point", "pixel-trilinear", "pixel-aniso", "lod-hack"]
assert hack["flicker"] == min(scores[name]["flicker"] for name in once)
assert hack["rms error"] == max(scores[name]["rms error"] for name in once)
road.compare(["lod-hack", "reference"], zoom=2)

# %% [markdown]
# *What to see:* the hack renders another material, a polished road.
#
# ## Shading first, and filtering the light, removes most artifacts
#
# **Holds.** Texture-space lighting is the linear filtering of the shaded result. Its error is a sixth of what
# filtered inputs have, and a sixth of the energy of that is the reference's own error (`floor`).

# %%
tsl = scores["tsl"]
assert tsl["rms error"] < scores["pixel-aniso"]["rms error"] / 4
assert tsl["flicker"] < scores["pixel-aniso"]["flicker"] / 2
assert tsl["bias"] < 0.1 * scores["pixel-aniso"]["bias"]

# %% [markdown]
# ## Texture-space lighting shows more fine detail
#
# **Holds for detail that is right, not for detail as such.** `detail` says how much is lost or false, and the
# spectrum how much fine structure there is at all.

# %%
assert tsl["detail"] < 0.3 * min(scores[name]["detail"] for name in ("pixel-trilinear", "pixel-aniso", "lod-hack"))
figure, axes = plt.subplots(figsize=(8, 3), layout="constrained")
for name in ("lod-hack", "pixel-trilinear", "pixel-aniso", "tsl"):
    curve = road.curves[name]["moire.radial"]
    axes.semilogy(curve["frequency"][1:], np.divide(curve["test"], curve["reference"])[1:], label=name)
axes.axhline(1, color="black", linestyle=":", label="as in truth")
axes.set(xlabel="spatial frequency, cycles/px", ylabel="power over the\nreference's power", xlim=(0, 0.5))
_ = figure.legend(loc="outside right upper")

# %% [markdown]
# *What to see:* `tsl` loses up to a third of the power of the finest detail and invents none. `pixel-aniso` shows
# twice as much as there is, false glitter. `lod-hack` and `pixel-trilinear` have far too much power in the coarsest
# patterns, which is the streak.
#
# ## Filtered non-linear functions make Moiré patterns
#
# **Holds here only in part.** There is false energy (`moire.excess`), but on this road it forms no pattern: no peak
# stands out of its spectrum, so what the eye sees is a streak and sparkle rather than fringes. A regular pattern
# would show them, as the zone plate of notebook 2 does.

# %%
raw = scores.to_dict()
assert raw["pixel-aniso"]["moire.excess"] > 0.1
assert raw["tsl"]["moire.excess"] < 0.01
assert "moire.peak_strength" not in raw["pixel-aniso"]
scores.absent["pixel-aniso"]["moire.peak_strength"]

# %% [markdown]
# ## A small rendering should look like the large one, scaled down
#
# The same view is rendered at nine sizes, and each is compared with the reference of its size.

# %%
scale = swimlab.study("road-scale", TECHNIQUES, size=(240, 135), samples=64)
figure, panels = plt.subplots(1, 2, figsize=(9, 3.2), layout="constrained")
for name in TECHNIQUES:
    curve = scale.curves[name]["scale"]
    panels[0].plot(np.log2(curve["scale"]), curve["rmse"], marker=".", label=name)
    panels[1].plot(np.log2(curve["scale"]), curve["mean_drift"], marker=".")
panels[0].set(ylabel="rms error over the reference's rms", xlabel="size of the picture, octaves", ylim=(0, None))
panels[1].set(ylabel="change of the mean, %", xlabel="size of the picture, octaves")
_ = figure.legend(loc="outside right upper")

# %% [markdown]
# *What to see:* on the left `tsl` stays low at every size, all others are off by about as much as the picture
# itself. On the right filtered inputs drift in brightness as the object gets smaller.
#
# **Holds for `tsl`.** But mind the right panel: the *hack* keeps its mean about as well as `tsl`. A constant mean
# alone does not make a picture scale independent; it may be wrong by the same amount at every size.

# %%
small = scale.scores
others = [name for name in TECHNIQUES if name != "tsl"]
assert small["tsl"]["scale rmse"] < min(small[name]["scale rmse"] for name in others) / 3
assert small["lod-hack"]["mean drift %"] < small["pixel-aniso"]["mean drift %"]
small

# %% [markdown]
# ## The main problem of texture-space lighting is its cost
#
# **Holds.** It shades every texel of every segment in view, seen or not, hundreds of times as many as there are
# pixels.

# %%
shaded = {name: cost["shaded_per_frame"] for name, cost in road.costs.items()}
assert shaded["tsl"] > 100 * shaded["pixel-aniso"]
{name: f"{count:,.0f} shaded a frame" for name, count in shaded.items()}

# %% [markdown]
# ## What does not hold
#
# **That texture-space lighting comes close to the ground truth.** The reference, plain brute force with 64 samples a
# pixel, shades *fewer* points than `tsl` in this clip, and its own error (`floor`) is smaller than that of `tsl`. 1024
# texels a segment pay off where many pixels share them, not in one small view; [Beyond the
# deck](../beyond-the-deck.md) has what is left when only the texels that are needed are shaded.

# %%
assert shaded["reference"] < shaded["tsl"]
assert tsl["floor"] < tsl["rms error"]

# %% [markdown]
# **That the closest technique is also the calmest to the eye.** Weighed by what an eye can see, the wrong but
# smooth `lod-hack` flickers less than `tsl`, which keeps the fine glints that really are there, and that a pixel
# grid cannot carry without some flicker. The reference's own residual flicker says so too.

# %%
assert hack["visible flicker"] < tsl["visible flicker"]
{name: f"{row['visible flicker']:.1f} thresholds" for name, row in scores.items()}

# %% [markdown]
# The deck ends on the question how to make *non-linear mip chains*. There are answers by now: `toksvig`, `lean`,
# `clean` and `vmf` keep moments of the normals in the chain and shade once. They have less than half the error of
# `pixel-aniso`, and [cost little more](../speed-against-error.md).

# %%
chains = swimlab.study("road-shift", ["pixel-aniso", "vmf", "toksvig"], size=(240, 135), frames="0-3", samples=16)
assert chains.scores["vmf"]["rms error"] < 0.5 * chains.scores["pixel-aniso"]["rms error"]
chains.scores
