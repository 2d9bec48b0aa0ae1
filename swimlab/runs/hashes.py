"""Hashes of settings and of files."""

import hashlib
import json
from pathlib import Path
from typing import Any


def hash_of(content: Any) -> str:
    """A hash of what JSON can hold, whatever the order of keys; 16 hexadecimal digits."""
    return hashlib.sha256(json.dumps(content, sort_keys=True).encode()).hexdigest()[:16]


def hash_file(path: Path) -> str:
    """SHA-256 of a file's bytes, 64 hexadecimal digits. Raises OSError where it cannot be read."""
    with path.open("rb") as file:
        return hashlib.file_digest(file, "sha256").hexdigest()
