"""The outcome of a gate as JUnit XML, which CI servers show as tests."""

import re
from pathlib import Path
from xml.etree import ElementTree

from swimlab.gate.outcome import Outcome
from swimlab.gate.table import explain, number, of_base

ILLEGAL = re.compile("[^\t\n\r\u0020-\ud7ff\ue000-\ufffd\U00010000-\U0010ffff]")
"""Characters that XML 1.0 cannot hold."""


def junit(outcome: Outcome) -> str:
    """A test suite with a test case a score: what is beyond its limit is a failure, what cannot be judged an error."""
    failures = sum(check.status == "fail" for check in outcome.checks)
    errors = sum(check.status == "unjudged" for check in outcome.checks)
    counts = {"tests": str(len(outcome.checks)), "failures": str(failures), "errors": str(errors)}
    root = ElementTree.Element("testsuites", counts)
    suite = ElementTree.SubElement(root, "testsuite", {"name": _clean(str(outcome.gate)), **counts})
    for check in outcome.checks:
        case = ElementTree.SubElement(
            suite,
            "testcase",
            {"classname": _clean(f"{check.sequence}.{check.technique}"), "name": _clean(check.metric)},
        )
        why = _clean(explain(check))
        tag = {"fail": "failure", "unjudged": "error"}.get(check.status)
        if tag:
            ElementTree.SubElement(case, tag, {"message": why}).text = why
        base, sigma = of_base(check)
        said = f"value {number(check.value)}, limit {check.limit or '-'}, baseline {base}, sigma {sigma}"
        ElementTree.SubElement(case, "system-out").text = _clean(
            f"{check.status}: {said}" + (f"\n{why}" if why else "")
        )
    ElementTree.indent(root)
    return ElementTree.tostring(root, encoding="unicode", xml_declaration=True) + "\n"


def junit_error(gate: Path, message: str) -> str:
    """A test suite with one error, for a gate that could not be run."""
    counts = {"tests": "1", "failures": "0", "errors": "1"}
    root = ElementTree.Element("testsuites", counts)
    suite = ElementTree.SubElement(root, "testsuite", {"name": _clean(str(gate)), **counts})
    case = ElementTree.SubElement(suite, "testcase", {"classname": "swimlab", "name": "gate"})
    ElementTree.SubElement(case, "error", {"message": _clean(message)}).text = _clean(message)
    ElementTree.indent(root)
    return ElementTree.tostring(root, encoding="unicode", xml_declaration=True) + "\n"


def _clean(text: str) -> str:
    return ILLEGAL.sub("?", text)
