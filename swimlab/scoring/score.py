"""Clips in, scores out: one line for rendered and for brought frames."""

from collections.abc import Callable, Sequence
from dataclasses import asdict
from typing import Any

from metrics import Alignment, Clip, Display, Measurement, ReferenceFrames, measure, quantisation
from metrics.display import Domain
from swimlab.runs.configuration import configuration
from swimlab.scoring.peer_scores import all_peer_scores


def score_clip(
    test: Clip,
    reference: Clip | ReferenceFrames | None,
    *,
    domain: Domain,
    display: Display,
    rounding: Sequence[float | None],
    peers: Sequence[str] = (),
    alignment: Alignment | None = None,
    progress: Callable[[int, int], None] | None = None,
    threads: int | None = None,
    device: str = "cpu",
) -> Measurement:
    """All scores of a clip: by `metrics`, by the named peers, and the quantisation floor.

    rounding: mean squared rounding errors of some frames, radiance^2, as `metrics.quantisation` takes them. The rest as
    `metrics.measure` takes it. Raises ClipError naming the frame that is bad, and PeerError.
    """
    found = measure(
        test,
        reference,
        domain=domain,
        display=display,
        alignment=alignment,
        progress=progress,
        threads=threads,
        device=device,
    )
    return with_others(found, test, reference, rounding=rounding, peers=peers)


def with_others(
    found: Measurement,
    test: Clip,
    reference: Clip | ReferenceFrames | None,
    *,
    rounding: Sequence[float | None],
    peers: Sequence[str] = (),
) -> Measurement:
    """The scores of `metrics`, and those that it does not know. The rest as for `score_clip`."""
    exact = reference.reference if isinstance(reference, ReferenceFrames) else reference
    found.scores |= all_peer_scores(peers, test, exact)
    found.merge(quantisation(rounding, test.count))
    return found


def entry_of(
    sequence: str,
    technique: str,
    found: Measurement,
    numbers: Sequence[int],
    *,
    domain: Domain,
    display: Display,
) -> dict[str, Any]:
    """What scores.json holds of a clip. numbers: of its frames, as in the names of their files."""
    frames = [{**row, "frame": numbers[row["frame"]]} for row in found.frames]
    shown: dict[str, Any] = {}
    if domain == "display":
        colour = configuration() if display.view is not None else None
        shown["display"] = asdict(display) | ({} if colour is None else {"configuration": colour.digest})
    return {"sequence": sequence, "technique": technique, **vars(found), "frames": frames, **shown}
