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
# # 5 Write a technique in one file
#
# **I have an idea against aliasing: how do I try it, and does it beat what is there?**
#
# A technique is an order of two operations: filter and shade. Here we write a new one, a hack that studios use:
# **fade the gloss**. Where a pixel covers many texels, make the highlight broader, by a knob that an artist turns.
# Is it better than fading the *normals*, as the level-of-detail hack does?
#
# ## The file
#
# A file in a folder of your own that defines `TECHNIQUE`. It filters as `pixel-aniso` does, and then changes one of
# the eight values of a texel: albedo (0 to 2), normal (3 to 5), Ks (6) and the highlight's power (7).

# %%
from pathlib import Path
from tempfile import TemporaryDirectory

import matplotlib.pyplot as plt

import sequences
import swimlab

temporary = TemporaryDirectory(prefix="swimlab-techniques-")  # gone when Python ends
folder = Path(temporary.name)
(folder / "gloss_fade.py").write_text('''
"""Gloss faded with distance: as pixel-aniso, with a highlight that gets broader as the footprint grows."""

from typing import Any

import warp as wp
from pydantic import Field

from swimlab.render import Chain, Settings, Surface, Technique, TextureFilter
from swimlab.render import anisotropic, isotropic_level, pixel_shading


class GlossFadeSettings(Settings):
    """How fast gloss fades."""

    per_level: float = Field(0.5, ge=0, le=8, description="halvings of the power for each level of detail above 0")
    anisotropy: int = Field(16, ge=1, le=64, description="most probes along the footprint's major axis")


def texture_filter(settings: GlossFadeSettings) -> TextureFilter:
    """The anisotropic filter, then power / 2^(per_level lod), no less than 1."""
    most, per_level = settings.anisotropy, settings.per_level

    @wp.func(module="unique")
    def faded(texels: wp.array(dtype=Any), chain: Chain, surface: Surface):
        texel = anisotropic(texels, chain, surface, most)
        lod = wp.max(wp.float32(isotropic_level(surface, chain)), 0.0)
        texel[7] = wp.max(texel[7] * wp.pow(2.0, -per_level * lod), 1.0)
        return texel

    return TextureFilter(faded)


TECHNIQUE = Technique(
    name="gloss-fade",
    summary="pixel-aniso with the highlight broadened as the footprint grows",
    source="folklore of game studios",
    render=pixel_shading(texture_filter),
    settings=GlossFadeSettings,
)
''')
swimlab.add_techniques(folder)

# %% [markdown]
# That is all. It is a technique like any other now: checked settings, resumable runs, every measure, the report.
# After a change of the file, `add_techniques` reads it anew. From a shell: `SWIMLAB_TECHNIQUES=folder swimlab study
# road-shift -t gloss-fade,tsl`. To give it to everybody, put the file into `swimlab/render/techniques/`, where the
# conformance tests find it.

# %%
first = swimlab.study("road-shift", ["gloss-fade", "pixel-aniso", "lod-hack"], size=(160, 90), frames="0-7", samples=64)
assert "gloss-fade" in first.techniques
first.compare(zoom=2)

# %% [markdown]
# *What to see:* the streak of `pixel-aniso` is gone, and the light lies broad on the road. The fine glints are
# gone, too.

# %%
first.scores

# %% [markdown]
# ## Turn the knob
#
# A setting stands in the sequence, under the technique's name.

# %%
road = sequences.load("road-shift")
trials = {}
for knob in (0.0, 0.25, 0.5, 1.0, 2.0):
    tuned = road.with_changes(techniques={"gloss-fade": {"per_level": knob}})
    study = swimlab.study(tuned, ["gloss-fade"], size=(160, 90), frames="0-7", samples=64)
    trials[knob] = study.scores["gloss-fade"]

aniso, hack = first.scores["pixel-aniso"], first.scores["lod-hack"]
assert abs(trials[0.0]["rms error"] - aniso["rms error"]) < 1e-3  # without fading it is pixel-aniso

figure, axes = plt.subplots(figsize=(8, 3), layout="constrained")
for score, colour in (("rms error", "black"), ("bias", "#999999"), ("detail", "#56b4e9"), ("flicker", "#d55e00")):
    axes.plot(list(trials), [row[score] for row in trials.values()], marker="o", color=colour, label=score)
axes.axhline(hack["rms error"], color="black", linestyle=":", label="lod-hack's rms error")
axes.set(
    xlabel="per_level: halvings of the power for each level of detail", ylabel="rms, linear radiance", ylim=(0, None)
)
_ = figure.legend(loc="outside right upper")

# %% [markdown]
# *What to see:* a valley. Too little leaves the false streak, too much a dull road that is wrong in another way,
# nearly as wrong as the hack's. At its best place, fading gloss is far better than fading normals, for averaged
# rough normals *are* a broader highlight.
#
# ## Is it good?
#
# Compare it with the techniques that know how much to broaden, because their mip chains keep how much the normals
# differ.

# %%
best = min(trials, key=lambda knob: trials[knob]["rms error"])
assert best > 0
assert trials[best]["rms error"] < 0.7 * hack["rms error"]
rivals = swimlab.study("road-shift", ["toksvig", "vmf"], size=(160, 90), frames="0-7", samples=64).scores
assert min(row["rms error"] for row in rivals.values()) < trials[best]["rms error"]
{f"gloss-fade, {best:g}": trials[best]["rms error"], **{name: row["rms error"] for name, row in rivals.items()}}

# %% [markdown]
# *What to see:* even at its best knob the hack stays behind `toksvig` and `vmf`, which need no knob. The knob's
# best place belongs to this road, this sun and this size of picture; theirs comes from the maps.
