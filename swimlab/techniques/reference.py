"""The truth: shade many jittered samples a pixel from the finest level, then average, and estimate its own error."""

from math import isqrt

from swimlab.shot import Shot
from swimlab.technique import Picture, Settings, Technique, render_samples
from swimlab.techniques.pixel_bilinear import finest


def render(shot: Shot, settings: Settings) -> Picture:
    """n x n stratified samples a pixel, n^2 = `shot.samples`; the same sub-pixel places in every frame."""
    return render_samples(shot, finest, n=isqrt(shot.samples), jittered=True)


TECHNIQUE = Technique(
    name="reference",
    summary="stratified supersampling of the shading itself",
    source="Cook 1986, Stochastic Sampling in Computer Graphics",
    render=render,
)
