"""Standard streams that never fail for their encoding."""

import codecs
import io
import os
import sys
import unicodedata
from pathlib import Path

PLAIN = {
    "\N{UPWARDS ARROW}": "up",
    "\N{DOWNWARDS ARROW}": "down",
    "\N{RIGHTWARDS ARROW}": "->",
    "\N{ALMOST EQUAL TO}": "~",
    "\N{GREEK SMALL LETTER SIGMA}": "sigma",
    "\N{MULTIPLICATION SIGN}": "x",
    "\N{MIDDLE DOT}": "*",
    "\N{BULLET}": "*",
    "\N{EN DASH}": "-",
    "\N{EM DASH}": "-",
    "\N{MINUS SIGN}": "-",
    "\N{BOX DRAWINGS LIGHT HORIZONTAL}": "-",
    "\N{PLUS-MINUS SIGN}": "+-",
    "\N{LESS-THAN OR EQUAL TO}": "<=",
    "\N{GREATER-THAN OR EQUAL TO}": ">=",
    "\N{INFINITY}": "inf",
    "\N{DEGREE SIGN}": " deg",
    # Bars of small charts, from low to high.
    **dict(zip("\u2581\u2582\u2583\u2584\u2585\u2586\u2587\u2588", "_.,-=+*#", strict=True)),
}
"""What replaces a character that a stream cannot show."""

HANDLER = "swimlab.plain"


def make_streams_safe() -> None:
    """Replace what standard output and standard error cannot show by plain characters, from here on.

    A stream that is closed becomes one that swallows everything.
    """
    codecs.register_error(HANDLER, _replace)
    for name in ("stdout", "stderr"):
        stream = getattr(sys, name)
        if stream is None:
            setattr(sys, name, Path(os.devnull).open("w", encoding="utf-8"))  # noqa: SIM115 - open to the end
        elif isinstance(stream, io.TextIOWrapper):
            stream.reconfigure(errors=HANDLER)


def plain(character: str) -> str:
    """One character in ASCII: from the table, without its accents, or `?`."""
    if character in PLAIN:
        return PLAIN[character]
    return unicodedata.normalize("NFKD", character).encode("ascii", "ignore").decode("ascii") or "?"


def _replace(error: UnicodeError) -> tuple[str | bytes, int]:
    """Handle the first character that cannot be encoded, as `codecs.register_error` asks for."""
    if not isinstance(error, UnicodeEncodeError):
        raise error
    character = error.object[error.start]
    if "\udc80" <= character <= "\udcff":  # a byte of a file name that is not text: as it was
        return bytes([ord(character) - 0xDC00]), error.start + 1
    return plain(character), error.start + 1
