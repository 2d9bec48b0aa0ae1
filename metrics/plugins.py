"""Plug-ins by name: every module of a package that declares one is found; nothing is listed by hand."""

import importlib
import pkgutil
import sys
from collections.abc import Iterable
from importlib.util import cache_from_source
from pathlib import Path
from types import ModuleType
from typing import Any


def modules(package: str, folders: Iterable[str]) -> list[ModuleType]:
    """Every module of a package that lies in the folders, by name."""
    names = sorted(info.name for info in pkgutil.iter_modules(folders, package + "."))
    return [importlib.import_module(name) for name in names]


def discover(package: ModuleType, attribute: str) -> dict[str, Any]:
    """Collect `attribute` of every module of a package by its `name`, sorted.

    Raises ValueError where two modules declare the same name, and AttributeError where a module declares none.
    """
    found: dict[str, Any] = {}
    for module in modules(package.__name__, package.__path__):
        entry = getattr(module, attribute)
        if entry.name in found:
            raise ValueError(f"{module.__name__}: {package.__name__} has a {entry.name!r} already")
        found[entry.name] = entry
    return dict(sorted(found.items()))


def extend(package: ModuleType, folder: Path) -> list[str]:
    """Let the modules in a folder be found as if they were the package's own; return their full names.

    A folder that is given again is read again. Raises ValueError where there is no such folder, no module in it, or a
    module with the name of one of the package.
    """
    home = str(folder.resolve())
    others = [path for path in package.__path__ if path != home]
    names = [info.name for info in pkgutil.iter_modules([home])]
    if not names:
        raise ValueError(f"{folder}: is not a folder with a .py file in it")
    taken = {info.name for info in pkgutil.iter_modules(others)} & set(names)
    if taken:
        raise ValueError(f"{folder / min(taken)}.py: {package.__name__} has a file of this name; give it another")
    package.__path__ = [*others, home]
    importlib.invalidate_caches()
    for name in names:
        sys.modules.pop(f"{package.__name__}.{name}", None)
        # Python recognises a changed file by its size and second, which is too coarse for one that is being written.
        Path(cache_from_source(f"{home}/{name}.py")).unlink(missing_ok=True)
    return [f"{package.__name__}.{name}" for name in names]


def added(package: ModuleType) -> list[ModuleType]:
    """The modules that `extend` lets be found."""
    return modules(package.__name__, package.__path__[1:])


def retract(package: ModuleType, folder: Path) -> None:
    """Undo `extend`."""
    package.__path__ = [path for path in package.__path__ if path != str(folder.resolve())]
