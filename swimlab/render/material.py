"""The scene's maps: made, or read from files and checked, and packed into mip chains."""

from collections.abc import Callable
from functools import cached_property
from pathlib import Path
from typing import Any

import numpy as np
import warp as wp

from metrics.kernels.launch import Launcher
from sequences import Sequence
from swimlab.render.inputs import Inputs, Level, Map, Maps
from swimlab.render.kernels.sampling import resolving
from swimlab.render.kernels.structs import TEXELS
from swimlab.render.made_maps import SIZE, made_map, tangents
from swimlab.render.texture import MipChain
from swimlab.runs.frames import oiio_name

POWER_OCTAVES = 12.0
"""Integer gloss maps hold power = 2^(1 + 12 c)."""

CHANNELS = {"albedo": 3, "normal": 3, "gloss": 2, "twist": 1}
"""Map -> channels that it must have."""

MOST_CHANNELS = {"twist": 2}
"""Map -> channels read at most, where this is more than the least it must have: a twist is an angle or a vector."""


class MapError(ValueError):
    """A map that cannot be used; the message names the key and the file and says how to mend it."""


class Material:
    """The maps of a scene, and the mip chains that techniques make of them, each made once on first use."""

    def __init__(self, launcher: Launcher, maps: Maps) -> None:
        self._launcher = launcher
        self._maps = maps
        self._chains: dict[Callable[[Maps], Level], MipChain] = {}
        self._resolved: dict[Any, MipChain] = {}

    @property
    def size(self) -> tuple[int, int]:
        """Width and height of the maps in texels."""
        height, width = self._maps.albedo.shape[:2]
        return width, height

    @cached_property
    def highest_power(self) -> float:
        """The largest power of the maps."""
        return float(self._maps.gloss[..., 1].max())

    @property
    def twisted(self) -> bool:
        """Whether the tangent is turned by a map."""
        return self._maps.twist is not None

    def chain(self, inputs: Inputs) -> MipChain:
        """The repeating mip chain of some inputs."""
        if inputs.pack not in self._chains:
            self._chains[inputs.pack] = self._packed(inputs)
        return self._chains[inputs.pack]

    def resolved(self, inputs: Inputs) -> MipChain:
        """That chain with every texel of every level as it is shaded."""
        if inputs.resolve is None:
            return self.chain(inputs)
        if inputs.resolve not in self._resolved:
            chain = self.chain(inputs)
            texels = self._launcher.empty(len(chain.texels), chain.texels.dtype)
            self._launcher.launch(
                resolving(inputs.resolve, chain.floats), len(texels), [chain.texels, chain.shape, texels]
            )
            self._resolved[inputs.resolve] = MipChain(texels, chain.shape)
        return self._resolved[inputs.resolve]

    def _packed(self, inputs: Inputs) -> MipChain:
        texels, centre = inputs.pack(self._maps)
        if self._maps.twist is not None:
            texels = np.concatenate([texels, self._maps.twist], axis=2, dtype=np.float32)
        height, width, floats = texels.shape
        chain = MipChain.allocate(self._launcher, width=width, height=height, dtype=TEXELS[floats], clamps=False)
        chain.shape.centre = wp.vec2(*centre)
        chain.texels[: width * height].assign(np.ascontiguousarray(texels).reshape(-1, floats))
        chain.reduce(self._launcher)
        return chain


def load_material(sequence: Sequence, launcher: Launcher, *, twisted: bool = True) -> Material:
    """The sequence's material; its map of twist only if `twisted`, for models that use tangents.

    Raises MapError for a map that cannot be used.
    """
    return Material(launcher, read_maps(sequence, twisted=twisted))


def read_maps(sequence: Sequence, *, twisted: bool = True) -> Maps:
    """The sequence's maps: linear albedo, signed normals, Ks and power, and tangents if `twisted`.

    Made ones are of the size of those that are files. Raises MapError.
    """
    material = sequence.scene.material
    named = {"albedo": material.albedo, "normal": material.normal, "gloss": material.gloss}
    if material.twist is not None and twisted:
        named["twist"] = material.twist
    paths = {key: path for key, value in named.items() if (path := sequence.map_path(value)) is not None}
    files = {key: _load(key, path) for key, path in paths.items()}
    sizes = {key: plane.shape[:2] for key, plane in files.items()}
    if len(set(sizes.values())) > 1:
        listed = ", ".join(f"{key} {w}x{h}" for key, (h, w) in sizes.items())
        raise MapError(f"scene.material: the maps differ in size ({listed}); resize them to one")
    size = next(iter(sizes.values()), SIZE)
    return Maps(**{key: files[key] if key in files else made_map(key, sequence.seed, size) for key in named})


def _load(key: str, path: Path) -> Map:
    where = f"scene.material.{key}: {path}"
    channels = CHANNELS[key]
    pixels, integer, srgb = _read(path, where)
    if pixels.shape[2] < channels:
        raise MapError(f"{where}: has {pixels.shape[2]} channels; this map needs {channels}")
    pixels = pixels[..., : MOST_CHANNELS.get(key, channels)]
    height, width = pixels.shape[:2]
    if width & (width - 1) or height & (height - 1):
        raise MapError(f"{where}: is {width}x{height}; both sides must be powers of two")
    if not np.isfinite(pixels).all():
        row, column = np.argwhere(~np.isfinite(pixels).all(axis=2))[0]
        raise MapError(f"{where}: has a NaN or Inf, the first at column {column}, row {row}")
    return _decode(key, pixels, integer=integer, srgb=srgb, where=where)


def _decode(key: str, pixels: Map, *, integer: bool, srgb: bool, where: str) -> Map:
    """From stored values to what the shading core reads: linear albedo, signed normals and tangents, Ks and power."""
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
    if key == "twist":
        if pixels.shape[2] == 1:
            return tangents(pixels[..., 0] * (2 * np.pi if integer else 1.0))
        tangent = 2.0 * pixels - 1.0 if integer else pixels
        _require(
            bool((np.linalg.norm(tangent, axis=2) > 1e-3).all()),
            f"{where}: has tangents of zero length; untwisted is (1, 0)",
        )
        return tangent.astype(np.float32)
    gloss = pixels.copy()
    if integer:
        gloss[..., 1] = 2.0 ** (1.0 + POWER_OCTAVES * pixels[..., 1])
    _require(bool((gloss >= 0).all()), f"{where}: Ks and power must not be negative")
    return gloss


def _require(holds: bool, problem: str) -> None:
    if not holds:
        raise MapError(problem)


def _read(path: Path, where: str) -> tuple[Map, bool, bool]:
    """Pixels as float [h, w, c] without premultiplication, whether stored as integers, and whether sRGB-encoded.

    sRGB: as the file's own colour space says where it has one; else 8-bit PNG, JPEG, BMP, GIF and TGA are sRGB.
    """
    import OpenImageIO as oiio  # noqa: N813, heavy: made maps do not need it

    if not path.is_file():
        raise MapError(f"{where}: does not exist")
    config = oiio.ImageSpec()
    config.attribute("oiio:UnassociatedAlpha", 1)
    source = oiio.ImageInput.open(oiio_name(path), config)
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
