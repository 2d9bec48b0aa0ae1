"""`swimlab bench`: one kind a file, loaded when it is called."""

from cyclopts import App

KINDS = {
    "brdfs": "Write the report on reflectance models: what each costs and loses, and its error and flicker.",
    "measures": "Time the measures, in frames a second.",
    "stability": "Write the report on hard cases: what single precision costs there, and the flicker it makes.",
    "beyond-the-deck": "Write the report on what lies beyond the deck: which technique at which cost.",
    "speed-error": "Write the report on speed against error: every technique at several settings.",
}

bench_command = App(name="bench", help="Time techniques and measures, and hold their cost against their error.")
for _name, _help in KINDS.items():
    _function = f"bench_{_name.replace('-', '_')}"
    bench_command.command(f"swimlab.cli.{_function}:{_function}", name=_name, help=_help)
