"""Files of depth, by which scores of anyone's frames are split into bands."""

from typing import Any

import numpy as np
from numpy.typing import NDArray

from swimlab.footage.channels import find_parts
from swimlab.footage.reader import Reader
from swimlab.footage.request import Request
from swimlab.footage.source import Box
from swimlab.runs.frames import FrameError

NAMES = ("Depth.Z", "depth.Z", "Z", "Depth.V", "depth.V", "V", "Depth", "depth")
"""What a channel of depth is called, by itself or in a layer."""


class Depth:
    """Depth by index, m; 0 where there is none."""

    def __init__(self, reader: Reader, request: Request) -> None:
        """Raises FrameError where it is not plain which channel is the depth."""
        self.reader = reader
        self._crop: Box | None = request.look.crop
        parts = find_parts(reader.header, request.depth_part, reader.name, option="--depth-part")
        channels = {channel: index for index, part in parts.items() for channel in part.channels}
        wanted = [request.depth_channels] if request.depth_channels else list(NAMES)
        found = [c for name in wanted for c in channels if c == name or c.endswith(f".{name}")]
        if not found and len(channels) == 1 and not request.depth_channels:
            found = list(channels)
        if not found:
            listed = ", ".join(channels)
            raise FrameError(
                f"{reader.name}: which channel is the depth? It has {listed}; name one with --depth-channels"
            )
        self.channel, self._part = found[0], channels[found[0]]

    def problems(self) -> dict[int, str]:
        """What is wrong with files, by index, as far as headers tell."""
        return self.reader.problems(self._part, (self.channel,))

    def distance(self, index: int) -> NDArray[Any]:
        """[H, W] m. What is not finite is no surface: 0."""
        read = self.reader.read(index, self._part, (self.channel,))[..., 0]
        depth = np.where(np.isfinite(read) & (read > 0), read, 0)
        return self._crop.cut(depth) if self._crop else depth
