"""Which channels of a file are its colour, its alpha or its motion."""

from collections.abc import Mapping, Sequence

from swimlab.footage.header import Header, Part
from swimlab.runs.frames import FrameError

_COLOUR = (("R", "G", "B"), ("r", "g", "b"), ("red", "green", "blue"))
_ALPHA = ("A", "a", "alpha")


def find_colour(
    header: Header, chosen: str | None, name: str, *, part: str | None = None, prefix: str = ""
) -> tuple[int, tuple[str, ...]]:
    """The part and the three channels (one for grey) to measure.

    chosen: channels with commas, or the name of a layer or part; None: R, G, B; else the only layer that has them; else
    the only channel. part: name, view or index of the only part to look into. prefix: of the input's options, as
    "reference-". Raises FrameError naming the file and what there is.
    """
    parts = find_parts(header, part, name, option=f"--{prefix}part")
    option = f"--{prefix}channels"
    if chosen is not None:
        listed = tuple(channel.strip() for channel in chosen.split(","))
        if len(listed) not in (1, 3):
            raise FrameError(f"{option} {chosen}: give three channels with commas, one channel, or a layer's name")
        for index, each in parts.items():
            if all(channel in each.channels for channel in listed):
                return index, listed
        layers = [found for found in _layers(parts) if len(listed) == 1 and found[0] == listed[0]]
        if not layers:
            raise FrameError(f"{name}: has no channels or layer {chosen}; it has {_list(parts)}")
        return layers[0][1:]
    layers = _layers(parts)
    plain = [found for found in layers if set(found[2]) in map(set, _COLOUR)]
    views = {header.parts[index].view for _, index, _ in plain}
    if len(views) > 1:
        raise FrameError(f"{name}: holds the views {', '.join(sorted(views))}; choose one with --{prefix}part")
    if plain or len(layers) == 1:
        return (plain or layers)[0][1:]
    colours = [(i, c) for i, each in parts.items() for c in each.channels if c not in _ALPHA]
    if not layers and len(colours) == 1:
        return colours[0][0], (colours[0][1],)
    raise FrameError(
        f"{name}: which channels are the colour? It has {_list(parts)}; name three, or a layer, with {option}"
    )


def other_colours(header: Header, taken: int) -> list[str]:
    """Names of the parts but for the one taken that have R, G and B too."""
    parts = {index: part for index, part in enumerate(header.parts) if not part.deep and index != taken}
    plain = [index for _, index, channels in _layers(parts) if set(channels) in map(set, _COLOUR)]
    return [header.parts[index].name or str(index) for index in plain]


def find_parts(header: Header, wanted: str | None, name: str, *, option: str) -> dict[int, Part]:
    """Index -> part, of the parts that may be read: those that are no deep ones, or the one wanted.

    wanted: name, view or index of a part. Raises FrameError naming the file and its parts.
    """
    if wanted is None:
        return {index: part for index, part in enumerate(header.parts) if not part.deep}
    for trait in ("name", "view"):
        found = {index: part for index, part in enumerate(header.parts) if getattr(part, trait) == wanted}
        if len(found) == 1:
            break
    else:
        found = {index: part for index, part in enumerate(header.parts) if str(index) == wanted}
    if not found:
        names = ", ".join(part.name or str(index) for index, part in enumerate(header.parts))
        raise FrameError(f"{option} {wanted}: {name} has the parts {names}")
    if any(part.deep for part in found.values()):
        raise FrameError(f"{option} {wanted}: is a deep part of {name}; flatten it, as oiiotool --flatten does")
    return found


def find_alpha(part: Part, colour: Sequence[str]) -> str | None:
    """The alpha that goes with colour channels: A beside R, G, B; layer.A beside layer.R."""
    prefix = colour[0].rpartition(".")[0]
    names = (f"{prefix}.{alpha}" if prefix else alpha for alpha in _ALPHA)
    return next((name for name in names if name in part.channels), None)


def find_pair(
    header: Header, pairs: Sequence[tuple[str, str]], name: str, *, part: str | None = None
) -> tuple[int, tuple[str, str]]:
    """The part and the first of the pairs of channels that a file has, by themselves or in a layer.

    part: name, view or index of the only part to look into. Raises FrameError naming the file and what there is.
    """
    parts = find_parts(header, part, name, option="--motion-part")
    for pair in pairs:
        for index, part_of_file in parts.items():
            prefixes = [_prefix(channel, pair[0]) for channel in part_of_file.channels]
            found = [prefix for prefix in prefixes if prefix is not None and prefix + pair[1] in part_of_file.channels]
            if len(found) > 1 and "" not in found:
                choices = " or ".join(f"{prefix}{pair[0]},{prefix}{pair[1]}" for prefix in found)
                raise FrameError(f"{name}: has several motions; choose one with --motion-channels {choices}")
            if found:
                prefix = "" if "" in found else found[0]
                return index, (prefix + pair[0], prefix + pair[1])
    sought = " or ".join(",".join(pair) for pair in pairs)
    raise FrameError(f"{name}: has no channels {sought}; it has {_list(parts)}. Name them with --motion-channels x,y")


def _prefix(channel: str, name: str) -> str | None:
    """What stands before a name in a channel's name, "" or "layer."; None if it does not end so."""
    before = channel.removesuffix(name)
    return before if channel.endswith(name) and (not before or before.endswith(".")) else None


def _layers(parts: Mapping[int, Part]) -> list[tuple[str, int, tuple[str, ...]]]:
    """Name, part and channels of every layer that has red, green and blue."""
    found = []
    for index, part in parts.items():
        for triple in _COLOUR:
            for channel in part.channels:
                prefix = _prefix(channel, triple[0])
                if prefix is not None and all(prefix + each in part.channels for each in triple):
                    layer = prefix.removesuffix(".") or part.name
                    found.append((layer, index, tuple(prefix + each for each in triple)))
    return found


def _list(parts: Mapping[int, Part]) -> str:
    return "; ".join((f"{part.name}: " if part.name else "") + ", ".join(part.channels) for part in parts.values())
