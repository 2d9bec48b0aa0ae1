"""The costs of techniques in the terminal."""

from rich.table import Table

from swimlab.cli.terminal import print_whole
from swimlab.runs.provenance import provenance
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
        f"Medians of a frame, mesh and set-up included, files not, over {costs.rounds} rounds in turns. At the least: "
        f"{costs.rates.read_ns:.2f} ns a texel read, {costs.rates.shade_ns:.1f} ns an evaluation of the model."
    )
    print_whole(table)
    serial = Table("serial share", title="One thread against two", box=None)
    for heading in ("size", "1 thread, ms", "2 threads, ms", "share", "quartiles", "outside kernels", "cores busy"):
        serial.add_column(heading, justify="right")
    for each in costs.serial:
        low, high = each.quartiles
        outside = "–" if each.outside is None else f"{each.outside:.0%}"
        cells = [f"{each.one_ms:.1f}", f"{each.two_ms:.1f}", f"{each.share:.0%}", f"{low:.0%} to {high:.0%}"]
        serial.add_row(each.what, "{}x{}".format(*each.size), *cells, outside, f"{each.busy:.2f}")
    serial.caption_justify = "left"
    serial.caption = (
        "Share: of the work, by the clock, what a second thread does not shorten (Amdahl); it means nothing while "
        "other programs run. Outside kernels: of the time of one core, which is the most that is serial."
    )
    print_whole(serial)


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
