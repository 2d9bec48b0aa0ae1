"""The commit that the working folder stands at, according to git."""

import subprocess
from dataclasses import dataclass
from pathlib import Path

NONE = "nogit"
DIGITS = 12


@dataclass(frozen=True)
class Commit:
    """A commit. name: of 40 digits, or "nogit" outside of a repository. dirty: tracked files differ from it."""

    name: str
    dirty: bool

    def __str__(self) -> str:
        return self.name[:DIGITS] + ("_uncommitted-changes" if self.dirty else "")


def commit_of(folder: Path) -> Commit:
    """The commit of the repository that the folder lies in; "nogit" without git, repository or commit."""
    command = ["git", "-C", str(folder), "describe", "--always", "--dirty", "--abbrev=40", "--exclude=*"]
    try:
        said = subprocess.run(command, capture_output=True, text=True, check=True).stdout.strip()
    except (OSError, subprocess.CalledProcessError):
        return Commit(NONE, dirty=False)
    return Commit(said.removesuffix("-dirty"), dirty=said.endswith("-dirty"))
