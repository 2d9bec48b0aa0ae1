"""Plug-ins by name: every module of a package that declares one is found; nothing is listed by hand."""

import importlib
import pkgutil
from types import ModuleType
from typing import Any


def discover(package: ModuleType, attribute: str) -> dict[str, Any]:
    """Collect `attribute` of every module of a package by its `name`, sorted.

    Raises ValueError where two modules declare the same name, and AttributeError where a module declares none.
    """
    found: dict[str, Any] = {}
    for info in pkgutil.iter_modules(package.__path__, package.__name__ + "."):
        entry = getattr(importlib.import_module(info.name), attribute)
        if entry.name in found:
            raise ValueError(f"{info.name}: {package.__name__} has a {entry.name!r} already")
        found[entry.name] = entry
    return dict(sorted(found.items()))
