"""The machine: its cores, memory, user and system. Nothing else asks the operating system."""

import platform
import re
import sys
from math import ceil
from pathlib import Path

import psutil

CGROUPS = Path("/sys/fs/cgroup")
OWN_CGROUP = Path("/proc/self/cgroup")
CPUINFO = Path("/proc/cpuinfo")
OWN_THREADS = Path("/proc/self/task")


def cores() -> int:
    """Cores that this process may use, by its affinity and its container's quota; at least 1."""
    return max(1, min(by for by in core_limits().values() if by is not None))


def core_limits() -> dict[str, int | None]:
    """What bounds the cores: "machine", "affinity" and "container quota"; None where there is no such bound."""
    machine = psutil.cpu_count() or 1
    try:
        allowed = len(psutil.Process().cpu_affinity())
    except AttributeError:  # macOS has no affinity
        allowed = None
    return {"machine": machine, "affinity": allowed, "container quota": quota()}


def quota(cgroups: Path = CGROUPS, own: Path = OWN_CGROUP) -> int | None:
    """Cores that the control groups of this process allow, rounded up; None without a limit.

    Both versions are read, and every group above the process's own: the least counts.
    Source: Linux, Documentation/admin-guide/cgroup-v2.rst (cpu.max) and scheduler/sched-bwc.rst (cfs_quota_us).
    """
    allowed = []
    for line in _text(own).splitlines():
        _, controllers, path = line.split(":", 2)
        mounts = ["", "unified"] if not controllers else [controllers] if "cpu" in controllers.split(",") else []
        for mount in mounts:
            root = cgroups / mount
            group = root / path.lstrip("/")
            for folder in [group, *group.parents]:
                if folder == root.parent:
                    break
                allowed += _quota_of(folder)
    return max(1, ceil(min(allowed))) if allowed else None


def _quota_of(group: Path) -> list[float]:
    limit, _, period = (_text(group / "cpu.max").strip() or "max").partition(" ")
    if limit == "max":
        limit, period = _text(group / "cpu.cfs_quota_us").strip(), _text(group / "cpu.cfs_period_us").strip()
    return [float(limit) / float(period)] if limit and period and float(limit) > 0 else []


def _text(path: Path) -> str:
    try:
        return path.read_text(encoding="utf-8", errors="surrogateescape")
    except OSError:
        return ""


def waited(threads: Path = OWN_THREADS) -> float:
    """Seconds that the threads of this process were ready to run and had no core; 0 where the system does not say.

    Source: Linux, Documentation/scheduler/sched-stats.rst (schedstat, second field).
    """
    fields = [_text(thread / "schedstat").split() for thread in threads.glob("*")]
    return 1e-9 * sum(int(each[1]) for each in fields if len(each) > 1)


def peak_memory() -> int:
    """Bytes that this process has held at most; what it holds now where the system does not keep the peak."""
    try:
        import resource  # not on Windows
    except ImportError:
        used = psutil.Process().memory_info()
        return int(getattr(used, "peak_wset", used.rss))
    peak = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
    return peak if sys.platform == "darwin" else 1024 * peak


def memory() -> int:
    """Bytes of memory of the machine."""
    return int(psutil.virtual_memory().total)


def free_memory() -> int:
    """Bytes of memory that are available without swapping."""
    return int(psutil.virtual_memory().available)


def user() -> str:
    """The user's name, fit for a file's name."""
    return re.sub(r"\W+", "-", psutil.Process().username())


def system() -> str:
    """Operating system and processor, as "Linux x86_64"."""
    return f"{platform.system()} {platform.machine()}"


def processor() -> str:
    """The processor's name; the kind of processor where the system does not name it."""
    names = (line.split(":", 1)[1].strip() for line in _text(CPUINFO).splitlines() if line.startswith("model name"))
    return next(names, platform.processor() or platform.machine())


def python() -> str:
    """Version of Python, as "3.12.4"."""
    return platform.python_version()


def process_exists(number: int) -> bool:
    """Whether a process of this number runs on this machine."""
    return bool(psutil.pid_exists(number))
