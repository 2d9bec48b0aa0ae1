"""What the renderer's tests share: one launcher, small maps, and shots of small roads."""

import sys
from collections.abc import Callable, Iterator

import numpy as np
import pytest

from metrics.kernels.launch import Launcher
from sequences import Sequence
from sequences.asphalt import make
from swimlab.cli.main import main
from swimlab.render.catalogue import model_of, techniques
from swimlab.render.inputs import Maps
from swimlab.render.material import Material
from swimlab.render.shot import Shot
from swimlab.render.technique import Picture


@pytest.fixture(scope="session")
def launcher() -> Iterator[Launcher]:
    with Launcher(threads=2) as launcher:
        yield launcher


@pytest.fixture(scope="session")
def maps() -> np.ndarray:
    """Asphalt of 64 x 64 texels, [64, 64, 8]: albedo, normal, Ks, power."""
    return np.concatenate(make(0, 64), axis=2)


@pytest.fixture(scope="session")
def pack_maps(launcher: Launcher) -> Callable[[np.ndarray], Material]:
    """Maps [h, w, 8], or [h, w, 10] with a twist, as a material."""
    return lambda maps: Material(
        launcher, Maps(maps[..., :3], maps[..., 3:6], maps[..., 6:8], maps[..., 8:] if maps.shape[2] > 8 else None)
    )


@pytest.fixture(scope="session")
def material(pack_maps, maps) -> Material:
    return pack_maps(maps)


@pytest.fixture(scope="session")
def shoot(launcher: Launcher, material: Material) -> Callable[..., Shot]:
    """A shot of a frame; the small asphalt unless another material is given."""

    def shoot(sequence: Sequence, frame: int = 0, chain: Material = material, samples: int = 16) -> Shot:
        return Shot(sequence, frame, chain, model_of(sequence), samples, launcher)

    return shoot


@pytest.fixture(scope="session")
def render() -> Callable[..., Picture]:
    """A shot's picture under a technique with given settings."""

    def render(shot: Shot, name: str, **settings: object) -> Picture:
        technique = techniques()[name]
        return technique.render(shot, technique.settings(**settings))

    return render


@pytest.fixture
def swimlab(monkeypatch, capsys, tmp_path):
    """Run a command in an empty folder: exit code, standard output, standard error.

    The program reads its words from sys.argv, here as anywhere: that is what is tested.
    """
    monkeypatch.chdir(tmp_path)
    monkeypatch.setenv("COLUMNS", "200")

    def swimlab(*words):
        monkeypatch.setattr(sys, "argv", ["swimlab", *map(str, words)])
        # `main` replaces how warnings are shown; put that back afterwards.
        monkeypatch.setattr("warnings.showwarning", None)
        code = 0
        try:
            main()
        except SystemExit as error:
            code = error.code or 0
        return code, *capsys.readouterr()

    return swimlab
