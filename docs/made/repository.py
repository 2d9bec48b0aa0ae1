"""Pages that stand in the repository and are read on the site too: reports, engines, changes, contributing."""

import posixpath
import re
from pathlib import Path

ROOT = Path(__file__).parents[2]
LINK = re.compile(r"(!?)\[((?:[^\[\]]|\[[^\]]*\])*)\]\(([^)\s]+)\)")


def pages() -> dict[str, str]:
    """Path in the repository -> path on the site, of every page."""
    found = {"CHANGELOG.md": "changelog.md", "CONTRIBUTING.md": "contributing.md"}
    for path in sorted((ROOT / "reports").glob("*.md")):
        found[f"reports/{path.name}"] = f"results/{path.name}"
    engines = ROOT / "reports" / "engines"
    for path in sorted([*engines.glob("*.md"), *engines.glob("*/README.md")]):
        inner = path.relative_to(engines).as_posix()
        name = "index" if inner == "README.md" else inner.removesuffix("/README.md").removesuffix(".md")
        found[f"reports/engines/{inner}"] = f"guides/engines/{name}.md"
    return found


def pictures() -> dict[str, str]:
    """The same of pictures."""
    reports = ROOT / "reports"
    found = [*reports.glob("*.png"), *reports.glob("*/*.png"), *reports.glob("*/*.svg")]
    inner = [path.relative_to(reports).as_posix() for path in sorted(found)]
    return {f"reports/{name}": f"results/{name}" for name in inner}


def contents() -> dict[str, str | bytes]:
    """What all of them hold, by their paths on the site."""
    places = pages() | pictures()
    texts = {to: on_site((ROOT / of).read_text(encoding="utf-8"), of, places) for of, to in pages().items()}
    return texts | {to: (ROOT / of).read_bytes() for of, to in pictures().items()}


def on_site(text: str, home: str, places: dict[str, str]) -> str:
    """A page's text with links to other pages of the site; a link to what is not on the site becomes its text.

    home: the page's path in the repository.
    """

    def link(found: re.Match[str]) -> str:
        mark, words, target = found.groups()
        file, hash_mark, anchor = target.partition("#")
        if not file or ":" in file:
            return found[0]
        there = posixpath.normpath(posixpath.join(posixpath.dirname(home), file))
        there = next((place for place in (there, f"{there}/README.md") if place in places), "")
        if not there:
            return words if not mark else ""
        to = posixpath.relpath(places[there], posixpath.dirname(places[home]) or ".")
        return f"{mark}[{words}]({to}{hash_mark}{anchor})"

    return LINK.sub(link, text)
