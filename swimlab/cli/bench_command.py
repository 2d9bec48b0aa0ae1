"""`swimlab bench`: one kind a file, loaded when it is called."""

from cyclopts import App

KINDS = {
    "measures": "Time the measures, in frames a second.",
}

bench_command = App(name="bench", help="Time techniques and measures, and hold their cost against their error.")
for _name, _help in KINDS.items():
    _function = f"bench_{_name.replace('-', '_')}"
    bench_command.command(f"swimlab.cli.{_function}:{_function}", name=_name, help=_help)
