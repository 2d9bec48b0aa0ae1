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
# # 6 Two builds of your engine
#
# **Which of two builds flickers more, where, when, and is the difference more than chance?**
#
# You changed a shader, and the new build *looks* calmer. This notebook measures both builds against one reference,
# by a shot file, and answers each part of the question.
#
# It takes the three.js example of [reports/engines](../engines/README.md) where that was rendered, by `python
# reports/engines/threejs/run.py -o runs/threejs` and then `SWIMLAB_SHOT=runs/threejs/shot.toml jupyter lab`. Else
# twenty lines of NumPy play the engine.

# %%
import os
from pathlib import Path
from tempfile import TemporaryDirectory

import matplotlib.pyplot as plt
import numpy as np

import swimlab
from metrics import resolved
from metrics.synthetic import texture
from swimlab.runs.frames import write_channels
from swimlab.runs.scores import read_scores

# %% [markdown]
# ## The engine's part
#
# A disc slides before a ground that slides the other way. Both have a pattern that is partly finer than the pixels.
# A build shades at some points of each pixel and takes their mean: `main` at one point, `candidate` at 2x2, and the
# reference at 8x8. Motion vectors are what engines write: how far the surface in a pixel moved since the last frame.

# %%
SHOT = os.environ.get("SWIMLAB_SHOT")
MAIN, CANDIDATE = ("aliased", "filtered") if SHOT else ("main", "candidate")
WIDTH, HEIGHT, COUNT = 224, 128, 16
DISC, GROUND = np.array([1.3, -0.4]), np.array([-0.72, 0.59])  # px a frame, right and down
PATTERNS = [texture(seed, limit=0.8, waves=8) for seed in (1, 2)]  # waves of up to 0.8 cycles a pixel


def shaded(t, x, y):
    """Radiance [H, W, 3] at points of frame t, and where they lie on the disc."""
    on_disc = np.hypot(x - 50 - DISC[0] * t, y - 64 - DISC[1] * t) < 30
    disc, ground = (p.at(x - v[0] * t, y - v[1] * t) for p, v in zip(PATTERNS, (DISC, GROUND), strict=True))
    return np.where(on_disc[..., None], 0.7 + 0.1 * disc, 0.4 + 0.1 * ground), on_disc


def drawn(t, points):
    """Frame t as the mean of points x points samples a pixel, and its motion vectors at the pixels' centres."""
    y, x = np.arange(HEIGHT)[:, None] + 0.5, np.arange(WIDTH)[None, :] + 0.5
    places = (np.arange(points) + 0.5) / points - 0.5
    picture = np.mean([shaded(t, x + dx, y + dy)[0] for dx in places for dy in places], axis=0)
    return picture, np.where(shaded(t, x, y)[1][..., None], DISC, GROUND)


temporary = TemporaryDirectory(prefix="swimlab-builds-")  # gone when Python ends
folder = Path(temporary.name)
for t in range(0 if SHOT else COUNT):
    for name, points in (("main", 1), ("candidate", 2), ("reference", 8)):
        picture, motion = drawn(t, points)
        write_channels(folder / name / f"{t:04d}.exr", picture.astype("f4"), ("R", "G", "B"), half=True, metadata={})
    write_channels(folder / "motion" / f"{t:04d}.exr", motion.astype("f4"), ("X", "Y"), half=False, metadata={})

# %% [markdown]
# ## The shot file
#
# One reference, one motion, and a table for each build. `swimlab init-shot FOLDER` writes such a file from what it
# finds in a folder.

# %%
(folder / "shot.toml").write_text(
    """
version = 1
name = "sliding-disc"
fps = 60
[reference]
frames = "reference/####.exr"
[motion]
frames = "motion/####.exr"
[builds.main]
frames = "main/####.exr"
[builds.candidate]
frames = "candidate/####.exr"
""",
    encoding="utf-8",
)
shot = swimlab.study(Path(SHOT or folder / "shot.toml").absolute(), techniques=[MAIN, CANDIDATE])
shot

# %% [markdown]
# ## Which flickers more?
#
# *What to see:* a row a build. `flicker` is what changes on the surface, `edge flicker` is what crawls along the
# silhouettes, and `rms error` has both and what stands still. The candidate is better in all three.

# %%
main, candidate = shot.scores[MAIN], shot.scores[CANDIDATE]
for score in ("rms error", "flicker", "edge flicker"):
    assert candidate[score] < main[score], score

# %% [markdown]
# ## Is it more than chance?
#
# A score has a standard error: how far it would move on another piece of the same kind of surface. Two builds that
# show the same piece are compared in pairs, so that what the piece does to both cancels.

# %%
entries = {entry["technique"]: entry for entry in read_scores(shot.folder)["sequences"]}
sure = {name: resolved(name, entries[MAIN], entries[CANDIDATE]) for name in ("budget.flicker", "edges.flicker")}
assert sure["budget.flicker"]
sure

# %% [markdown]
# *What to see:* `True` where the difference is beyond two standard errors. From a shell, `swimlab compare` says it
# of two runs.
#
# ## When?
#
# Every frame has its own error. A fault that lasts a few frames stands out here; ours is there all along.

# %%
figure, axes = plt.subplots(figsize=(8, 2.4), layout="constrained")
for name, colour in ((MAIN, "#d55e00"), (CANDIDATE, "#0072b2")):
    rows = shot.by_frame[name]
    axes.plot([row["frame"] for row in rows], [row["mse"] ** 0.5 for row in rows], color=colour, label=name)
axes.set(xlabel="frame", ylabel="rms error, radiance", ylim=0)
_ = axes.legend()
assert all(c["mse"] < m["mse"] for c, m in zip(shot.by_frame[CANDIDATE], shot.by_frame[MAIN], strict=True))

# %% [markdown]
# ## Where?
#
# The part of the picture in which the builds differ most, enlarged, and its error on a fixed scale: red is too
# bright, blue too dark.

# %%
region = shot.detail()
shot.compare(frames=[4, 5, 6], region=region, zoom=4)

# %%
shot.errors(frame=5, region=region, zoom=4)

# %% [markdown]
# ## Keep it so
#
# `shot.report()` writes one HTML file to send to a colleague, with both builds to flip between. A gate holds the
# result in CI: `swimlab baseline update gate.toml RUN` once, then `swimlab gate gate.toml RUN` for every build.

# %%
page = shot.report(folder / "report.html")
assert CANDIDATE in page.read_text(encoding="utf-8")
