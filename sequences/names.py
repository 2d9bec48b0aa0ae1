"""Names that a person gives to sequences, shots, builds and sweeps: folders and files are called by them."""

import re

NAME = r"^[A-Za-z0-9][A-Za-z0-9._-]*$"
LONGEST = 100


def check_name(name: str, of: str) -> str:
    """The name, which one of these may have; of: "a build". Raises ValueError."""
    if re.fullmatch(NAME, name) is None:
        raise ValueError(f"{name!r} is no name of {of}: use letters, digits, dot, dash and underscore")
    if len(name) > LONGEST:
        raise ValueError(f"{name!r} is too long for a name of {of}: use at most {LONGEST} characters")
    return name
