"""The same kernels on a GPU, in their plain forms."""

import numpy as np
import pytest
import warp as wp

from metrics import Clip, measure
from metrics.kernels.launch import Launcher
from metrics.kernels.starting import start_warp
from metrics.synthetic import Rotation, texture
from sequences import load
from sequences.asphalt import make
from swimlab.render.catalogue import model_of, techniques
from swimlab.render.inputs import Maps
from swimlab.render.material import Material
from swimlab.render.shot import Shot

start_warp()
pytestmark = pytest.mark.may_skip("the machines of CI have no GPU")
needs_gpu = pytest.mark.skipif(not wp.get_cuda_device_count(), reason="this machine has no CUDA device")


@needs_gpu
@pytest.mark.parametrize("name", techniques())
def test_a_gpu_renders_the_same_frames(tolerance, name):
    sequence = load("road-drive").with_changes(size=(96, 54))
    given = {"size": 64} if name == "tsl" else {}
    pictures = []
    for device in ("cpu", "cuda:0"):
        with Launcher(threads=2, device=device) as launcher:
            shot = Shot(sequence, 2, Material(launcher, Maps(*make(0, 64))), model_of(sequence), 16, launcher)
            technique = techniques()[name]
            pictures.append(technique.render(shot, technique.settings(**given)).rgba)
    one, other = pictures
    assert one.any()
    assert np.sqrt(np.mean((one - other) ** 2) / np.mean(one**2)) <= tolerance("a GPU against the CPU")


@needs_gpu
def test_a_gpu_measures_the_same_scores(tolerance):
    """Frames that turn are followed, unwarped and compared there."""
    turning, random = Rotation(2.0, (150, 150)), np.random.default_rng(0)
    pattern = texture(1, mean=2.0)
    reference = [pattern.at(*turning.surface(t)).astype(np.float32) for t in range(6)]
    wrong = [frame + 0.1 * random.standard_normal(frame.shape, np.float32) for frame in reference]
    test, exact = Clip(wrong.__getitem__, 6, motion=turning.motion), Clip(reference.__getitem__, 6)
    one, other = (measure(test, exact, device=device).scores for device in ("cpu", "cuda:0"))
    assert other == pytest.approx(one, rel=tolerance("a GPU against the CPU"), abs=tolerance("glued"))


def test_a_measure_on_a_device_that_is_not_there_is_an_error():
    clip = Clip(lambda _: np.ones((32, 32, 3), np.float32), 2)
    with pytest.raises(ValueError, match="--device cuda:99: not on this machine; it has cpu"):
        measure(clip, device="cuda:99")


def test_a_device_that_is_not_there_is_an_error():
    with pytest.raises(ValueError, match="--device cuda:99: not on this machine; it has cpu"):
        Launcher(device="cuda:99")
