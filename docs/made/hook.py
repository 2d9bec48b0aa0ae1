"""What MkDocs calls: pages and pictures that are made when the site is built, beside the written ones."""

from typing import Any

import catalogue
import commands
import keys
import pictures
import repository
import scores
from mkdocs.config.defaults import MkDocsConfig
from mkdocs.structure.files import File, Files


def on_config(config: MkDocsConfig) -> MkDocsConfig:
    """Name every report under Results."""
    nav: list[dict[str, Any]] = config.nav or []
    for entry in nav:
        if "Results" in entry:
            entry["Results"] = [page for page in repository.pages().values() if page.startswith("results/")]
    return config


def on_files(files: Files, config: MkDocsConfig) -> Files:
    """Add the pages of the reference, the pictures of the concepts, and pages and pictures of the repository."""
    made: dict[str, str | bytes] = {
        "reference/commands.md": commands.page(),
        "reference/catalogue.md": catalogue.page(),
        "reference/scores.md": scores.page(),
        **{f"reference/{kind}-file.md": keys.page(kind) for kind in keys.KINDS},
        **repository.contents(),
        **pictures.drawn(),
    }
    for path, content in made.items():
        files.append(File.generated(config, path, content=content))
    return files
