"""Scores as a table that a notebook shows, and as plain values."""

from collections.abc import Iterator, Mapping, Sequence
from html import escape
from typing import Any

from swimlab.runs.columns import COLUMNS
from swimlab.scoring.resolution import LEGEND, MARK, unresolved

Row = dict[str, float]


class Scores(Mapping[str, Row]):
    """Technique -> heading -> value, as the table shows it: `scores["tsl"]["flicker"]`.

    Radiance is rms, the root of the score of that name in scores.json; `to_dict` has the scores themselves. A score
    that is not available is not there, and `absent` says why.
    """

    def __init__(self, entries: Sequence[Mapping[str, Any]]) -> None:
        """entries: the entries of scores.json of one sequence."""
        self._entries = {str(entry["technique"]): entry for entry in entries}
        self._shown = {h: c for h, c in COLUMNS.items() if any(c[0] in entry["scores"] for entry in entries)}
        self._unresolved = {heading: unresolved(entries, name) for heading, (name, _) in self._shown.items()}

    def __getitem__(self, technique: str) -> Row:
        """A row. Raises KeyError naming the techniques that there are."""
        if technique not in self._entries:
            raise KeyError(f"no scores of {technique!r}; there are {', '.join(self._entries)}")
        scores = self._entries[technique]["scores"]
        return {h: float(show(scores[name])) for h, (name, show) in self._shown.items() if name in scores}

    def __iter__(self) -> Iterator[str]:
        return iter(self._entries)

    def __len__(self) -> int:
        return len(self._entries)

    @property
    def rows(self) -> list[dict[str, Any]]:
        """One dictionary a technique, with its name first: what pandas.DataFrame takes."""
        return [{"technique": name, **row} for name, row in self.items()]

    @property
    def absent(self) -> dict[str, dict[str, str]]:
        """Technique -> score -> why it is not available."""
        return {name: dict(entry["absent"]) for name, entry in self._entries.items()}

    def to_dict(self) -> dict[str, dict[str, float]]:
        """Technique -> score by its name in scores.json (`swimlab list metrics`), in that score's unit."""
        return {name: dict(entry["scores"]) for name, entry in self._entries.items()}

    def __repr__(self) -> str:
        table = [["technique", *self._shown], *([name, *self._cells(name)] for name in self)]
        widths = [max(map(len, column)) for column in zip(*table, strict=True)]
        lines = ["  ".join([row[0].ljust(widths[0]), *map(str.rjust, row[1:], widths[1:])]).rstrip() for row in table]
        return "\n".join([*lines, *self._legend()])

    def _repr_html_(self) -> str:
        head = "".join(f"<th>{escape(heading)}</th>" for heading in ("technique", *self._shown))
        body = "".join(
            f'<tr><th style="text-align:left">{escape(name)}</th>'
            + "".join(f'<td style="text-align:right">{cell}</td>' for cell in self._cells(name))
            + "</tr>"
            for name in self
        )
        legend = "".join(f"<p><small>{escape(line)}</small></p>" for line in self._legend())
        return f"<table><thead><tr>{head}</tr></thead><tbody>{body}</tbody></table>{legend}"

    def _cells(self, technique: str) -> list[str]:
        row = self[technique]
        return [
            (MARK if technique in self._unresolved[heading] else "") + f"{row[heading]:.3f}" if heading in row else "-"
            for heading in self._shown
        ]

    def _legend(self) -> list[str]:
        return [LEGEND] if any(self._unresolved.values()) else []
