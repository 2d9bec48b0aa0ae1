"""Colour spaces and display views by name, through OpenImageIO's OpenColorIO.

Names are those of the user's configuration, `$OCIO`, else of the built-in ACES one; what the first lacks is looked up
in the built-in ACES studio configuration, which has HLG and cameras' logs too.
"""

import difflib
from collections.abc import Callable
from functools import lru_cache
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

CONFIGURATIONS = ("", "ocio://studio-config-latest")
"""In the order in which they are asked; the empty name is OpenImageIO's for `$OCIO`, else `ocio://default`."""

WORKING = "lin_rec709_scene"
"""The space of all radiance: linear, Rec.709 primaries, D65; a display's 100 cd/m^2 are 1."""

_CLOSE = 3


class Space(NamedTuple):
    """A colour space: the configuration that knows it, and its name there."""

    configuration: str
    name: str


class View(NamedTuple):
    """A view of a display: the configuration that knows it, and the names there."""

    configuration: str
    display: str
    view: str


def find_space(name: str) -> Space:
    """The colour space of a name, alias or role, upper or lower case. Raises ValueError with the names closest to it.

    >>> find_space("acescg").name
    'ACEScg'
    """
    for configuration in CONFIGURATIONS:
        found = _spaces(configuration).get(name.casefold())
        if found is not None:
            return Space(configuration, found)
    raise ValueError(f"OpenColorIO's configuration has no colour space {name!r}{_closest(name, space_names())}")


def find_view(name: str) -> View:
    """The view that `DISPLAY/VIEW` names, upper or lower case. Raises ValueError with the names closest to it."""
    for configuration in CONFIGURATIONS:
        for display, view in _views(configuration):
            if f"{display}/{view}".casefold() == name.casefold():
                return View(configuration, display, view)
    raise ValueError(f"OpenColorIO's configuration has no DISPLAY/VIEW {name!r}{_closest(name, view_names())}")


def space_names() -> list[str]:
    """The names of all colour spaces."""
    return list(dict.fromkeys(name for each in CONFIGURATIONS for name in _spaces(each).values()))


def view_names() -> list[str]:
    """All views, as DISPLAY/VIEW."""
    return list(dict.fromkeys("/".join(pair) for each in CONFIGURATIONS for pair in _views(each)))


def to_working(values: NDArray[Any], space: Space) -> NDArray[np.float32]:
    """Linear radiance [H, W, 3] of values [H, W, 3] that are in a colour space. Raises ValueError."""
    import OpenImageIO as oiio  # noqa: N813, heavy

    def convert(image: Any) -> Any:
        return oiio.ImageBufAlgo.colorconvert(image, space.name, WORKING, False, "", "", space.configuration)

    return _apply(convert, values, f"from {space.name} to linear Rec.709")


def show(radiance: NDArray[Any], view: View) -> NDArray[np.float32]:
    """What a view sends to its display, codes in 0..1 [H, W, 3], of linear radiance [H, W, 3]. Raises ValueError."""
    import OpenImageIO as oiio  # noqa: N813, heavy

    def convert(image: Any) -> Any:
        return oiio.ImageBufAlgo.ociodisplay(
            image, view.display, view.view, WORKING, "", False, False, "", "", view.configuration
        )

    return _apply(convert, radiance, f"from linear Rec.709 to {view.display}/{view.view}")


def _apply(convert: Callable[[Any], Any], pixels: NDArray[Any], what: str) -> NDArray[np.float32]:
    import OpenImageIO as oiio  # noqa: N813, heavy

    done = convert(oiio.ImageBuf(np.ascontiguousarray(pixels, np.float32)))
    if done.has_error:
        raise ValueError(f"OpenColorIO cannot go {what}: {done.geterror().strip()}")
    return np.asarray(done.get_pixels(oiio.FLOAT), np.float32)


@lru_cache
def _configuration(name: str) -> Any:
    import OpenImageIO as oiio  # noqa: N813, heavy

    found = oiio.ColorConfig(name)
    fault = found.geterror()
    if fault:
        raise ValueError(f"{name or '$OCIO'}: {fault.strip()}; mend the configuration, or unset OCIO")
    return found


@lru_cache
def _spaces(configuration: str) -> dict[str, str]:
    """Names, aliases and roles without case -> the name of the colour space."""
    known = _configuration(configuration)
    found = {role.casefold(): known.getColorSpaceNameByRole(role) for role in known.getRoles()}
    for name in known.getColorSpaceNames():
        found |= {alias.casefold(): name for alias in (*known.getAliases(name), name)}
    return found


@lru_cache
def _views(configuration: str) -> list[tuple[str, str]]:
    known = _configuration(configuration)
    return [(display, view) for display in known.getDisplayNames() for view in known.getViewNames(display)]


def _closest(name: str, names: list[str]) -> str:
    """What a mistaken name may have meant, for an error message."""
    by_case = {each.casefold(): each for each in names}
    close = [by_case[each] for each in difflib.get_close_matches(name.casefold(), by_case, _CLOSE, cutoff=0.0)]
    return f"; close to it are {', '.join(close)}"
