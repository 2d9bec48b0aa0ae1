"""ColorVideoVDP: Mantiuk et al., ColorVideoVDP: A visual difference predictor for image, video and display
distortions, SIGGRAPH 2024."""

import numpy as np

from metrics import Clip
from swimlab.scoring.peer import Peer, displayed

DISPLAY = "standard_4k"
PADDING = "replicate"
"""At the clip's start; the API and the command line of ColorVideoVDP differ in their defaults, so it is given."""


def score(test: Clip, reference: Clip) -> dict[str, float]:
    """Quality in just-objectionable differences, 10 is the reference; on the 4K display, at the clip's fps.

    The whole clip is held in memory. The clip's pixels per degree replace the display's, where known.
    """
    import pycvvdp  # an extra

    clips = [np.stack([displayed(clip, frame) for frame in range(clip.count)]) for clip in (test, reference)]
    height, width = test.shape
    geometry = None
    if test.pixels_per_degree is not None:
        geometry = pycvvdp.vvdp_display_geometry((width, height), ppd=test.pixels_per_degree)
    metric = pycvvdp.cvvdp(display_name=DISPLAY, display_geometry=geometry, temp_padding=PADDING, quiet=True)
    quality, _ = metric.predict(*clips, dim_order="FHWC", frames_per_second=test.fps)
    return {"vdp.jod": float(quality)}


PEER = Peer(
    name="vdp",
    summary="quality in just-objectionable differences, at most 10, higher is better",
    source="Mantiuk et al. 2024, cvvdp",
    extra="vdp",
    score=score,
)
