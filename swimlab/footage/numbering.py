"""How frame numbers are written in names of files: 7, 0007, -7, -0007, 12345."""

import re
from collections.abc import Iterable

NUMBER = r"-?\d+"
_SEPARATOR = re.compile(r"(?:^|[^A-Za-z0-9])$")


def sign_counts(before: str) -> bool:
    """Whether a minus after this part of a name is a sign: at the start, or after . or _; else it is a separator."""
    return _SEPARATOR.search(before) is not None


def is_written(text: str, width: int, *, before: str = "") -> bool:
    """Whether a number is written in at least `width` digits, no more than it needs beyond them.

    A sign counts as a digit, as in Python's %04d, or, where it is no separator, does not, as in fileseq.
    """
    number = int(text)
    if text == f"{number:0{width}d}":
        return True
    return number < 0 and sign_counts(before) and text == f"-{-number:0{width}d}"


def common_width(texts: Iterable[str], *, before: str = "") -> int | None:
    """The digits that all of some numbers are padded to, None where they are not of one kind.

    >>> common_width(["9999", "10000"]), common_width(["8", "10"]), common_width(["08", "9", "010"])
    (4, 1, None)
    """
    written = list(texts)
    widths = {len(each) for text in written for each in (text, text.removeprefix("-"))}
    fitting = (width for width in sorted(widths) if all(is_written(text, width, before=before) for text in written))
    return next(fitting, None)
