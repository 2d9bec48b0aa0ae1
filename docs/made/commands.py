"""Every command, from its own help."""

import re

from swimlab.cli.main import app

OPENING = """# Commands

This page is made from the help of the commands: `swimlab COMMAND --help` prints the same.

Exit codes: **0** good, **1** a gate failed (of `selftest`: a check is off), **2** could not run, **130** interrupted.

| variable | what it does |
| --- | --- |
| `SWIMLAB_TECHNIQUES` | folders with techniques of your own, separated as in `PATH` |
| `SWIMLAB_TRACEBACK` | set: an error shows where in the code it was raised |
| `WARP_CACHE_PATH` | where compiled kernels are kept |
| `OCIO` | OpenColorIO's configuration, in place of the built-in ACES one |

"""


def page() -> str:
    """The page, a section a command."""
    text = app.generate_docs()
    text = text[text.index("## swimlab demo") :]
    text = re.sub(r"^(#+) swimlab ", r"\1 ", text, flags=re.MULTILINE)
    return OPENING + text
