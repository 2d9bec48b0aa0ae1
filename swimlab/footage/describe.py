"""What is known of frames without measuring them."""

from collections import Counter

from swimlab.footage.channels import find_alpha, find_colour
from swimlab.footage.colour import AUTO, resolve
from swimlab.footage.convention import guess
from swimlab.footage.header import LOSSY, Header
from swimlab.footage.pattern import frame_range
from swimlab.footage.reader import open_frames
from swimlab.runs.frames import FrameError


def describe(name: str) -> tuple[list[tuple[str, str]], list[str]]:
    """What a pattern, folder, file or video was taken for, as headings and values; what is wrong with its frames.

    Frames that are cut short are found too. Raises FrameError.
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
    try:
        part_index, channels = find_colour(header, None, name)
        problems = reader.problems(part_index, channels)
    except FrameError:
        problems = reader.problems(0, ())
    problems = reader.damage() | problems
    return lines, [problem for _, problem in sorted(problems.items())]


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
