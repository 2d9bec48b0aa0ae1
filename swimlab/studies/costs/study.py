"""The cost of every technique and setting: in turns, by kernel, beside kernels, and against the least."""

from collections.abc import Callable, Mapping
from dataclasses import asdict, dataclass
from statistics import median, quantiles
from typing import Any

from sequences import Sequence as Scenery
from swimlab.render.catalogue import model_of, techniques
from swimlab.render.inputs import BOX
from swimlab.render.material import load_material
from swimlab.runs.provenance import provenance
from swimlab.runs.record import REFERENCE
from swimlab.studies.costs.serial import Serial, serial_study
from swimlab.studies.costs.watched import WatchedLauncher, watched_frames
from swimlab.studies.costs.work import Rates, Sight, measured_rates, reads_of
from swimlab.studies.speed.settings import SEVERAL
from swimlab.studies.trials import Stage, Variant
from swimlab.studies.turns import Time, cpu, in_turns, wall

AGAINST = "pixel-aniso"
"""What ratios are to."""
SAMPLES = 64
"""Samples a pixel of the reference by default, as `render` has it."""
STEPS = 4
"""How often `advance` is called, with the serial study."""


@dataclass(frozen=True)
class Row:
    """A technique under some settings: medians of a frame that follows one of the same, mesh and set-up included.

    cpu_ms: of all cores, with quartiles. wall_ms: by the clock. kernels: ms of all cores by kernel. outside_ms: what no
    kernel spent. ratio: of cpu_ms to `pixel-aniso`'s. shaded: evaluations of the model. reads: texels that must be
    read, and bytes of them; None where that is not known. least_ms: what these cost at the measured rates.
    On a GPU times of all cores are the clock's.
    """

    label: str
    technique: str
    settings: Mapping[str, Any]
    cpu_ms: float
    quartiles: tuple[float, float]
    wall_ms: float
    kernels: Mapping[str, float]
    outside_ms: float
    ratio: float
    shaded: int
    reads: int | None
    bytes: int | None
    least_ms: float | None


@dataclass(frozen=True)
class Costs:
    """All rows, the rates that `least_ms` is made of, and the serial shares."""

    sequence: str
    size: tuple[int, int]
    threads: int
    device: str
    rounds: int
    rates: Rates
    rows: list[Row]
    serial: list[Serial]

    def as_json(self, command: str) -> dict[str, Any]:
        """Plain values, with their provenance."""
        plain = asdict(self)
        for held, serial in zip(plain["serial"], self.serial, strict=True):
            held |= {"share": serial.share, "quartiles": serial.quartiles}
            held |= {"own_share": serial.own_share, "own_quartiles": serial.own_quartiles}
        return {"provenance": provenance(command)} | plain


def candidates() -> list[tuple[Variant, int]]:
    """Every technique at its defaults under its own name, and the settings of `speed-error` that differ from them.

    With the reference's samples a pixel.
    """
    known = techniques()
    chosen = [(Variant(name, name), SAMPLES) for name in known]
    held = {(name, str(known[name].settings()), SAMPLES) for name in known}
    for each in SEVERAL:
        variant, samples = each.variant, each.samples or SAMPLES
        settings = str(known[variant.technique].settings.model_validate(dict(variant.settings)))
        same = (variant.technique, settings, samples if variant.technique == REFERENCE else SAMPLES)
        if same not in held:
            chosen.append((variant, samples))
            held.add(same)
    return chosen


def cost_study(
    sequence: Scenery,
    *,
    rounds: int,
    threads: int | None = None,
    device: str = "cpu",
    only: Callable[[Variant], bool] = lambda _: True,
    serial: Callable[..., list[Serial]] = serial_study,
    advance: Callable[[str], None] = lambda _: None,
) -> Costs:
    """Time every technique and setting in turns, `only` those wanted, and then what is serial.

    The serial shares are of the CPU. `advance` is called STEPS times with what is done.
    """
    tried = [(variant, samples) for variant, samples in candidates() if only(variant)]
    with WatchedLauncher(threads=threads, device=device) as launcher:
        material = load_material(sequence, launcher, twisted=model_of(sequence).anisotropic)
        used = launcher.threads
        stages = {
            samples: Stage(sequence, [0], samples=samples, launcher=launcher, material=material)
            for samples in {samples for _, samples in tried}
        }
        shot = next(iter(stages.values())).shot(0)
        rates = measured_rates(shot, rounds=5 * rounds)
        advance("rates")
        watched = {variant.label: watched_frames(stages[samples], variant, launcher) for variant, samples in tried}
        times = in_turns({label: task for label, (task, _) in watched.items()}, rounds)
        advance("techniques")
        rows = []
        sight, texel = Sight(shot), 4 * material.chain(BOX).floats
        for variant, _ in tried:
            settings = techniques()[variant.technique].settings.model_validate(dict(variant.settings))
            frames = watched[variant.label][1]
            count = frames[-1].shaded
            reads = reads_of(variant, settings, sight, count)
            spent = _spent(times[variant.label], [frame.kernels for frame in frames[1:]], on_cpu=device == "cpu")
            rows.append(
                Row(
                    label=variant.label,
                    technique=variant.technique,
                    settings=settings.model_dump(),
                    **spent,
                    ratio=0.0,
                    shaded=count,
                    reads=reads,
                    bytes=None if reads is None else reads * texel,
                    least_ms=None if reads is None else rates.least_ms(reads, count),
                )
            )
    shares = serial(sequence, rounds=rounds, advance=advance)
    return Costs(sequence.name, sequence.size, used, device, rounds, rates, with_ratios(rows), shares)


def _spent(times: list[Time], kernels: list[Mapping[str, float]], *, on_cpu: bool) -> dict[str, Any]:
    """The times of a row; kernels: of each round."""
    clocked = times if on_cpu else [Time(each.wall, each.wall) for each in times]
    names = sorted({name for each in kernels for name in each})
    outside = [time.cpu - sum(each.values()) for time, each in zip(clocked, kernels, strict=True)]
    of_all = [time.cpu for time in clocked]
    low, _, high = quantiles(of_all, n=4) if len(of_all) > 1 else of_all * 3
    return {
        "cpu_ms": cpu(clocked),
        "quartiles": (low, high),
        "wall_ms": wall(clocked),
        "kernels": {name: median(each.get(name, 0.0) for each in kernels) for name in names},
        "outside_ms": median(outside),
    }


def with_ratios(rows: list[Row]) -> list[Row]:
    """Rows with their ratio to `pixel-aniso`'s, which must be among them."""
    base = next(row.cpu_ms for row in rows if row.label == AGAINST)
    return [Row(**{**vars(row), "ratio": row.cpu_ms / base}) for row in rows]
