"""Video as frames, by PyAV (extra `video`)."""

from collections.abc import Iterator, Sequence
from typing import Any

import numpy as np

from swimlab.footage.colour_tags import space_of_codes
from swimlab.footage.header import Header, Part
from swimlab.footage.pattern import frame_range, parse_range
from swimlab.runs.frames import FrameError, Image

_LOSSLESS = frozenset({"ffv1", "huffyuv", "ffvhuff", "utvideo", "rawvideo", "png", "qtrle", "v210"})
_CHANNELS = ("R", "G", "B")


class VideoReader:
    """Frames of a video file, decoded in order; going back decodes from the start."""

    def __init__(self, name: str, *, frames: str | None = None) -> None:
        """Raises FrameError without PyAV, for a file that cannot be decoded, and for frames that it does not have."""
        self.name = name
        with self._open() as container:
            stream = container.streams.video[0]
            context = stream.codec_context
            wide = any(part.bits > 8 for part in context.format.components)
            limited = str(context.format.name).startswith("yuv") and getattr(context, "color_range", 1) != 2
            count = sum(1 for _ in container.decode(stream))
            rate = stream.average_rate
            space = space_of_codes(int(context.color_primaries), int(context.color_trc))
            self.header = Header(
                size=(context.width, context.height),
                parts=(Part("", _CHANNELS, ("uint16" if wide else "uint8",) * 3, space),),
                compression="lossless video" if context.name in _LOSSLESS else "lossy video",
                fps=float(rate) if rate else None,
                full_scale=(219 << (max(part.bits for part in context.format.components) - 8)) if limited else None,
            )
        self._format = "rgb48le" if wide else "rgb24"
        self.numbers = tuple(range(count)) if frames is None else parse_range(frames, name)
        outside = [number for number in self.numbers if not 0 <= number < count]
        if outside or not self.numbers:
            raise FrameError(f"{name}: has frames 0-{count - 1}, not {frame_range(outside)}")
        self._next = 0
        self._decoded: Iterator[Any] = iter(())

    def label(self, index: int) -> str:
        return f"{self.name}, frame {self.numbers[index]}"

    def problems(self, part: int, channels: Sequence[str]) -> dict[int, str]:
        """None: every frame of a video has its size and channels."""
        return {}

    def damage(self) -> dict[int, str]:
        """None: every frame was decoded once to count them."""
        return {}

    def read(self, index: int, part: int, channels: Sequence[str]) -> Image:
        """R, G and B of a frame as stored, scaled to 0..1."""
        number = self.numbers[index]
        if number < self._next or self._next == 0:
            self._next, self._decoded = 0, self._decode()
        for frame in self._decoded:
            self._next += 1
            if self._next > number:
                pixels = frame.to_ndarray(format=self._format)
                chosen = [_CHANNELS.index(channel) for channel in channels]
                return np.asarray(pixels[..., chosen], np.float32) / np.float32(np.iinfo(pixels.dtype).max)
        raise FrameError(f"{self.label(index)}: cannot be decoded")

    def _decode(self) -> Iterator[Any]:
        with self._open() as container:
            yield from container.decode(container.streams.video[0])

    def _open(self) -> Any:
        try:
            import av  # an extra
        except ImportError as error:
            raise FrameError(f"{self.name}: reading video needs PyAV; pip install 'swimlab[video]'") from error
        try:
            container = av.open(self.name)
        except (OSError, ValueError) as error:
            raise FrameError(f"{self.name}: cannot be opened: {error}") from error
        if not container.streams.video:
            container.close()
            raise FrameError(f"{self.name}: has no video stream")
        return container
