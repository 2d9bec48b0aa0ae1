"""Every block of the documentation does what it says: files are saved, commands and Python run, page by page."""

import sys
from collections.abc import Iterator

import pytest
from doc_pages import NOT_RUN, Reader, blocks, pages

import swimlab.render.techniques
from swimlab.render import catalogue

PAGES = [page for page in pages() if any(True for _ in blocks(page))]


@pytest.fixture
def reader(tmp_path, monkeypatch) -> Iterator[Reader]:
    """Techniques that a page adds are gone afterwards."""
    path = swimlab.render.techniques.__path__
    modules = set(sys.modules)
    yield Reader(tmp_path, monkeypatch)
    swimlab.render.techniques.__path__ = path
    for name in {name for name in set(sys.modules) - modules if name.startswith("swimlab.render.techniques.")}:
        del sys.modules[name]
    catalogue.techniques.cache_clear()


@pytest.mark.parametrize("page", PAGES)
def test_a_reader_can_follow_the_page(reader, page):
    for block in blocks(page):
        reader.follow(block)


def test_most_blocks_are_run_and_the_others_say_why():
    every = [block for page in PAGES for block in blocks(page) if block.language == "sh"]
    left_out = [block for block in every if block.title.startswith(NOT_RUN)]
    assert all(len(block.title) > len(NOT_RUN) for block in left_out)
    assert len(left_out) < len(every) / 2


@pytest.mark.parametrize(
    ("text", "said"),
    [
        ("```sh\nswimlab list metrix\n```\n", "ends with 2"),
        ("```sh\nblender --version\n```\n", "no reader of the tests can do this"),
        ("```python\nassert 1 + 1 == 3\n```\n", None),
        ('```sh title="Not run in the tests: needs a cluster"\nswimlab sweep a.toml --motor dask\n```\n', "motor"),
        ('```sh\npip install ".[sauna]"\n```\n', "sauna"),
        ("```toml\nversion = 1\n```\n", "needs a title"),
    ],
)
def test_a_block_that_does_not_work_is_found(reader, monkeypatch, tmp_path, text, said):
    (tmp_path / "page.md").write_text(text, encoding="utf-8")
    monkeypatch.setattr("doc_pages.ROOT", tmp_path)
    (block,) = blocks("page.md")
    monkeypatch.undo()
    with pytest.raises(Exception, match=said):
        reader.follow(block)
