"""What the operating system says, and what containers allow."""

import os

import pytest

from metrics import machine


def groups(folder, own, files):
    """Files of control groups below a folder, and what says which group is the process's own."""
    for name, text in files.items():
        path = folder / "cgroup" / name
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_text(text, encoding="ascii")
    (folder / "own").write_text(own, encoding="ascii")
    return folder / "cgroup", folder / "own"


def first_version(group, quota):
    return {f"{group}/cpu.cfs_quota_us": quota, f"{group}/cpu.cfs_period_us": "100000"}


def test_waiting_for_a_core_is_summed_over_threads(tmp_path):
    for thread, nanoseconds in (("1", 2_000_000), ("2", 500_000_000)):
        (tmp_path / thread).mkdir()
        (tmp_path / thread / "schedstat").write_text(f"7 {nanoseconds} 3\n", encoding="ascii")
    (tmp_path / "3").mkdir()  # a thread that has ended
    assert machine.waited(tmp_path) == pytest.approx(0.502)
    assert machine.waited(tmp_path / "nothing") == 0.0
    assert machine.waited() >= 0.0


@pytest.mark.parametrize(
    ("own", "files", "allowed"),
    [
        ("0::/\n", {"cpu.max": "100000 100000\n"}, 1),
        ("0::/\n", {"cpu.max": "150000 100000\n"}, 2),
        ("0::/\n", {"cpu.max": "5000 100000\n"}, 1),
        ("0::/\n", {"cpu.max": "max 100000\n"}, None),
        ("0::/pod/box\n", {"pod/cpu.max": "200000 100000", "pod/box/cpu.max": "max 100000"}, 2),
        ("0::/pod/box\n", {"pod/cpu.max": "800000 100000", "pod/box/cpu.max": "300000 100000"}, 3),
        ("4:cpu,cpuacct:/box\n", first_version("cpu,cpuacct/box", "400000"), 4),
        ("4:cpu,cpuacct:/box\n", first_version("cpu,cpuacct/box", "-1"), None),
        ("4:cpu,cpuacct:/docker/a\n", first_version("cpu,cpuacct", "100000"), 1),
        ("3:memory:/box\n", {"memory/box/cpu.max": "100000 100000"}, None),
        ("", {}, None),
    ],
)
def test_a_container_bounds_the_cores(tmp_path, own, files, allowed):
    assert machine.quota(*groups(tmp_path, own, files)) == allowed


def test_the_least_bound_counts(monkeypatch):
    bounds = {"machine": 16, "affinity": 4, "container quota": 1}
    monkeypatch.setattr(machine, "core_limits", lambda: bounds)
    assert machine.cores() == 1
    monkeypatch.setattr(machine, "core_limits", lambda: bounds | {"container quota": None})
    assert machine.cores() == 4


@pytest.mark.may_skip("Windows and macOS have no affinity")
@pytest.mark.skipif(not hasattr(os, "sched_setaffinity"), reason="this system has no affinity")
def test_affinity_counts():
    before = os.sched_getaffinity(0)
    try:
        os.sched_setaffinity(0, {min(before)})
        assert machine.cores() == 1
    finally:
        os.sched_setaffinity(0, before)


def test_the_facts_are_plausible():
    assert 1 <= machine.cores() <= machine.core_limits()["machine"]
    assert 1e6 < machine.peak_memory() < machine.memory()
    assert 0 < machine.free_memory() <= machine.memory()
    assert machine.user()
    assert "/" not in machine.user()
    assert machine.process_exists(os.getpid())
    assert machine.processor()
