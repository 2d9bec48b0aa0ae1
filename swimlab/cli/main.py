"""The command `swimlab`: its subcommands, loaded when they are called, and what errors become."""

import os
import sys
import traceback
import warnings

# Work is shared among threads of our own; those of BLAS would fight them for the cores.
os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")

from cyclopts import App, CycloptsError

from swimlab.cli.bench_command import bench_command
from swimlab.cli.encoding import make_streams_safe
from swimlab.runs.provenance import SWIMLAB

COMMANDS = {
    "demo": "Render, measure and report a small road in under a minute, and say what to look at.",
    "study": "Render the techniques and the reference, or take builds of shot files; measure and report them.",
    "render": "Render a sequence under one or several techniques into a run folder.",
    "measure": "Measure the techniques of a run folder against its reference, or frames of your own.",
    "init-shot": "Write a shot file of the frames that a folder holds, with comments, to be gone through.",
    "report": "Write the report of run folders that have been measured.",
    "gate": "Hold the scores of runs to a gate file, for CI.",
    "compare": "Show the scores of runs side by side, or of a run against its history.",
    "table": "Query the scores of many runs in SQL.",
    "baseline": "Record the scores of runs as the baseline of a gate.",
    "sweep": "Render and measure a grid of sequences, techniques and settings, here or on a cluster.",
    "list": "List what there is: techniques, sequences, brdfs, metrics, conventions, colorspaces or views.",
    "info": "Say what a sequence, a run folder or frames of your own hold.",
    "selftest": "Measure clips with known answers and show both.",
    "doctor": "Check that everything swimlab needs works on this machine.",
    "schema": "Print the JSON schema of sequence, shot, gate or sweep files, for editors.",
}

app = App(
    name="swimlab",
    suppress_keyboard_interrupt=False,
    version=SWIMLAB,
    help="Measure temporal aliasing and swimming: tell a stable error from a flickering one.",
)
for _name, _help in COMMANDS.items():
    app.command(f"swimlab.cli.{_name}_command:{_name}_command".replace("-", "_"), name=_name, help=_help)
app.command(bench_command)


def main() -> None:
    """Run the command line. Exit codes: 0 good, 1 a gate failed, 2 could not run, 130 interrupted."""
    make_streams_safe()
    warnings.showwarning = _show_warning
    try:
        for name in set(sys.argv[1:2]) & set(COMMANDS):
            app[name].help = None  # its own page has all that its docstring says
        try:
            app(print_error=False, exit_on_error=False)
        finally:
            sys.stdout.flush()  # a reader that is gone is noticed here, and not at exit
    except KeyboardInterrupt:
        print(
            "swimlab: interrupted; what was written is whole, the same command goes on from there",
            file=sys.stderr,
        )
        sys.exit(130)
    except SystemExit as end:
        if isinstance(end.__context__, BrokenPipeError):  # rich ends with 1 then, which says that a gate failed
            sys.exit(2)
        raise
    except BrokenPipeError:
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
        sys.exit(2)
    except (ValueError, OSError, CycloptsError) as error:
        if os.environ.get("SWIMLAB_TRACEBACK"):
            raise
        for line in _words(error).splitlines():
            print(f"swimlab: {line}", file=sys.stderr)
        sys.exit(2)
    except Exception:  # Python would end with 1, which says that a gate failed
        traceback.print_exc()
        print("swimlab: could not finish: a fault of swimlab or of your technique, see above", file=sys.stderr)
        sys.exit(2)


def _words(error: Exception) -> str:
    """What to say of an error: of a file's the file and the reason, without the system's number for it."""
    if isinstance(error, OSError) and error.filename is not None and error.strerror:
        return f"{error.filename}: {error.strerror}"
    return str(error)


def _show_warning(message: Warning | str, *_: object, **__: object) -> None:
    print(f"swimlab: warning: {message}", file=sys.stderr)
