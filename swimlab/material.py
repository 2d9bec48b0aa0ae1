"""The scene's maps: made or read from files, checked, and packed into one mip chain."""

from functools import lru_cache
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from sequences import Sequence
from swimlab.kernels.structs import Texel
from swimlab.launch import Launcher
from swimlab.texture import MipChain

if TYPE_CHECKING:
    from sequences.asphalt import Maps

Map = NDArray[np.float32]

LARGEST_GAUGED_POWER = 12.0
"""Integer gloss maps hold power = 2^(1 + 12 c)."""


class MapError(ValueError):
    """A map that cannot be used; the message names the key and the file and says how to mend it."""


def load_material(sequence: Sequence, launcher: Launcher) -> MipChain:
    """Albedo, normal and gloss of the sequence's material, interleaved, as a repeating mip chain.

    Raises MapError for every way in which a map can be unfit.
    """
    return pack(launcher, *read_maps(sequence))


def read_maps(sequence: Sequence) -> tuple[Map, Map, Map]:
    """Albedo [h, w, 3] (linear), normal [h, w, 3] (tangent space) and gloss [h, w, 2] (Ks, power), all of one size."""
    material = sequence.scene.material
    albedo = _load(sequence, "albedo", material.albedo, 3)
    normal = _load(sequence, "normal", material.normal, 3)
    gloss = _load(sequence, "gloss", material.gloss, 2)
    sizes = {"albedo": albedo.shape[:2], "normal": normal.shape[:2], "gloss": gloss.shape[:2]}
    if len(set(sizes.values())) > 1:
        listed = ", ".join(f"{key} {w}x{h}" for key, (h, w) in sizes.items())
        raise MapError(f"scene.material: the maps differ in size ({listed}); resize them to one")
    return albedo, normal, gloss


def pack(launcher: Launcher, albedo: Map, normal: Map, gloss: Map) -> MipChain:
    """Interleave maps of one size and build their chain; normals are averaged unnormalised."""
    texels = np.concatenate([albedo, normal, gloss], axis=2, dtype=np.float32)
    height, width = texels.shape[:2]
    chain = MipChain.allocate(launcher, width=width, height=height, dtype=Texel, clamps=False)
    chain.texels[: width * height].assign(texels.reshape(-1, 8))
    chain.reduce(launcher)
    return chain


def _load(sequence: Sequence, key: str, value: str, channels: int) -> Map:
    path = sequence.map_path(value)
    if path is None:
        return np.asarray(getattr(_made(sequence.seed), key), np.float32)
    where = f"scene.material.{key}: {path}"
    pixels, integer, srgb = _read(path, where)
    if pixels.shape[2] < channels:
        raise MapError(f"{where}: has {pixels.shape[2]} channels; this map needs {channels}")
    pixels = pixels[..., :channels]
    height, width = pixels.shape[:2]
    if width & (width - 1) or height & (height - 1):
        raise MapError(f"{where}: is {width}x{height}; both sides must be powers of two")
    if not np.isfinite(pixels).all():
        row, column = np.argwhere(~np.isfinite(pixels).all(axis=2))[0]
        raise MapError(f"{where}: has a NaN or Inf, the first at column {column}, row {row}")
    return _decode(key, pixels, integer=integer, srgb=srgb, where=where)


@lru_cache(maxsize=1)
def _made(seed: int) -> "Maps":
    from sequences.asphalt import make

    return make(seed)


def _decode(key: str, pixels: Map, *, integer: bool, srgb: bool, where: str) -> Map:
    """From stored values to what the shading core reads: linear albedo, signed normals, Ks and power."""
    if key == "albedo":
        linear = np.where(pixels <= 0.04045, pixels / 12.92, ((pixels + 0.055) / 1.055) ** 2.4) if srgb else pixels
        _require(bool((linear >= 0).all()), f"{where}: has negative albedo")
        return linear.astype(np.float32)
    if key == "normal":
        normal = 2.0 * pixels - 1.0 if integer else pixels
        _require(bool((np.abs(normal) <= 1.001).all()), f"{where}: float normals must lie in [-1, 1]")
        _require(
            bool((np.linalg.norm(normal, axis=2) > 1e-3).all()),
            f"{where}: has normals of zero length; flat is (0, 0, 1)",
        )
        return normal.astype(np.float32)
    gloss = pixels.copy()
    if integer:
        gloss[..., 1] = 2.0 ** (1.0 + LARGEST_GAUGED_POWER * pixels[..., 1])
    _require(bool((gloss >= 0).all()), f"{where}: Ks and power must not be negative")
    return gloss


def _require(holds: bool, problem: str) -> None:
    if not holds:
        raise MapError(problem)


def _read(path: Path, where: str) -> tuple[Map, bool, bool]:
    """Pixels as float [h, w, c] without premultiplication, whether stored as integers, and whether sRGB-encoded.

    sRGB: as the file's own colour space says where it has one; else 8-bit PNG, JPEG, BMP, GIF and TGA are sRGB.
    """
    import OpenImageIO as oiio  # noqa: N813

    if not path.is_file():
        raise MapError(f"{where}: does not exist")
    config = oiio.ImageSpec()
    config.attribute("oiio:UnassociatedAlpha", 1)
    source = oiio.ImageInput.open(str(path), config)
    if source is None:
        raise MapError(f"{where}: is not a picture that can be read: {oiio.geterror()}")
    spec = source.spec()
    pixels = source.read_image(0, 0, 0, spec.nchannels, oiio.FLOAT)
    if pixels is None:
        raise MapError(f"{where}: is damaged: {source.geterror()}")
    source.close()
    integer = str(spec.format) not in {"float", "half", "double"}
    space = str(spec.get_string_attribute("oiio:ColorSpace")).lower()
    if space:
        srgb = "srgb" in space
    else:
        srgb = integer and path.suffix.lower() in {".png", ".jpg", ".jpeg", ".bmp", ".gif", ".tga"}
    return np.asarray(pixels, np.float32), integer, srgb
