"""In what a measurement differs from the baseline, beyond that two settings hashes are not the same."""

from typing import Any

from swimlab.runs.differences import Difference, settings_of
from swimlab.runs.entries import Entry, Settings
from swimlab.runs.record import Record

LISTED = 6
"""Differences that are listed; of more, how many there are."""


def hashed(entry: Entry) -> dict[str, Any]:
    """What an entry's settings hash is made of, flat; empty where neither a run folder nor the scores tell.

    The bytes of map files, which are hashed as well, are left out.
    """
    found = settings_of(entry)
    if found and entry.folder is not None and "settings" not in entry.provenance:
        return {"swimlab": Record.read(entry.folder).provenance.get("swimlab"), **found}
    return found


def difference(entry: Entry, base: Settings, of_base: dict[str, Any]) -> str:
    """In what an entry's settings differ from those of the baseline, in words; empty where they agree.

    of_base: what the baseline's hash is made of, as `hashed` gives. Where that is not known of both, the hashes
    themselves are named.
    """
    plain = entry.settings.difference(base)
    if entry.settings.hash in (None, base.hash):
        return plain
    of = hashed(entry)
    if not of or not of_base:
        return plain
    keys = [key for key in dict.fromkeys((*of_base, *of)) if of.get(key) != of_base.get(key)]
    if not keys:
        return f"{plain}, though all settings agree: a map file has changed"
    named = [str(Difference(key, of_base.get(key), of.get(key))) for key in keys[:LISTED]]
    return ", ".join(named) + (f" and {len(keys) - LISTED} more" if keys[LISTED:] else "")
