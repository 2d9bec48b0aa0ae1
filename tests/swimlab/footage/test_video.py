"""Video, where PyAV is installed (extra `video`); what happens without it is tested everywhere."""

import sys
from fractions import Fraction
from importlib.util import find_spec

import numpy as np
import pytest

from metrics.display import encode
from swimlab.footage.reader import open_frames
from swimlab.footage.request import Request
from swimlab.footage.source import Look, Source
from swimlab.footage.subject import Subject
from swimlab.footage.upright import upright
from swimlab.footage.video_times import even_times
from swimlab.runs.frames import FrameError, write_channels

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


@pytest.fixture
def codes(tmp_path):
    """codes(values, ticks, ...) -> a lossless 10-bit film of flat pictures of code values 0..1, limited range."""

    def codes(values, ticks=None, name="codes.mkv", **colour):
        import av

        path = tmp_path / name
        with av.open(str(path), "w") as container:
            stream = container.add_stream("ffv1", rate=60)
            stream.width, stream.height, stream.pix_fmt = 64, 48, "yuv444p10le"
            stream.time_base = stream.codec_context.time_base = Fraction(1, 1000)
            for key, value in colour.items():
                setattr(stream.codec_context, key, value)
            for index, value in enumerate(values):
                frame = av.VideoFrame(64, 48, "yuv444p10le")
                for plane, code in zip(frame.planes, (round(64 + 876 * value), 512, 512), strict=True):
                    plane.update(np.full((48, plane.line_size // 2), code, np.uint16).tobytes())
                frame.pts = (index if ticks is None else ticks[index]) * 1000 // 60
                frame.time_base = Fraction(1, 1000)
                container.mux(stream.encode(frame))
            container.mux(stream.encode())
        return str(path)

    return codes


@with_av
def test_frames_at_uneven_times_stand_at_their_times(codes):
    levels, ticks = (0.1, 0.2, 0.4, 0.5), (0, 1, 3, 4)
    reader = open_frames(codes(levels, ticks))
    assert (reader.numbers, reader.gaps, reader.header.fps) == ((0, 1, 2, 3, 4), {2}, 60)
    source = Source(reader, Look(colour_space="linear"))
    for tick, level in zip(ticks, levels, strict=True):
        assert source.picture(tick) == pytest.approx(level, abs=1 / 876)
    with pytest.raises(FrameError, match="frame 2: there is none"):
        source.picture(2)
    found = Subject(Request(test=reader.name, motion="0,0", unverified=True), lambda _: None, lambda _: None)
    assert found.kept == [0, 1, 3, 4]
    assert any("4 of 5 times at 60 frames a second" in note for note in found.notes)


@with_av
@pytest.mark.parametrize(("transfer", "nits"), [(16, 100.0), (18, 203.0)])
def test_pq_and_hlg_are_decoded(codes, transfer, nits, tolerance):
    """SMPTE ST 2084: 100 cd/m^2 are the code .5081; ITU-R BT.2408: HLG's white of 203 cd/m^2 is .75."""
    code = {16: 0.5081, 18: 0.75}[transfer]
    name = codes([code] * 2, color_trc=transfer, color_primaries=9, colorspace=9)
    assert Source(open_frames(name), Look()).picture(0) == pytest.approx(nits / 100, rel=tolerance("light of a code"))


@with_av
@pytest.mark.parametrize("code", [0.25, 0.5, 1.0])
def test_codes_of_10_bit_span_the_whole_range(codes, code, tolerance):
    found = Source(open_frames(codes([code] * 2)), Look(colour_space="linear")).picture(0)
    assert found == pytest.approx(round(876 * code) / 876, abs=tolerance("16-bit codes of a video"))


@with_av
def test_a_transfer_that_is_not_known_is_refused_by_name(codes):
    with pytest.raises(FrameError, match=r"in H\.273 primaries 9, transfer 10, which is not known"):
        Source(open_frames(codes([0.5] * 2, color_trc=10, color_primaries=9, colorspace=9)), Look())


MATRICES = {
    "as it is": (1, 0, 0, 1),
    "turned left": (0, -1, 1, 0),
    "turned right": (0, 1, -1, 0),
    "upside down": (-1, 0, 0, -1),
    "left to right": (-1, 0, 0, 1),
    "top to bottom": (1, 0, 0, -1),
    "over the diagonal": (0, 1, 1, 0),
    "over the other diagonal": (0, -1, -1, 0),
}
"""a, b, c, d of libavutil/display.h."""


def full_matrix(a, b, c, d):
    return [a << 16, b << 16, 0, c << 16, d << 16, 0, 0, 0, 1 << 30]


@pytest.mark.parametrize("how", MATRICES)
def test_a_display_matrix_takes_every_pixel_to_its_place(how):
    a, b, c, d = MATRICES[how]
    stored = np.arange(12).reshape(3, 4)
    points = {(a * p + c * q, b * p + d * q): stored[q, p] for q in range(3) for p in range(4)}
    columns, rows = (sorted({point[axis] for point in points}) for axis in (0, 1))
    seen = upright(full_matrix(*MATRICES[how]))
    assert seen.of(stored).tolist() == [[points[column, row] for column in columns] for row in rows]
    assert seen.across == (a == 0)


def test_a_turn_that_is_no_quarter_is_refused():
    with pytest.raises(ValueError, match="no quarter"):
        upright([46341, 46341, 0, -46341, 46341, 0, 0, 0, 1 << 30])


@with_av
@pytest.mark.parametrize("how", ["as it is", "turned left", "left to right", "over the diagonal"])
def test_a_turned_or_mirrored_video_is_shown_upright(tmp_path, how):
    import av

    stored = np.zeros((48, 64, 3), np.uint8)
    stored[:16, :16], stored[:16, 48:] = 255, 128
    path = tmp_path / "turned.mp4"
    with av.open(str(path), "w") as container:
        stream = container.add_stream("libx264rgb", rate=30, options={"qp": "0"})
        stream.height, stream.width, stream.pix_fmt = *stored.shape[:2], "rgb24"
        if not hasattr(stream, "set_display_matrix"):
            pytest.skip("needs a PyAV that writes how a video is turned: 18.1")
        stream.set_display_matrix(full_matrix(*MATRICES[how]))
        for _ in range(2):
            container.mux(stream.encode(av.VideoFrame.from_ndarray(stored, format="rgb24")))
        container.mux(stream.encode())
    reader = open_frames(str(path))
    seen = upright(full_matrix(*MATRICES[how])).of(stored)
    assert reader.header.size == seen.shape[1::-1]
    assert np.array_equal(np.round(reader.read(0, 0, ("R", "G", "B")) * 255), seen)


@with_av
def test_pixels_that_are_not_square_are_told(tmp_path, swimlab):
    frame = b"FRAME\n" + bytes([99]) * 3072 * 3
    (tmp_path / "a.y4m").write_bytes(b"YUV4MPEG2 W64 H48 F30:1 Ip A3:2 C444\n" + 2 * frame)
    code, out, _ = swimlab("info", tmp_path / "a.y4m")
    assert code == 0
    assert "64x48, pixels 1.5 times as wide as high" in out


@with_av
def test_vectors_beside_a_film_of_uneven_times_are_one_a_time(codes, tmp_path, swimlab):
    """One file a frame is refused by name."""
    name = codes((0.1, 0.2, 0.4, 0.5), (0, 1, 3, 4))
    still = np.zeros((48, 64, 2), np.float32)
    for t in range(4):
        write_channels(tmp_path / f"v.{t}.exr", still, ("X", "Y"), half=False, metadata={})
    words = ("measure", "--test", name, "--motion", tmp_path / "v.%d.exr", "--motion-unverified", "--json")
    code, _, err = swimlab(*words)
    assert code == 2
    assert "has 4 frames (0-3), the test as many, at uneven times, which number them to 4: give one a time" in err
    write_channels(tmp_path / "v.4.exr", still, ("X", "Y"), half=False, metadata={})
    request = Request(test=name, motion=str(tmp_path / "v.%d.exr"), unverified=True)
    assert Subject(request, lambda _: None, lambda _: None).kept == [0, 1, 3, 4]


@with_av
def test_an_interlaced_video_is_refused(tmp_path):
    import av

    path = tmp_path / "fields.mkv"
    with av.open(str(path), "w") as container:
        stream = container.add_stream("mpeg2video", rate=25, options={"flags": "+ildct+ilme"})
        stream.width, stream.height, stream.pix_fmt = 64, 48, "yuv420p"
        for _ in range(3):
            frame = av.VideoFrame.from_ndarray(np.full((48, 64, 3), 99, np.uint8), format="rgb24")
            container.mux(stream.encode(frame.reformat(format="yuv420p")))
        container.mux(stream.encode())
    with pytest.raises(FrameError, match=r"fields\.mkv, frame 0: is interlaced"):
        open_frames(str(path))


@with_av
def test_y4m_is_a_video(tmp_path):
    head = b"YUV4MPEG2 W64 H48 F30:1 Ip A1:1 C444\n"
    levels = (100, 150, 200)
    flat = b"".join(b"FRAME\n" + bytes([level]) * 3072 + bytes([128]) * 6144 for level in levels)
    (tmp_path / "a.y4m").write_bytes(head + flat)
    source = Source(open_frames(str(tmp_path / "a.y4m")), Look(colour_space="linear"))
    assert (source.reader.header.size, source.reader.header.fps) == ((64, 48), 30)
    assert [round(float(source.picture(t).mean()) * 219) for t in range(3)] == [level - 16 for level in levels]


def stamps(*milliseconds):
    return [Fraction(each, 1000) for each in milliseconds]


@pytest.mark.parametrize(
    ("times", "places", "rate"),
    [
        (stamps(0, 17, 33, 50), (0, 1, 2, 3), 61),
        (stamps(0, 17, 50, 67), (0, 1, 3, 4), 60),
        (stamps(0, 33, 50, 133), (0, 2, 3, 8), 60),
        (stamps(0, 42, 125), (0, 1, 3), 24),
        (stamps(40, 80, 160, 200), (0, 1, 3, 4), 25),
    ],
)
def test_times_are_places_on_an_even_grid(times, places, rate, tolerance):
    """The average counts where no place is empty, else what fits, which is the stated rate if close to it."""
    found = even_times(times, Fraction(60), Fraction(61))
    assert found.places == places
    assert found.rate == pytest.approx(rate, rel=tolerance("rate by milliseconds"))


def test_times_that_say_nothing_are_none():
    assert even_times([None, None], Fraction(60), Fraction(60)) is None
    assert even_times([Fraction(0)], Fraction(60), Fraction(60)) is None


@pytest.mark.parametrize("times", [stamps(0, 17, 17, 33), stamps(0, 33, 17), stamps(0, 20, 47, 81)])
def test_times_on_no_grid_are_an_error(times):
    with pytest.raises(ValueError, match="time"):
        even_times(times, Fraction(60), Fraction(60))


def test_without_pyav_the_extra_is_named(tmp_path, monkeypatch):
    (tmp_path / "a.mp4").write_bytes(b"")
    monkeypatch.setitem(sys.modules, "av", None)
    with pytest.raises(FrameError, match=r"a\.mp4: reading video needs PyAV; pip install 'swimlab\[video\]'"):
        open_frames(str(tmp_path / "a.mp4"))
