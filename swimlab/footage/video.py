"""Video as frames, by PyAV (extra `video`)."""

from collections.abc import Iterator, Sequence
from fractions import Fraction
from typing import Any

import numpy as np

from swimlab.footage.colour_tags import space_of_codes
from swimlab.footage.header import Header, Part
from swimlab.footage.pattern import frame_range, parse_range
from swimlab.footage.upright import Upright, upright
from swimlab.footage.video_times import even_times
from swimlab.runs.frames import FrameError, Image

_LOSSLESS = frozenset({"ffv1", "huffyuv", "ffvhuff", "utvideo", "rawvideo", "png", "qtrle", "v210"})
_CHANNELS = ("R", "G", "B")
_AS_IT_IS = np.eye(3, dtype="=i4").tobytes()


class VideoReader:
    """Frames of a video file, decoded in order; going back decodes from the start."""

    def __init__(self, name: str, *, frames: str | None = None) -> None:
        """Frames whose time stamps leave places of an even grid empty are numbered by their places on it.

        Raises FrameError without PyAV, for a file that cannot be decoded, is interlaced or has no even grid of times,
        and for frames that it does not have.
        """
        self.name = name
        with self._open() as container:
            stream = container.streams.video[0]
            context = stream.codec_context
            wide = any(part.bits > 8 for part in context.format.components)
            yuv = str(context.format.name).startswith("yuv")
            limited = yuv and getattr(context, "color_range", 1) != 2
            stamps, self._upright = self._survey(container, stream)
            try:
                times = even_times(stamps, stream.guessed_rate, stream.average_rate)
            except ValueError as error:
                raise FrameError(
                    f"{name}: {error}; write it at a constant rate, as ffmpeg -fps_mode cfr does"
                ) from error
            space = space_of_codes(int(context.color_primaries), int(context.color_trc))
            size = (context.width, context.height)
            rate = stream.average_rate if times is None else times.rate
            aspect = float(stream.sample_aspect_ratio or 1)
            self.header = Header(
                size=size[::-1] if self._upright.across else size,
                parts=(Part("", _CHANNELS, ("uint16" if wide else "uint8",) * 3, space),),
                compression="lossless video" if context.name in _LOSSLESS else "lossy video",
                fps=float(rate) if rate else None,
                full_scale=(219 << (max(part.bits for part in context.format.components) - 8)) if limited else None,
                pixel_aspect=1 / aspect if self._upright.across else aspect,
            )
        self._format = "rgb48le" if wide else "rgb24"
        self._white = (
            _white(context.format, limited=limited) if wide and yuv else np.iinfo(f"uint{16 if wide else 8}").max
        )
        places = range(len(stamps)) if times is None else times.places
        self._order = {place: index for index, place in enumerate(places)}
        last = max(self._order, default=-1)
        self.numbers = tuple(range(last + 1)) if frames is None else parse_range(frames, name)
        outside = [number for number in self.numbers if not 0 <= number <= last]
        if outside or not self.numbers:
            raise FrameError(f"{name}: has frames 0-{last}, not {frame_range(outside)}")
        self.gaps = frozenset(index for index, number in enumerate(self.numbers) if number not in self._order)
        self._next = 0
        self._decoded: Iterator[Any] = iter(())

    def _survey(self, container: Any, stream: Any) -> tuple[list[Fraction | None], Upright]:
        """The time stamps of all frames, s, and how they are to be turned and mirrored."""
        stamps: list[Fraction | None] = []
        shown: dict[bytes, int] = {}
        for frame in container.decode(stream):
            if frame.interlaced_frame:
                raise FrameError(
                    f"{self.name}, frame {len(stamps)}: is interlaced: two moments in one picture; deinterlace it, as "
                    "ffmpeg -vf bwdif does"
                )
            shown.setdefault(_display_matrix(frame), len(stamps))
            stamps.append(None if frame.pts is None or frame.time_base is None else frame.pts * frame.time_base)
        if len(shown) > 1:
            raise FrameError(
                f"{self.name}, frame {max(shown.values())}: is to be turned otherwise than those before it"
            )
        try:
            return stamps, upright(np.frombuffer(next(iter(shown), b"") or _AS_IT_IS, "=i4").tolist())
        except ValueError as error:
            raise FrameError(f"{self.name}: {error}; write it upright") from error

    def __getstate__(self) -> dict[str, Any]:
        """All but the place at which it is decoded."""
        return vars(self) | {"_next": 0, "_decoded": iter(())}

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
        if index in self.gaps:
            raise FrameError(f"{self.label(index)}: there is none, as the time stamps say")
        number = self._order[self.numbers[index]]
        if number < self._next or self._next == 0:
            self._next, self._decoded = 0, self._decode()
        for frame in self._decoded:
            self._next += 1
            if self._next > number:
                pixels = self._upright.of(frame.to_ndarray(format=self._format))
                chosen = [_CHANNELS.index(channel) for channel in channels]
                return np.asarray(pixels[..., chosen], np.float32) / np.float32(self._white)
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


def _display_matrix(frame: Any) -> bytes:
    """Nine integers of a frame's display matrix; nothing where it has none."""
    return next((bytes(data) for data in frame.side_data if data.type.name == "DISPLAYMATRIX"), b"")


def _white(pixel_format: Any, *, limited: bool) -> int:
    """What a white pixel of a format of more than 8 bit becomes in 16: swscale falls short of the whole range."""
    import av  # an extra

    bits = max(part.bits for part in pixel_format.components)
    white, grey = (235 << (bits - 8) if limited else (1 << bits) - 1), 128 << (bits - 8)
    frame = av.VideoFrame(16, 16, pixel_format.name)
    frame.color_range = 1 if limited else 2
    order = ">u2" if pixel_format.is_big_endian else "<u2"
    for plane, code in zip(frame.planes, (white, grey, grey), strict=False):
        plane.update(np.full(plane.buffer_size // 2, code, order).tobytes())
    return int(frame.to_ndarray(format="rgb48le").max())
