"""In what two measurements differ beside their scores: settings, domain, frames, names, versions."""

from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any

from swimlab.runs.entries import Entry, flat
from swimlab.runs.record import REFERENCE, Record

VERSIONS = ("swimlab", "warp", "numpy", "python", "machine")
"""Parts of a provenance that may move a score with no setting changed."""

SHOWN_ELSEWHERE = ("viewing.", "display.")
"""Tables of a sequence that stand in the measured domain, as they were when measured."""


@dataclass(frozen=True)
class Difference:
    """Something that differs, in plain values. kind: "settings", or "versions" or "names", which leave runs
    comparable."""

    key: str
    before: Any
    after: Any
    kind: str = "settings"

    def concerns(self, technique: str) -> bool:
        """Whether a technique's scores may depend on it: its own settings, the reference's, and what is for all."""
        if self.kind != "settings":
            return False
        return concerns(self.key, technique) or concerns(self.key, REFERENCE)

    def __str__(self) -> str:
        between = "x" if self.key.endswith("size") else ", "
        return f"{self.key} {_words(self.before, between)} → {_words(self.after, between)}"


def concerns(key: str, technique: str) -> bool:
    """Whether a technique's pixels may depend on a key of the sequence: its own settings', and what is for all.

    Builds of a shot are techniques too.
    """
    table, _, rest = key.partition(".")
    return table not in ("techniques", "builds") or rest.partition(".")[0] == technique


def differences(before: Entry, after: Entry) -> list[Difference]:
    """What differs between two measurements of a sequence, settings first.

    Where the settings hashes differ for an unknown reason, the hash itself is listed.
    """
    found = [
        Difference(what, one, other)
        for what, one, other in (
            ("domain", before.settings.domain, after.settings.domain),
            ("frames measured", before.settings.extent, after.settings.extent),
        )
        if one != other
    ]
    names = [
        Difference(what, one, other, "names")
        for what, one, other in zip(("sequence", "technique"), before.key, after.key, strict=True)
        if one != other
    ]
    versions = [
        Difference(key, one, other, "versions")
        for key, one, other in _unlike(_versions(before), _versions(after))
        if one and other
    ]
    hashes = before.settings.hash, after.settings.hash
    if None in hashes:
        found.append(Difference("settings hash", *hashes))
    elif hashes[0] != hashes[1]:
        one, other = settings_of(before), settings_of(after)
        unlike = list(_unlike(one, other)) if one and other else []
        explained = unlike or any(each.key.endswith("swimlab") for each in versions)
        known = [Difference(key, *values) for key, *values in unlike if key != "name"]
        found += known if explained else [Difference("settings hash", *hashes)]
    return found + names + versions


def settings_of(entry: Entry) -> dict[str, Any]:
    """All settings of the rendering, or of frames that swimlab did not render, flat; empty where they are not known."""
    if entry.folder is None or "settings" in entry.provenance:
        return dict(flat(entry.provenance.get("settings", {})))
    record = Record.read(entry.folder)
    settings = dict(flat(record.sequence | record.settings))
    return {key: value for key, value in settings.items() if not key.startswith(SHOWN_ELSEWHERE)}


def _versions(entry: Entry) -> dict[str, Any]:
    rendering = entry.provenance.get("rendering", {})
    found = {key: entry.provenance.get(key) for key in VERSIONS}
    return found | {f"rendered with {key}": rendering.get(key) for key in VERSIONS if key in rendering}


def _unlike(one: dict[str, Any], other: dict[str, Any]) -> Iterator[tuple[str, Any, Any]]:
    for key in dict.fromkeys((*one, *other)):
        if one.get(key) != other.get(key):
            yield key, one.get(key), other.get(key)


def _words(value: Any, between: str) -> str:
    return "none" if value is None else between.join(map(str, value)) if isinstance(value, list) else str(value)
