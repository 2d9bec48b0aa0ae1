"""LDR-FLIP by its authors: Andersson et al., FLIP: A Difference Evaluator for Alternating Images, HPG 2020."""

from metrics import Clip
from swimlab.scoring.peer import Codes, Peer, PeerError, frame_means


def score(test: Clip, reference: Clip) -> dict[str, float]:
    """Mean FLIP of each frame, 0..1; at the clip's pixels per degree, else at FLIP's own 67."""
    import flip_evaluator  # an extra

    parameters = {} if test.pixels_per_degree is None else {"ppd": test.pixels_per_degree}

    def difference(picture: Codes, exact: Codes) -> float:
        try:
            # A dict of its own for each call: the evaluator writes into it.
            result = flip_evaluator.evaluate(exact, picture, "LDR", applyMagma=False, parameters=dict(parameters))
        except SystemExit as error:
            raise PeerError("--peers flip: flip-evaluator gave up; look at what it printed above") from error
        return float(result[1])

    return frame_means("flip", test, reference, difference)


PEER = Peer(
    name="flip",
    summary="mean FLIP a frame, 0..1, lower is better",
    source="Andersson et al. 2020, flip-evaluator",
    extra="flip",
    score=score,
)
