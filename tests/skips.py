"""Where $SWIMLAB_NO_SKIPS is set, as in CI, a skipped test fails unless its marker `may_skip` says why it may be."""

import os
from collections.abc import Generator

import pytest


@pytest.hookimpl(wrapper=True)
def pytest_runtest_makereport(item: pytest.Item) -> Generator[None, pytest.TestReport, pytest.TestReport]:
    """The report of a test, failed where it was skipped and must not be."""
    report = yield
    skipped = report.skipped and not hasattr(report, "wasxfail")
    if skipped and os.environ.get("SWIMLAB_NO_SKIPS") and item.get_closest_marker("may_skip") is None:
        report.outcome = "failed"
        report.longrepr = f"skipped in CI without the marker may_skip: {report.longrepr}"
    return report
