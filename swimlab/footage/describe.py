"""What is known of frames without measuring them."""

from collections import Counter
from collections.abc import Sequence
from concurrent.futures import ThreadPoolExecutor

from metrics.machine import cores
from swimlab.footage.channels import find_alpha, find_colour
from swimlab.footage.colour import AUTO, FLOATS, resolve
from swimlab.footage.convention import guess
from swimlab.footage.depth import NAMES
from swimlab.footage.header import LOSSY, Header
from swimlab.footage.pattern import frame_range
from swimlab.footage.reader import Reader, open_frames
from swimlab.footage.source import check_usable
from swimlab.runs.frames import FrameError


def describe(name: str) -> tuple[list[tuple[str, str]], list[str]]:
    """What a pattern, folder, file or video was taken for, as headings and values; what is wrong with its frames.

    Frames that are cut short, or hold values that cannot be measured, are found too. Raises FrameError.
    """
    reader = open_frames(name)
    header = reader.header
    there = [number for index, number in enumerate(reader.numbers) if index not in reader.gaps]
    uneven = ", at uneven times, which number them" if reader.gaps else ""
    lines = [
        ("frames", f"{len(there)}, {frame_range(there)}{uneven}"),
        ("name", reader.name),
        ("size", "{}x{}".format(*header.size) + (f", pixels {header.oblong}" if header.oblong else "")),
    ]
    for part in header.parts:
        kinds = Counter(part.types)
        kind = kinds.most_common(1)[0][0]
        listed = [c if t == kind else f"{c} ({t})" for c, t in zip(part.channels, part.types, strict=True)]
        lines.append((f"part {part.name}" if part.name else "channels", f"{', '.join(listed)}; {kind}"))
    lossy = "; lossy: it makes flicker of its own" if header.compression in LOSSY else ""
    lines.append(("compression", header.compression + lossy))
    lines += _colour(header, name)
    lines.append(("fps", f"{header.fps:g}" if header.fps else "not in the file; give --fps"))
    motion = next((found for part in header.parts if (found := guess(part.channels))), None)
    if motion is not None:
        preset = motion.removesuffix("-forward")
        lines.append(("motion", f"channels as of --motion-convention {preset}; verified when measured"))
    damage = reader.damage()
    try:
        part_index, channels = find_colour(header, None, name)
    except FrameError:
        problems = damage | reader.problems(0, ())
    else:
        problems = damage | reader.problems(part_index, channels)
        problems |= _unusable(reader, part_index, channels, [*problems, *reader.gaps])
    return lines, [problem for _, problem in sorted(problems.items())]


def _unusable(reader: Reader, part: int, channels: Sequence[str], passed: Sequence[int]) -> dict[int, str]:
    """Frames whose colour is in places no finite number or none of light, by index; depth has no such limits.

    passed: indices that are not looked at.
    """
    of = reader.header.parts[part]
    if of.types[of.channels.index(channels[0])] not in FLOATS or channels[0].rpartition(".")[2] in NAMES:
        return {}

    def fault(index: int) -> str:
        try:
            check_usable(reader.read(index, part, channels), reader.label(index))
        except FrameError as error:
            return str(error)
        return ""

    wanted = sorted({*range(len(reader.numbers))} - {*passed})
    with ThreadPoolExecutor(cores()) as pool:
        faults = dict(zip(wanted, pool.map(fault, wanted), strict=True))
    return {index: said for index, said in faults.items() if said}


def _colour(header: Header, name: str) -> list[tuple[str, str]]:
    """Which channels are measured, in which colour space, and what alpha there is."""
    try:
        index, channels = find_colour(header, None, name)
    except FrameError:
        return [("colour", "no channels that are plainly a colour; choose with --channels")]
    part = header.parts[index]
    stored_as = part.types[part.channels.index(channels[0])]
    said = f"the file says {part.colour_space}" if part.colour_space else "the file does not say"
    try:
        taken = "taken as " + resolve(AUTO, stored_as=stored_as, metadata=part.colour_space)
    except ValueError:
        taken = "in a colour space that is not known"
    alpha = find_alpha(part, channels)
    kind = "not premultiplied" if header.unassociated else "premultiplied"
    return [
        ("colour", f"{', '.join(channels)}, {taken} ({said}); choose with --colorspace"),
        ("alpha", f"{alpha}, {kind}, ignored; choose with --alpha" if alpha else "none"),
    ]
