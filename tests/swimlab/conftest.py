"""What the renderer's tests share: one launcher, small maps, and shots of small roads."""

import sys
from collections.abc import Callable, Iterator

import numpy as np
import pytest

from sequences import Sequence
from sequences.asphalt import make
from swimlab.catalogue import brdfs, techniques
from swimlab.cli.main import main
from swimlab.launch import Launcher
from swimlab.material import pack
from swimlab.shot import Shot
from swimlab.technique import Picture
from swimlab.texture import MipChain


@pytest.fixture(scope="session")
def launcher() -> Iterator[Launcher]:
    with Launcher(threads=2) as launcher:
        yield launcher


@pytest.fixture(scope="session")
def maps() -> np.ndarray:
    """Asphalt of 64 x 64 texels, [64, 64, 8]: albedo, normal, Ks, power."""
    return np.concatenate(make(0, 64), axis=2)


@pytest.fixture(scope="session")
def pack_maps(launcher: Launcher) -> Callable[[np.ndarray], MipChain]:
    """Maps [h, w, 8] as a chain on the device."""
    return lambda maps: pack(launcher, maps[..., :3], maps[..., 3:6], maps[..., 6:])


@pytest.fixture(scope="session")
def material(pack_maps, maps) -> MipChain:
    return pack_maps(maps)


@pytest.fixture(scope="session")
def shoot(launcher: Launcher, material: MipChain) -> Callable[..., Shot]:
    """A shot of a frame; the small asphalt unless another chain is given."""

    def shoot(sequence: Sequence, frame: int = 0, chain: MipChain = material, samples: int = 16) -> Shot:
        return Shot(sequence, frame, chain, brdfs()["blinn-phong"], samples, launcher)

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
