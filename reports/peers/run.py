"""Speed against peers: ours, and the same road in other renderers, in turns in one run.

    pip install moderngl numba drjit      # beside swimlab; Debian: libegl1 libgl1-mesa-dri libllvm19
    python reports/peers/run.py --size 1280x720 --rounds 7 --json peers.json

A peer that is not installed is left out, with the reason. Wall time is what a user waits; CPU time, of all threads of
this process, hardly changes when others use the machine. Ratios are medians over rounds of the two times of one round.
"""

import argparse
import importlib
import json
import os
import random
import time
from collections.abc import Iterator, Sequence
from dataclasses import replace
from pathlib import Path
from statistics import median, quantiles
from typing import Any, NamedTuple

from road import PITCH, Contender, ReferenceFrames, Road, road_sequence

import swimlab
from metrics.kernels.launch import Launcher
from metrics.machine import cores, processor, python, system
from swimlab.render.catalogue import techniques
from swimlab.render.kernels.texture_filter import FINEST, ISOTROPIC, TextureFilter, anisotropic_to
from swimlab.render.shot import Shot
from swimlab.render.technique import Picture, render_samples

PEERS = ("llvmpipe", "numba_road", "road_in_drjit")
OURS = (
    "pixel-point", "pixel-bilinear", "pixel-trilinear", "pixel-aniso", "toksvig", "vmf", "clean", "lean", "tsl",
    "reference",
)  # fmt: skip
FRAME = 3
WARM_UP = 2
ARGUMENTS = argparse.ArgumentParser(description="Speed against peers.")
ARGUMENTS.add_argument("--size", default="1280x720")
ARGUMENTS.add_argument("--rounds", type=int, default=7)
ARGUMENTS.add_argument("--threads", type=int, default=2)
ARGUMENTS.add_argument("--json", type=Path)


class Target(NamedTuple):
    """`this` is to take at most `limit` times as long as `that`, by the clock or by the time of all cores."""

    this: str
    that: str
    limit: float
    by: str = "cores"


TARGETS = (
    Target("pixel-aniso", "pixel-aniso, plain kernels", 0.6),
    Target("pixel-aniso", "llvmpipe aniso", 0.25),
    Target("pixel-trilinear", "llvmpipe trilinear", 1.0, by="clock"),
    Target("tsl", "llvmpipe tsl", 0.8),
    Target("reference", "drjit reference", 1.0),
    Target("toksvig", "pixel-aniso", 1.15),
    Target("vmf", "pixel-aniso", 1.15),
    Target("clean", "pixel-aniso", 1.25),
    Target("lean", "pixel-aniso", 1.25),
)
COMPARED = (
    ("pixel-point", "llvmpipe point"),
    ("pixel-bilinear", "llvmpipe bilinear"),
    ("pixel-aniso", "numba aniso"),
    ("reference", "numba reference"),
    ("pixel-trilinear", "pixel-trilinear, plain kernels"),
    ("reference", "reference, plain kernels"),
)
"""Pairs of which nothing is asked."""


def our(road: Road) -> Iterator[Contender]:
    """Our techniques, and those with native forms once more by the plain kernels."""
    drawn: list[Picture] = []

    def contender(label: str, render: Any, samples: int = 1) -> Contender:
        def draw(frame: int) -> None:
            drawn[:] = [render(road.shot(frame))]

        return Contender(label, draw, lambda: drawn[0].rgba, samples)

    for name in OURS:
        technique = techniques()[name]
        begun, settings = technique.begin(), technique.settings()
        samples = 64 if name == "reference" else 1
        yield contender(name, lambda shot, begun=begun, settings=settings: begun(shot, settings), samples)
    filters = {"pixel-trilinear": ISOTROPIC, "pixel-aniso": anisotropic_to(16), "reference": FINEST}
    for name, texture_filter in filters.items():
        n = 8 if name == "reference" else 1
        plain = TextureFilter(texture_filter.plain)

        def render(shot: Shot, plain: TextureFilter = plain, n: int = n) -> Picture:
            return render_samples(replace(shot, model=shot.model._replace(native=None)), plain, n=n, jittered=n > 1)

        yield contender(f"{name}, plain kernels", render, n * n)


def peers(road: Road) -> tuple[dict[str, str], list[Contender]]:
    """Versions, or why there is none, by module; and what the peers draw."""
    versions, found = {}, []
    for name in PEERS:
        try:
            versions[name], contenders = importlib.import_module(name).contenders(road)
            found += contenders
        except Exception as error:
            versions[name] = f"left out: {type(error).__name__}: {error}"
    return versions, found


def timed(contenders: Sequence[Contender], rounds: int) -> dict[str, list[tuple[float, float]]]:
    """Milliseconds of each contender in each round, of the wall clock and of the processors; in turns, shuffled."""
    times: dict[str, list[tuple[float, float]]] = {contender.label: [] for contender in contenders}
    order, shuffle = list(contenders), random.Random(0).shuffle
    for turn in range(rounds + WARM_UP):
        shuffle(order)
        for contender in order:
            wall, processors = time.perf_counter(), time.process_time()
            contender.draw(FRAME)
            spent = (time.perf_counter() - wall) * 1e3, (time.process_time() - processors) * 1e3
            if turn >= WARM_UP:
                times[contender.label].append(spent)
    return times


def spread(values: Sequence[float]) -> dict[str, float]:
    """Median and quartiles, to four digits."""
    low, _, high = quantiles(values, n=4, method="inclusive") if len(values) > 1 else (values[0],) * 3
    return {key: float(f"{x:.4g}") for key, x in (("median", median(values)), ("low", low), ("high", high))}


def ratios(times: dict[str, list[tuple[float, float]]], this: str, that: str) -> dict[str, Any] | None:
    """How many times as long one takes as the other; None where one of them was left out."""
    if this not in times or that not in times:
        return None
    pairs = list(zip(times[this], times[that], strict=True))
    return {"this": this, "that": that} | {
        key: spread([a[k] / b[k] for a, b in pairs]) for k, key in enumerate(("wall", "cpu"))
    }


def targets(times: dict[str, list[tuple[float, float]]]) -> list[dict[str, Any]]:
    """The ratios that something is asked of, with what is asked."""
    found = [(target, ratios(times, target.this, target.that)) for target in TARGETS]
    return [ratio | {"limit": target.limit, "by": target.by} for target, ratio in found if ratio]


def rates(times: Sequence[tuple[float, float]], samples: float, threads: int) -> dict[str, Any]:
    """Million samples a second: by the wall clock, and if all threads had a processor of their own."""
    by_clock, by_cpu = ([samples / 1e3 / each[k] * (threads if k else 1) for each in times] for k in (0, 1))
    return {"wall": spread(by_clock), "cpu": spread(by_cpu)}


def processors() -> tuple[float, float]:
    """Seconds that the machine's processors were busy since its start, and those of this process."""
    ticks = [int(x) for x in Path("/proc/stat").read_text().split("\n", 1)[0].split()[1:9]]
    idle, waiting = ticks[3:5]
    return (sum(ticks) - idle - waiting) / os.sysconf("SC_CLK_TCK"), time.process_time()


def machine() -> str:
    """Processor and how many of them."""
    return f"{processor()}, {cores()} cores, {system()}"


def compare(size: tuple[int, int], rounds: int, threads: int) -> dict[str, Any]:
    """The whole comparison."""
    with Launcher(threads=threads) as launcher:
        road = Road(road_sequence(size), launcher)
        truth = ReferenceFrames.of(road, FRAME)
        versions, found = peers(road)
        contenders = [*our(road), *found]
        begun, (busy, mine) = time.perf_counter(), processors()
        times = timed(contenders, rounds)
        took, (busy_then, mine_then) = time.perf_counter() - begun, processors()
        results = {}
        for contender in contenders:
            contender.draw(FRAME)
            picture = contender.read()
            each = times[contender.label]
            results[contender.label] = {
                "ms": spread([wall for wall, _ in each]),
                "cpu_ms": spread([cpu for _, cpu in each]),
                "rms": float(f"{truth.rms(picture):.4g}"),
            }
            if contender.samples > 1:
                shaded = float(picture[..., 3].sum(dtype=float)) * contender.samples
                results[contender.label]["million_samples_a_second"] = rates(each, shaded, threads)
    return {
        "machine": machine(),
        "versions": {"swimlab": swimlab.__version__, "python": python()} | versions,
        "settings": {"size": size, "rounds": rounds, "threads": threads, "pitch": PITCH, "frame": FRAME},
        "others": max(0.0, (busy_then - busy - mine_then + mine) / took),
        "covered": float((truth.picture[..., 3] > 0).mean()),
        "truth_error": truth.floor,
        "results": results,
        "targets": targets(times),
        "ratios": [ratio for pair in COMPARED if (ratio := ratios(times, *pair))],
    }


def show(report: dict[str, Any]) -> None:
    """Print the tables."""
    print(report["machine"], *(f"{name} {version}" for name, version in report["versions"].items()), sep="; ")
    width, height = report["settings"]["size"]
    print(f"{width}x{height}, the road covers {report['covered']:.1%}; camera pitch {report['settings']['pitch']}")
    print(f"others kept {report['others']:.2f} processors busy")
    print(f"\n{'':32}{'ms':>8}{'quartiles':>16}{'CPU ms':>9}{'rms error':>11}{'Msample/s':>11}{'by CPU':>8}")
    for label, row in report["results"].items():
        ms, rate = row["ms"], row.get("million_samples_a_second")
        quartiles = f"{ms['low']:.1f}..{ms['high']:.1f}"
        print(
            f"{label:32}{ms['median']:8.1f}{quartiles:>16}{row['cpu_ms']['median']:9.1f}{row['rms']:11.4f}"
            + (f"{rate['wall']['median']:11.0f}{rate['cpu']['median']:8.0f}" if rate else "")
        )
    for title in ("targets", "ratios"):
        print(f"\n{title:48}{'by the clock':>14}{'quartiles':>14}{'by cores':>10}{'quartiles':>14}{'limit':>7}")
        for ratio in report[title]:
            cells = [f"{ratio['this']} / {ratio['that']:{44 - len(ratio['this'])}}"]
            for key, wide in (("wall", 15), ("cpu", 10)):
                low, high = ratio[key]["low"], ratio[key]["high"]
                quartiles = f"{low:.3f}..{high:.3f}"
                cells.append(f"{ratio[key]['median']:{wide}.3f}{quartiles:>14}")
            if title == "targets":
                met = ratio["wall" if ratio["by"] == "clock" else "cpu"]["median"] <= ratio["limit"]
                cells.append(f"{ratio['limit']:7g}  {'met' if met else 'NOT MET'} by the {ratio['by']}")
            print(*cells, sep="")
    print("\nRates by CPU count as if all threads had a processor of their own.")


if __name__ == "__main__":
    given = ARGUMENTS.parse_args()
    columns, rows = map(int, given.size.split("x"))
    made = compare((columns, rows), given.rounds, given.threads)
    if given.json:
        given.json.write_text(json.dumps(made, indent=1) + "\n")
    show(made)
