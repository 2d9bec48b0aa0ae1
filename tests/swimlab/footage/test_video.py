"""Video, where PyAV is installed (extra `video`); what happens without it is tested everywhere."""

import sys
from importlib.util import find_spec

import numpy as np
import pytest

from metrics.display import encode
from swimlab.footage.reader import open_frames
from swimlab.footage.source import Look, Source
from swimlab.runs.frames import FrameError

with_av = pytest.mark.skipif(find_spec("av") is None, reason="needs the extra `video` (PyAV)")


@pytest.fixture
def film(tmp_path):
    """film(codec, format) -> a file of 5 frames, each of one grey, linear .1 to .5."""

    def film(codec, pixel_format):
        import av

        path = tmp_path / "film.mkv"
        with av.open(str(path), "w") as container:
            stream = container.add_stream(codec, rate=30)
            stream.width, stream.height, stream.pix_fmt = 64, 48, pixel_format
            for step in range(1, 6):
                code = round(255 * float(encode(np.array(step / 10))))
                frame = av.VideoFrame.from_ndarray(np.full((48, 64, 3), code, np.uint8), format="rgb24")
                container.mux(stream.encode(frame))
            container.mux(stream.encode())
        return str(path)

    return film


@with_av
@pytest.mark.parametrize(
    ("codec", "pixel_format", "compression"),
    [("ffv1", "bgr0", "lossless video"), ("ffv1", "yuv444p", "lossless video"), ("mpeg4", "yuv420p", "lossy video")],
)
def test_frames_of_a_video(film, codec, pixel_format, compression, tolerance):
    source = Source(open_frames(film(codec, pixel_format)), Look())
    header = source.reader.header
    assert (header.size, header.fps, header.compression) == ((64, 48), 30.0, compression)
    assert header.full_scale == (219 if pixel_format.startswith("yuv") else None)
    for index in (0, 1, 4, 2, 2, 0):
        assert np.abs(source.picture(index) - (index + 1) / 10).max() < tolerance("video code")


@with_av
def test_frames_that_a_video_lacks_are_named(film):
    name = film("ffv1", "bgr0")
    assert open_frames(name, frames="0-4x2").numbers == (0, 2, 4)
    with pytest.raises(FrameError, match="has frames 0-4, not 5-6"):
        open_frames(name, frames="3-6")


@with_av
def test_what_is_no_video_is_named(tmp_path):
    (tmp_path / "a.mp4").write_text("nothing of the kind")
    with pytest.raises(FrameError, match=r"a\.mp4: cannot be opened"):
        open_frames(str(tmp_path / "a.mp4"))


def test_without_pyav_the_extra_is_named(tmp_path, monkeypatch):
    (tmp_path / "a.mp4").write_bytes(b"")
    monkeypatch.setitem(sys.modules, "av", None)
    with pytest.raises(FrameError, match=r"a\.mp4: reading video needs PyAV; pip install 'swimlab\[video\]'"):
        open_frames(str(tmp_path / "a.mp4"))
