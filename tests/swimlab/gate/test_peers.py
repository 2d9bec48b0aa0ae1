"""Peers: known values where they are installed, clear errors where they are not."""

import importlib.util

import numpy as np
import pytest

from metrics import Clip, ClipError
from swimlab.scoring.peer import PeerError
from swimlab.scoring.peer_scores import peer_scores, peers

needs_flip = pytest.mark.skipif(
    importlib.util.find_spec("flip_evaluator") is None, reason="flip-evaluator is not installed: extra 'flip'"
)
needs_vdp = pytest.mark.skipif(
    importlib.util.find_spec("pycvvdp") is None, reason="cvvdp is not installed: extra 'vdp'"
)
needs_vmaf = pytest.mark.skipif(
    importlib.util.find_spec("imageio_ffmpeg") is None, reason="imageio-ffmpeg is not installed: extra 'vmaf'"
)
FLIPS = [pytest.param("flip", marks=needs_flip), "flip-oiio"]
COLOURS = {"black": (0, 0, 0), "white": (1, 1, 1), "red": (1, 0, 0), "green": (0, 1, 0), "blue": (0, 0, 1)}


def uniform(colour: str, count: int = 2) -> Clip:
    picture = np.broadcast_to(np.float32(COLOURS[colour]), (64, 64, 3))
    return Clip(lambda _: picture, count, pixels_per_degree=67.02064514160156)


@pytest.mark.parametrize("peer", FLIPS)
@pytest.mark.parametrize(
    ("test", "reference", "value"), [("green", "blue", 1.0), ("black", "white", 0.967345), ("red", "green", 0.986630)]
)
def test_flip_of_uniform_colours_is_as_published(peer, test, reference, value, tolerance):
    found = peer_scores(peer, uniform(test), uniform(reference))
    assert found == pytest.approx({f"{peer}.mean": value, f"{peer}.worst": value}, abs=tolerance("published FLIP"))


@pytest.mark.parametrize("peer", FLIPS)
def test_equal_clips_have_no_difference(peer):
    assert peer_scores(peer, uniform("red"), uniform("red")) == {f"{peer}.mean": 0.0, f"{peer}.worst": 0.0}


@needs_flip
def test_both_implementations_of_flip_agree(tolerance):
    noise = np.random.default_rng(0).random((2, 48, 64, 3), np.float32)
    test, reference = (Clip(lambda _, each=each: each, 1) for each in noise)
    one, other = (peer_scores(peer, test, reference)[f"{peer}.mean"] for peer in ("flip", "flip-oiio"))
    assert one == pytest.approx(other, abs=tolerance("two FLIPs"))


@pytest.mark.may_skip("CI does not install the extra vdp, which brings PyTorch")
@needs_vdp
def test_equal_clips_are_of_the_best_quality():
    assert peer_scores("vdp", uniform("red", 8), uniform("red", 8)) == {"vdp.jod": 10.0}


@pytest.mark.may_skip("CI does not install the extra vmaf, which brings a whole ffmpeg")
@needs_vmaf
def test_vmaf_falls_with_noise():
    """Equal clips have nearly 100: the model is fitted, not exact."""
    noise = np.random.default_rng(0).standard_normal((4, 48, 64, 3)).astype(np.float32)
    picture = np.random.default_rng(1).random((48, 64, 3), np.float32)
    reference = Clip(lambda _: picture, 4)
    found = [peer_scores("vmaf", Clip(lambda t, a=a: picture + a * noise[t], 4), reference) for a in (0, 0.05, 0.2)]
    assert found[0]["vmaf.mean"] > 95
    assert found[0]["vmaf.mean"] > found[1]["vmaf.mean"] > found[2]["vmaf.mean"]
    assert found[2]["vmaf.worst"] <= found[2]["vmaf.mean"]


@pytest.mark.parametrize("peer", peers())
def test_what_is_not_installed_says_how_to_install_it(peer, monkeypatch):
    extra = peers()[peer].extra
    if extra:
        for module in ("flip_evaluator", "pycvvdp", "imageio_ffmpeg"):
            monkeypatch.setitem(__import__("sys").modules, module, None)
        with pytest.raises(PeerError, match=rf"pip install 'swimlab\[{extra}\]'"):
            peer_scores(peer, uniform("red"), uniform("red"))
    else:
        assert peer_scores(peer, uniform("red"), uniform("red"))


def test_unknown_peers_are_refused():
    with pytest.raises(PeerError, match="flop: is no metric that is known; there are flip, flip-oiio, vdp, vmaf"):
        peer_scores("flop", uniform("red"), uniform("red"))


def test_clips_have_to_match():
    with pytest.raises(ClipError, match="as many frames"):
        peer_scores("flip-oiio", uniform("red", 2), uniform("red", 3))


def test_an_evaluator_that_exits_becomes_an_error(monkeypatch):
    class Exits:
        @staticmethod
        def evaluate(*_, **__):
            raise SystemExit(1)

    monkeypatch.setitem(__import__("sys").modules, "flip_evaluator", Exits)
    with pytest.raises(PeerError, match="gave up"):
        peer_scores("flip", uniform("red"), uniform("red"))
