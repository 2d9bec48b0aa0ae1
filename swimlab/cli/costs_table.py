"""The costs of techniques in the terminal."""

from rich.table import Table

from swimlab.cli.terminal import print_whole
from swimlab.runs.provenance import provenance
from swimlab.studies.costs.serial import Serial
from swimlab.studies.costs.study import Costs, Row


def print_costs(costs: Costs) -> None:
    """Print a row for each technique and setting, cheapest first, and the serial shares."""
    size = "{}x{}".format(*costs.size)
    title = f"{costs.sequence}, {size}, {costs.threads} threads, {costs.device}, {provenance('')['machine']}"
    table = Table("technique", title=title, box=None)
    for heading in ("ms of all cores", "quartiles", "ratio", "outside kernels", "at the least", "shaded", "MB read"):
        table.add_column(heading, justify="right")
    table.add_column("by kernel, ms")
    for row in sorted(costs.rows, key=lambda row: row.cpu_ms):
        table.add_row(*_cells(row))
    table.caption_justify = "left"
    table.caption = (
        "Medians of a frame that follows one of the same technique, mesh and set-up included, files not, over "
        f"{costs.rounds} rounds in turns. At the least: "
        f"{costs.rates.read_ns:.2f} ns a texel read, {costs.rates.shade_ns:.1f} ns an evaluation of the model."
    )
    print_whole(table)
    serial = Table("serial share", title="One thread against two", box=None)
    for heading in ("size", "1 thread, ms", "2 threads, ms", "by the clock", "quartiles"):
        serial.add_column(heading, justify="right")
    for heading in ("the program's", "quartiles", "kernels alone", "outside kernels", "cores busy"):
        serial.add_column(heading, justify="right")
    for each in costs.serial:
        serial.add_row(*_serial_cells(each))
    serial.caption_justify = "left"
    serial.caption = (
        "By the clock: of the work, what a second thread does not shorten (Amdahl). The program's share of that: what "
        "is done while the other thread has nothing to do (at most, where threads come and go, as it is not known how "
        "long they waited for a core); with a share of s expect 1/(s + (1 - s)/n) times the speed "
        "on n cores, if the machine gives as much. Kernels alone: how many times as fast the machine runs the same "
        "kernels on two threads, with nothing of the program between. Outside kernels: of the time of one core. "
        "Shares by the clock mean nothing while other programs run, the program's share little."
    )
    print_whole(serial)


def _serial_cells(each: Serial) -> list[str]:
    return [
        each.what,
        "{}x{}".format(*each.size),
        f"{each.one_ms:.1f}",
        f"{each.two_ms:.1f}",
        f"{each.share:.0%}",
        "{:.0%} to {:.0%}".format(*each.quartiles),
        f"{'at most ' if each.outside is None else ''}{each.own_share:.0%}",
        "{:.0%} to {:.0%}".format(*each.own_quartiles),
        "–" if each.gain is None else f"{each.gain:.2f}",
        "–" if each.outside is None else f"{each.outside:.0%}",
        f"{each.busy:.2f}",
    ]


def _cells(row: Row) -> list[str]:
    low, high = row.quartiles
    kernels = sorted(row.kernels.items(), key=lambda item: -item[1])
    return [
        row.label,
        f"{row.cpu_ms:.2f}",
        f"{low:.2f} to {high:.2f}",
        f"{row.ratio:.2f}",
        f"{row.outside_ms:.2f}",
        "–" if row.least_ms is None else f"{row.least_ms:.2f}",
        f"{row.shaded:,}",
        "–" if row.bytes is None else f"{row.bytes / 1e6:.0f}",
        ", ".join(f"{name} {ms:.2f}" for name, ms in kernels),
    ]
