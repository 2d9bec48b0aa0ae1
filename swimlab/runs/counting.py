"""How many there are of a thing, in words."""


def counted(count: int, thing: str) -> str:
    """A count and what is counted, which takes an s where it is not one.

    >>> counted(1, "frame"), counted(3, "frame")
    ('1 frame', '3 frames')
    """
    return f"{count} {thing}" if count == 1 else f"{count} {thing}s"
