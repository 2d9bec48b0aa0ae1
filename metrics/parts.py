"""Measuring a span in parts, so that memory stays bounded: frames are read again for each part of its tiles."""

from collections.abc import Callable, Iterator
from dataclasses import dataclass, replace
from typing import Any

from numpy.typing import NDArray

from metrics.spans import Span
from metrics.tiles import Level

# Pixels transformed at a time: small enough that all work on a batch stays in the cache.
BATCH = 2**17


@dataclass(frozen=True)
class Piece:
    """Some tiles of one level, transformed together."""

    level: int
    tiles: slice


def pieces(span: Span) -> list[Piece]:
    """All tiles of a span in pieces of BATCH pixels."""
    return [
        Piece(index, slice(first, min(first + step, level.count)))
        for index, level in enumerate(span.levels)
        for step in (max(1, BATCH // level.size**2),)
        for first in range(0, level.count, step)
    ]


def parts(span: Span, held: Callable[[Level], float], room: float) -> Iterator[Span]:
    """The span's tiles in parts that take no more than about `room` bytes, each of at least one piece.

    held: level -> bytes that measures hold for all of its tiles. Every part has all levels, some without tiles.
    """
    chosen: list[Piece] = []
    number, taken, rows = 0, 0.0, slice(0, 0)
    for piece in pieces(span):
        level = span.levels[piece.level].part(piece.tiles)
        reach = slice(int(level.origin[:, 0].min()), int(level.origin[:, 0].max()) + level.size)
        if chosen and taken + held(level) > room:
            yield _part(span, chosen, number, rows)
            chosen, number, taken = [], number + 1, 0.0
        rows = slice(min(rows.start, reach.start), max(rows.stop, reach.stop)) if chosen else reach
        taken += held(level)
        chosen.append(piece)
    # A single part has all rows, so that its places serve every pixel's scores too.
    yield _part(span, chosen, number, rows if number else span.rows)


def _part(span: Span, chosen: list[Piece], number: int, rows: slice) -> Span:
    tiles = [slice(0, 0)] * len(span.levels)
    for piece in chosen:
        first = tiles[piece.level].start if tiles[piece.level].stop else piece.tiles.start
        tiles[piece.level] = slice(first, piece.tiles.stop)
    return replace(
        span,
        levels=[level.part(some) for level, some in zip(span.levels, tiles, strict=True)],
        bands=_some(span.bands, tiles),
        left=_some(span.left, tiles),
        rows=slice(0, span.shape[0]) if span.correspondence is None else rows,
        part=number,
    )


def _some(values: list[NDArray[Any]] | None, tiles: list[slice]) -> list[NDArray[Any]] | None:
    """For every level what belongs to some of its tiles."""
    return None if values is None else [each[some] for each, some in zip(values, tiles, strict=True)]
