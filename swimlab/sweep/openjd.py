"""A sweep as an Open Job Description job template, for render farms.

Source: Open Job Description, Template Schemas, revision 2023-09
(https://github.com/OpenJobDescription/openjd-specifications/wiki/2023-09-Template-Schemas).
"""

from pathlib import Path, PurePath
from typing import Any

from swimlab.sweep.work import Work

LONGEST_NAME = 64
"""Characters of a job's name that every revision allows."""


def _place(file: PurePath, folder: PurePath) -> str | None:
    """A file's path below a folder, with `/`; None where it lies outside of it, or on another drive."""
    return file.relative_to(folder).as_posix() if file.is_relative_to(folder) else None


def job_template(work: Work, sweep_file: Path, template: Path) -> dict[str, Any]:
    """The content of a template that will stand in the file `template`.

    Its step Render has a task for each chunk, or build of a shot; its step Measure follows, makes run folders and
    measures them. The machines share SweepFile, what that names, and Out.
    """
    count = len(work.pieces())
    place = _place(sweep_file.absolute(), template.absolute().parent)
    chunk = {"name": "Chunk", "type": "INT", "range": f"1-{count}"}
    sweep_parameter: dict[str, Any] = {
        "name": "SweepFile",
        "type": "PATH",
        "objectType": "FILE",
        "dataFlow": "IN",
        "description": "The sweep file",
    }
    if place is not None:
        # A scheduler refuses a default outside of the template's own folder.
        sweep_parameter["default"] = place
    return {
        "specificationVersion": "jobtemplate-2023-09",
        "name": work.sweep.name[:LONGEST_NAME],
        "description": f"swimlab sweep: {len(work.names)} configurations in {count} chunks",
        "parameterDefinitions": [
            sweep_parameter,
            {
                "name": "Out",
                "type": "PATH",
                "objectType": "DIRECTORY",
                "dataFlow": "INOUT",
                "description": "Folder of the results, seen by all machines",
            },
        ],
        "steps": [
            {
                "name": "Render",
                "parameterSpace": {"taskParameterDefinitions": [chunk]},
                "script": _script("--only", f"{{{{Task.Param.Chunk}}}}/{count}"),
            },
            {"name": "Measure", "dependencies": [{"dependsOn": "Render"}], "script": _script()},
        ],
    }


def _script(*words: str) -> dict[str, Any]:
    arguments = ["sweep", "{{Param.SweepFile}}", "-o", "{{Param.Out}}", *words, "--quiet"]
    return {"actions": {"onRun": {"command": "swimlab", "args": arguments}}}
