"""Python as it is where most rendering engineers sit: without what Linux has and other systems lack.

Python imports this by itself, in every process, while its folder is on PYTHONPATH. Modules and
`os.getuid` are missing for our packages only: libraries on Linux need them. A file that is open can be neither
replaced nor removed, and there are no hard links, as on a memory card under Windows; processes start by spawn.
"""

import builtins
import io
import multiprocessing
import os
import sys
import weakref

OURS = ("swimlab", "metrics", "sequences")
MISSING = {"resource", "fcntl", "pwd", "grp", "termios"}

for _name in ("sched_getaffinity", "sched_setaffinity", "fork", "link"):
    if hasattr(os, _name):
        delattr(os, _name)


def _user_of_a_library():
    if sys._getframe(1).f_globals.get("__name__", "").partition(".")[0] in OURS:
        raise AttributeError("module 'os' has no attribute 'getuid'")
    return _getuid()


if hasattr(os, "getuid"):
    _getuid, os.getuid = os.getuid, _user_of_a_library

_import, _open = builtins.__import__, builtins.open
_held: "weakref.WeakKeyDictionary[object, str]" = weakref.WeakKeyDictionary()


def _without(name, globals=None, *rest, **named):
    if name in MISSING and (globals or {}).get("__name__", "").partition(".")[0] in OURS:
        raise ModuleNotFoundError(f"No module named {name!r}", name=name)
    return _import(name, globals, *rest, **named)


def _noting(file, *rest, **named):
    stream = _open(file, *rest, **named)
    if isinstance(file, str | os.PathLike):
        _held[stream] = os.path.realpath(os.fspath(file))
    return stream


def _refusing(act, which):
    def refuse(*paths, **named):
        target = os.path.realpath(os.fspath(paths[which])) if not isinstance(paths[which], int) else None
        if any(path == target and not stream.closed for stream, path in list(_held.items())):
            raise PermissionError(13, "The process cannot access the file because it is being used", str(paths[which]))
        return act(*paths, **named)

    return refuse


builtins.__import__ = _without
builtins.open = io.open = _noting
for _name, _which in (("replace", 1), ("rename", 1), ("remove", 0), ("unlink", 0)):
    setattr(os, _name, _refusing(getattr(os, _name), _which))
multiprocessing.set_start_method("spawn")
