"""A shot's messages in the words of its file: what is an option on the command line is a key there."""

import re
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import get_args

from metrics import ClipError
from swimlab.footage.convention import PRESETS, Direction, Unit, Vertical
from swimlab.runs.frames import FrameError

_INPUTS = ("reference", "motion", "depth", "mask")
"""Inputs whose name stands before their options."""
_FLAGS = ("skip_bad_frames", "motion.unverified")
_KEYS = {
    "test": "frames",
    "pixels-per-degree": "viewing.pixels_per_degree",
    "luminance": "viewing.luminance",
    "exposure": "display.exposure",
    "tone-map": "display.tone_map",
    "display": "display.view",
}
_SAME = ("channels", "colorspace", "alpha", "part", "crop", "fps", "frames", "skip-bad-frames", *_INPUTS)
_VALUES = "|".join(
    sorted([*PRESETS, *get_args(Unit), *get_args(Direction), *get_args(Vertical)], key=len, reverse=True)
)
"""What convention, unit, direction and y may be."""
_NUMBER = r"-?[\d.]+(?:e[-+]?\d+)?"


def as_keys(text: str) -> str:
    """A message with keys of a shot file in place of the options that it names.

    >>> as_keys("give --motion 0.5,-1 or --motion-unverified, or mend --reference-colorspace")
    'give motion.velocity = [0.5, -1] or motion.unverified = true, or mend reference.colorspace'
    >>> as_keys("Use --motion-scale 1,-1, --motion-scale 2 or --motion-convention unity; check --motion-unit")
    'Use motion.scale = [1, -1], motion.scale = [2, 2] or motion.convention = "unity"; check motion.unit'
    """
    text = re.sub(rf"--motion ({_NUMBER}),({_NUMBER})", r"motion.velocity = [\1, \2]", text)
    text = re.sub(rf"--motion-(scale|offset) ({_NUMBER}),({_NUMBER})", r"motion.\1 = [\2, \3]", text)
    text = re.sub(rf"--motion-(scale|offset) ({_NUMBER})(?=[, ]|$)", r"motion.\1 = [\2, \2]", text)
    text = re.sub(rf"--motion-(convention|unit|direction|y) ({_VALUES})\b", r'motion.\1 = "\2"', text)
    text = re.sub(r"--motion estimate\b", "motion.estimate = true", text)
    text = re.sub(r"--frames (-?\d[\d,x-]*)", r'frames = "\1"', text)
    return re.sub(r"--([a-z]+(?:-[a-z]+)*)", _key, text)


@contextmanager
def in_words_of(path: Path) -> Iterator[None]:
    """Have errors of a shot's frames name its file, and its keys."""
    try:
        yield
    except (FrameError, ClipError) as error:
        raise type(error)("\n".join(f"{path}: {line}" for line in as_keys(str(error)).splitlines())) from error


def _key(option: re.Match[str]) -> str:
    of, _, rest = option[1].partition("-")
    if of in _INPUTS and rest:
        key = f"{of}.{rest.replace('-', '_')}"
    elif option[1] in _SAME:
        key = option[1].replace("-", "_")
    else:
        return _KEYS.get(option[1], option[0])
    return f"{key} = true" if key in _FLAGS else key
