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
# # 2 What each measure means
#
# **What does a score say, and can I believe it?**
#
# Toy signals of which the answer is known, through the same measures as any rendered clip. Nothing is rendered
# here: `metrics` takes frames and the motion of the surface, and gives scores.

# %%
from math import radians, sqrt

import matplotlib.pyplot as plt
import numpy as np

from metrics import Clip, measure, measure_scales
from metrics.scale import area_filter
from metrics.synthetic import KINDS, Waves, alias, centres, error_clips, texture, zone_plate

MOTION = (23 / 32, 19 / 32)  # px a frame, right and down

# %% [markdown]
# ## Five errors of one size
#
# A texture moves by (23/32, 19/32) px a frame. To it we add an error of rms 0.1 with the *same* spectrum in every
# case, but which behaves in five ways over time: glued to the surface; fixed to the screen; swimming against the
# surface; new noise in every frame; and glued but of alternating sign.

# %%
parts = {}
for kind in KINDS:
    test, reference = error_clips(kind, motion=MOTION, rms=0.1)
    by_frame = [np.mean((test.frame(t) - reference.frame(t)) ** 2) for t in range(test.count)]
    assert abs(sqrt(np.mean(by_frame)) - 0.1) < 0.005  # frame by frame they are all alike
    scores = measure(test, reference, names=["budget"]).scores
    parts[kind] = {part: scores[f"budget.{part}"] for part in ("bias", "detail", "flicker")}

figure, axes = plt.subplots(figsize=(8, 2.6), layout="constrained")
left = np.zeros(len(KINDS))
for part, colour in (("bias", "#999999"), ("detail", "#56b4e9"), ("flicker", "#d55e00")):
    values = np.array([found[part] for found in parts.values()])
    axes.barh(KINDS, values, left=left, color=colour, label=part)
    left += values
axes.set(xlabel="squared error, radiance²", xlim=(0, None))
_ = figure.legend(loc="outside right upper")

# %% [markdown]
# *What to see:* five bars of one length, so MSE and PSNR call them equal. Only the glued error has no flicker: it
# looks like another texture. All others move against the surface, and the eye sees them at once.
# [Other metrics](../other-metrics.md) has what SSIM, FLIP, ColorVideoVDP and VMAF make of the five.

# %%
share = {kind: found["flicker"] / sum(found.values()) for kind, found in parts.items()}
assert share["glued"] < 0.001
assert share["noise"] > 0.99
assert share["blinking"] > 0.99
assert share["screen-fixed"] > 0.9

# %% [markdown]
# ## Bias and detail
#
# A glued error below 1/16 cycles/px is *bias*: whole neighbourhoods are too bright or too dark. Above, it is
# *detail*.


# %%
def glued_error(limit):
    """Test and reference: a texture, and an error of rms 0.1 with waves of a tenth of `limit` to `limit` cycles/px."""
    picture, wrong, (x, y) = texture(1, mean=3.0), texture(2, limit=limit), centres(120, 140)
    dx, dy = MOTION

    def reference(t):
        return picture.at(x - t * dx, y - t * dy)

    def test(t):
        return reference(t) + 0.1 * wrong.at(x - t * dx, y - t * dy)

    return Clip(test, 8, motion=MOTION), Clip(reference, 8, motion=MOTION)


coarse, fine = (measure(*glued_error(limit), names=["budget"]).scores for limit in (0.04, 0.4))
assert coarse["budget.bias"] > 0.9 * coarse["budget.mse"]
assert fine["budget.detail"] > 0.8 * fine["budget.mse"]
assert max(coarse["budget.flicker"], fine["budget.flicker"]) < 1e-4 * fine["budget.mse"]

# %% [markdown]
# ## Without a reference: residual flicker
#
# Often there is no truth at hand. `residual.flicker` is the change of the *test itself* on the surface. It needs
# the motion and nothing else, and cannot see bias or detail: a technique that renders plain grey scores 0.

# %%
noisy, clean = error_clips("noise", motion=MOTION, rms=0.1)
without = {
    name: measure(clip, names=["residual"]).scores["residual.flicker"]
    for name, clip in (("noisy", noisy), ("clean", clean))
}
assert abs(sqrt(without["noisy"]) - 0.1) < 0.01
assert sqrt(without["clean"]) < 0.01
{name: f"{sqrt(value):.4f} rms" for name, value in without.items()}

# %% [markdown]
# ## Alias orders: the signature of swimming
#
# A pixel samples the surface once. Detail finer than two pixels comes out as a coarser wave, its *alias*, and moves
# at another speed than the surface: it swims. Six waves drift here, three of them too fine for the pixel grid.

# %%
waves = Waves()
shares = {}
for samples in (1, 4, 16):
    scores = measure(waves.clip(samples, 0.375), names=["plane"]).scores
    shares[samples] = [scores["plane.on"], scores["plane.order1"]]
    assert np.allclose(shares[samples], waves.shares(samples)[:2], atol=1e-4)  # the closed form

figure, axes = plt.subplots(figsize=(8, 2.2), layout="constrained")
names = [f"{samples} per pixel" for samples in shares]
axes.barh(names, [on for on, _ in shares.values()], color="#56b4e9", label="moves with the surface")
axes.barh(
    names, [a for _, a in shares.values()], left=[on for on, _ in shares.values()], color="#d55e00", label="swims"
)
axes.set(xlabel="share of the picture's energy", xlim=(0, 1))
_ = figure.legend(loc="outside right upper")

# %% [markdown]
# *What to see:* with one sample a pixel half of the energy swims. Averaging 4 samples removes most of that, and 16
# hardly more: what is left passes the pixel's own box filter.
#
# If the picture moves by exactly one pixel a frame (or half a pixel), aliases coincide with the picture, and the
# measure says that it cannot tell, instead of giving a number:

# %%
refused = measure(waves.clip(1, 1.0), names=["plane"])
assert "plane.on" not in refused.scores
refused.absent["plane.on"]

# %% [markdown]
# ## Moiré: aliases that form a pattern
#
# A zone plate is rings that get ever finer. This crop has 0.95 cycles a pixel, more than a grid of pixels can hold.

# %%
angle, size = radians(5), (160, 128)
point, truth = (zone_plate(0.95, angle, samples=n, count=8, size=size, motion=MOTION) for n in (1, 12))
found = measure(point, truth, names=["moire"]).scores
figure, panels = plt.subplots(1, 2, figsize=(8, 3.2), layout="constrained", sharey=True)
for axes, clip, title in zip(panels, (point, truth), ("1 sample a pixel", "144 samples a pixel"), strict=True):
    axes.imshow(clip.frame(0)[..., 0], cmap="gray", vmin=1, vmax=3)
    axes.set(title=title, xlabel="px")
_ = panels[0].set_ylabel("px")

# %% [markdown]
# *What to see:* on the left broad stripes that do not exist; the reference is nearly an even grey. The measure names
# their frequency, which is that of the alias:

# %%
assert abs(found["moire.peak_frequency"] - alias(0.95, angle)) < 0.02 * alias(0.95, angle)
f"{found['moire.peak_frequency']:.3f} cycles/px, a stripe every {1 / found['moire.peak_frequency']:.1f} px"

# %% [markdown]
# ## Scale: small should look like large from afar
#
# A picture is made at four sizes. An honest renderer's small picture is the large one, averaged. Point sampling
# keeps a highlight whole or drops it. The third renderer averages, but gets a little brighter at every halving.

# %%
random = np.random.default_rng(0)
large = np.repeat(random.gamma(0.5, 1.0, (128, 128, 1)), 3, axis=2)  # sparse highlights, mean 0.5
scales = [1, 1 / 2, 1 / 4, 1 / 8]


def smaller(scale):
    side = round(128 * scale)
    return np.moveaxis(area_filter(np.moveaxis(large, 2, 0), side, side), 0, 2)


pictures = {
    "averaged": [smaller(scale) for scale in scales],
    "point sampled": [large[:: round(1 / scale), :: round(1 / scale)] for scale in scales],
    "2 % brighter each halving": [smaller(scale) * 1.02 ** -np.log2(scale) for scale in scales],
}
truths = [Clip(lambda t, picture=picture: picture, 1) for picture in pictures["averaged"]]
rows = {}
for name, made in pictures.items():
    clips = [Clip(lambda t, picture=picture: picture, 1) for picture in made]
    rows[name] = measure_scales(clips, truths, scales).scores

figure, axes = plt.subplots(figsize=(8, 2.2), layout="constrained")
axes.barh(list(rows), [row["scale.rmse"] for row in rows.values()], color="#4477aa")
_ = axes.set_xlabel("scale.rmse: rms difference to the reference at each size, over the reference's rms")

# %% [markdown]
# *What to see:* point sampling is off by more than the picture itself; the mean's drift is what tells the third:

# %%
assert rows["averaged"]["scale.rmse"] < 1e-9
assert rows["point sampled"]["scale.rmse"] > 0.5
assert abs(rows["2 % brighter each halving"]["scale.slope"] + 2.0) < 0.1  # % an octave towards scale 1
{name: f"{row['scale.mean_drift']:.1f} %" for name, row in rows.items()}

# %% [markdown]
# ## Is it visible?
#
# `visible.flicker` weighs flicker by the eye's sensitivity to spatial and temporal frequency. 1 is the threshold of
# an eye that follows the surface. It needs to know how large a pixel looks and how bright the screen is.

# %%
near, far = (
    measure(
        Clip(noisy.frame, noisy.count, motion=MOTION, pixels_per_degree=density, luminance=30.0),
        clean,
        names=["visible"],
    ).scores["visible.flicker"]
    for density in (20.0, 80.0)
)
assert far < near
f"{near:.1f} thresholds at 20 pixels per degree, {far:.1f} at 80"

# %% [markdown]
# *What to see:* the same frames, seen from four times as far, flicker less to the eye. `swimlab selftest` runs many
# more of such clips, and `swimlab list metrics` says what every score is.
