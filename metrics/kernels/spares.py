"""Launches that have run, kept to be laid out again for other inputs.

To lay out a launch takes tens of microseconds, of which most go into telling each input's kind and where it is in
memory: between two frames few of these change.
"""

from collections import deque
from collections.abc import Sequence
from typing import Any, NamedTuple

import warp as wp

from metrics.kernels.crew import Together
from metrics.kernels.host import HostLaunch

MOST_KERNELS, MOST_OF_ONE = 64, 16
"""Kernels of which launches are kept, and how many of each."""


class Spare(NamedTuple):
    """A launch on the host. of: what it was laid out for. owned: what each of its threads has alone, which it holds."""

    command: HostLaunch | Together
    of: Any
    owned: Sequence[Sequence[Any]]


class Spares:
    """Launches of which nobody else has one."""

    def __init__(self) -> None:
        self._kept, self._closed = dict[wp.Kernel, deque[Spare]](), False

    def again(self, kernel: wp.Kernel, of: Any, inputs: Sequence[Any]) -> Spare | None:
        """The one of this kernel that has waited longest, with these inputs; None where there is none.

        It must have been laid out for the same, or it is let go. Where inputs are refused it is lost.
        """
        try:
            spare = self._kept[kernel].popleft()
        except LookupError:
            return None
        if spare.of != of:
            return None
        spare.command.renew(inputs)
        return spare

    def keep(self, spare: Spare) -> None:
        """Keep one that has run, but not its inputs."""
        if self._closed:
            return
        spare.command.let_go()
        if len(self._kept) == MOST_KERNELS:
            self._kept.clear()
        self._kept.setdefault(spare.command.kernel, deque(maxlen=MOST_OF_ONE)).append(spare)

    def close(self) -> None:
        """Let all go, and keep none from now on."""
        self._closed = True
        self._kept.clear()
