"""The same kernels on a GPU, in their plain forms."""

import numpy as np
import pytest
import warp as wp

from metrics.kernels.launch import Launcher, start_warp
from sequences import load
from sequences.asphalt import make
from swimlab.render.catalogue import model_of, techniques
from swimlab.render.inputs import Maps
from swimlab.render.material import Material
from swimlab.render.shot import Shot

start_warp()
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


def test_a_device_that_is_not_there_is_an_error():
    with pytest.raises(ValueError, match="--device cuda:99: not on this machine; it has cpu"):
        Launcher(device="cuda:99")
