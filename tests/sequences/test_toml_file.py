"""TOML files as tools on other systems write them."""

from pathlib import Path

from sequences.toml_file import read_toml


def test_a_byte_order_mark_and_crlf_are_read(tmp_path: Path) -> None:
    file = tmp_path / "a.toml"
    file.write_bytes(b"\xef\xbb\xbfversion = 1\r\n[a]\r\nb = 2\r\n")
    assert read_toml(file, syntax="", unreadable="") == {"version": 1, "a": {"b": 2}}
