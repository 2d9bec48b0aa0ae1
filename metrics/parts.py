"""Measuring a span in parts, so that memory stays bounded: frames are read again for each part of its tiles."""

from collections.abc import Callable, Iterator
from dataclasses import dataclass, replace

from metrics.spans import Span
from metrics.tiles import Level

# Pixels transformed at a time: small enough that all work on a batch stays in the cache.
BATCH = 2**16


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
    per_row = 0 if span.correspondence is None else span.correspondence.bytes_per_row()
    chosen: list[Piece] = []
    number, taken, rows = 0, 0.0, slice(0, 0)
    for piece in pieces(span):
        level = span.levels[piece.level].part(piece.tiles)
        reach = slice(int(level.origin[:, 0].min()), int(level.origin[:, 0].max()) + level.size)
        if chosen:
            wider = slice(min(rows.start, reach.start), max(rows.stop, reach.stop))
            if taken + held(level) + per_row * (wider.stop - wider.start) > room:
                yield _part(span, chosen, number, rows)
                chosen, number, taken = [], number + 1, 0.0
        rows = wider if chosen else reach
        taken += held(level)
        chosen.append(piece)
    yield _part(span, chosen, number, rows)


def _part(span: Span, chosen: list[Piece], number: int, rows: slice) -> Span:
    tiles = [slice(0, 0)] * len(span.levels)
    for piece in chosen:
        first = tiles[piece.level].start if tiles[piece.level].stop else piece.tiles.start
        tiles[piece.level] = slice(first, piece.tiles.stop)
    return replace(
        span,
        levels=[level.part(some) for level, some in zip(span.levels, tiles, strict=True)],
        bands=None if span.bands is None else [band[some] for band, some in zip(span.bands, tiles, strict=True)],
        rows=slice(0, span.shape[0]) if span.correspondence is None else rows,
        part=number,
    )
