"""What motion may have been meant as: every reading of the same numbers, and the setting that chooses it."""

from collections.abc import Iterator
from dataclasses import replace
from typing import get_args

from swimlab.footage.convention import PRESETS, Convention, Direction, Unit, guess

_FLIPS = {"": (1, 1), "x flipped": (-1, 1), "y flipped": (1, -1), "both flipped": (-1, -1)}
_SWAPPED = "x and y swapped"
OTHER_FILES = {
    "one frame late": (1, "each file of vectors for the frame before its own: number them one lower"),
    "one frame early": (-1, "each file of vectors for the frame after its own: number them one higher"),
}
"""Name -> whose vectors a frame has, as a difference of indices, and what mends it."""
_LENGTHS = {"of half the length": 0.5, "of twice the length": 2.0}


def other_conventions(
    now: Convention, channels: tuple[str, str], size: tuple[int, int]
) -> dict[str, tuple[Convention, str]]:
    """Name -> another convention and the options that choose it; none that means the same comes twice.

    channels: the channels that are read. size: width and height of the picture, px.
    """
    found: dict[str, tuple[Convention, str]] = {}
    known = {_meaning(now, size)}
    for name, other in [*_others(now), *_presets(channels)]:
        if _meaning(other, size) not in known:
            known.add(_meaning(other, size))
            found[name] = other, _setting(now, other, channels)
    for flip in _FLIPS:
        other = replace(_flipped(now, flip), channels=(channels[::-1],))
        options = f"--motion-channels {channels[1]},{channels[0]} {_options(now, other)}"
        found[_named(_SWAPPED, flip)] = other, options.strip()
    return found


def other_velocities(
    velocity: tuple[float, float], size: tuple[int, int]
) -> dict[str, tuple[tuple[float, float], str]]:
    """Name -> another velocity, px a frame, that (dx, dy) may stand for, and the option that gives it."""
    found: dict[str, tuple[tuple[float, float], str]] = {}
    known = {velocity}
    swapped = [(_named(_SWAPPED, flip), (velocity[1] * x, velocity[0] * y)) for flip, (x, y) in _FLIPS.items()]
    for name, (x, y) in [*_read_as_others(velocity, size), *swapped]:
        if (x, y) not in known:
            known.add((x, y))
            found[name] = (x, y), f"--motion {x:g},{y:g}"
    return found


def _read_as_others(velocity: tuple[float, float], size: tuple[int, int]) -> Iterator[tuple[str, tuple[float, float]]]:
    for name, other in _others(Convention()):
        x, y = (part * float(factor) for part, factor in zip(velocity, other.factors(size), strict=True))
        yield name, (x, y)


def _others(now: Convention) -> Iterator[tuple[str, Convention]]:
    """Other signs, directions, units and lengths; the smallest changes first."""
    units: list[Unit] = sorted(get_args(Unit), key=lambda unit: unit != now.unit)
    directions: list[Direction] = sorted(get_args(Direction), key=lambda direction: direction != now.direction)
    for unit in units:
        for direction in directions:
            for flip in _FLIPS:
                other_unit = f"in {unit}" if unit != now.unit else ""
                named = (other_unit, direction if direction != now.direction else "", flip)
                yield _named(*named), replace(_flipped(now, flip), unit=unit, direction=direction)
    for length, factor in _LENGTHS.items():
        for flip in _FLIPS:
            other = _flipped(now, flip)
            scale = (other.scale[0] * factor, other.scale[1] * factor)
            yield _named(length, flip), replace(other, scale=scale)


def _named(*parts: str) -> str:
    return ", ".join(filter(None, parts))


def _presets(channels: tuple[str, str]) -> Iterator[tuple[str, Convention]]:
    """Presets of files with such channels: their offset or scale may be what is amiss."""
    for name, preset in _fitting(channels):
        yield f"as of {name}", preset


def _fitting(channels: tuple[str, str]) -> Iterator[tuple[str, Convention]]:
    """Presets that read such channels."""
    for name, preset in PRESETS.items():
        if any(_ends(channels, pair) for pair in preset.channels):
            yield name, preset


def _flipped(now: Convention, flip: str) -> Convention:
    if flip == "y flipped":
        return replace(now, y="up" if now.y == "down" else "down")
    x, y = _FLIPS[flip]
    return replace(now, scale=(x * now.scale[0], y * now.scale[1]))


def _meaning(convention: Convention, size: tuple[int, int]) -> tuple[str, float, float, tuple[float, float]]:
    x, y = convention.factors(size)
    return convention.direction, float(x), float(y), convention.offset


def _setting(now: Convention, other: Convention, channels: tuple[str, str]) -> str:
    """A preset where no single option is set that overrules it; else single options.

    The preset whose own channels these are says most; presets of any channels do where unit or offset is another.
    """
    if any(_same(now, preset) for preset in PRESETS.values()):
        names = [name.removesuffix("-forward") for name, preset in _fitting(channels) if _same(other, preset)]
        own = guess(channels)
        if own in names:
            return f"--motion-convention {own}"
        if names and (other.unit, other.offset) != (now.unit, now.offset):
            first, *more = names
            also = f" (or {', '.join(more)}: they mean the same here)" if more else ""
            return f"--motion-convention {first}{also}"
    return _options(now, other)


def _options(now: Convention, other: Convention) -> str:
    """Single options that make one convention the other, but for its channels."""
    options = []
    if other.unit != now.unit:
        options.append(f"--motion-unit {other.unit}")
    if other.direction != now.direction:
        options.append(f"--motion-direction {other.direction}")
    if other.y != now.y:
        options.append(f"--motion-y {other.y}")
    if other.scale != now.scale:
        options.append("--motion-scale {:g},{:g}".format(*other.scale))
    if other.offset != now.offset:
        options.append("--motion-offset {:g},{:g}".format(*other.offset))
    return " ".join(options)


def _same(convention: Convention, preset: Convention) -> bool:
    """Whether the two mean the same for every size of the picture."""
    return all(_meaning(convention, size) == _meaning(preset, size) for size in ((3, 5), (5, 7)))


def _ends(channels: tuple[str, str], pair: tuple[str, str]) -> bool:
    """Whether channels are a pair, by itself or in a layer."""
    return all(channel == name or channel.endswith(f".{name}") for channel, name in zip(channels, pair, strict=True))
