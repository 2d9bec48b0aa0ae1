"""The scene: a road, what it is made of, and the sun."""

import math
from typing import Annotated, Any, Literal

import numpy as np
from numpy.typing import ArrayLike, NDArray
from pydantic import Field, ValidationInfo, field_validator

from .table import Real, Table, Whole

MADE = {"albedo": "made:asphalt", "normal": "made:asphalt", "gloss": "made:asphalt", "twist": "made:brushed"}
"""Names of the maps that are made, not read."""

Quads = Annotated[Whole, Field(ge=1, le=256)]


class Road(Table):
    """A straight road along y that repeats for ever: u = x/width + 1/2, v = y/segment."""

    width: Real = Field(8.0, gt=0, le=1e4, description="width of the road, m; u runs 0..1 across, left to right")
    segment: Real = Field(8.0, gt=0, le=1e5, description="metres of road that a repeat of the maps covers")
    length: Real = Field(240.0, gt=0, le=1e5, description="metres of road drawn ahead of the eye")
    profile: Literal["flat", "hills"] = Field(
        "flat", description="flat, or hills: z = amplitude sin(2 pi y / wavelength)"
    )
    amplitude: Real | None = Field(
        None, ge=0, le=1000, validate_default=True, description="height of the hills, m; for hills only"
    )
    wavelength: Real | None = Field(
        None, gt=0, le=1e6, validate_default=True, description="length of the hills, m; for hills only"
    )

    tessellation: tuple[Quads, Quads] | None = Field(
        None, description="quads of a segment, across and along (1..256); default: 1, along hills 64 a wave"
    )

    @field_validator("amplitude", "wavelength")
    @classmethod
    def _only_for_hills(cls, value: float | None, info: ValidationInfo) -> float | None:
        profile = info.data.get("profile")
        if profile == "hills" and value is None:
            raise ValueError(f'missing: profile = "hills" needs {info.field_name}, in metres')
        if profile == "flat" and value is not None:
            raise ValueError('a flat road has none: remove this key, or set profile = "hills"')
        return value

    def height_at(self, y: ArrayLike) -> NDArray[np.float64]:
        """Height of the surface, m, at `y` metres along the road: float64 of the shape of `y`."""
        y = np.asarray(y, dtype=np.float64)
        if self.amplitude is None or self.wavelength is None:
            return np.zeros_like(y)
        return np.asarray(self.amplitude * np.sin(2 * np.pi / self.wavelength * y))

    def slope_at(self, y: ArrayLike) -> NDArray[np.float64]:
        """Slope dz/dy of the surface at `y` metres along the road: float64 of the shape of `y`."""
        y = np.asarray(y, dtype=np.float64)
        if self.amplitude is None or self.wavelength is None:
            return np.zeros_like(y)
        wave = 2 * np.pi / self.wavelength
        return np.asarray(self.amplitude * wave * np.cos(wave * y))


class Material(Table):
    """What the road is made of: a reflectance model and its maps.

    A map is the name of a made one (`made:asphalt`, for the twist `made:brushed`) or a file, relative to the sequence
    file. Row 0 of a map is v = 0. A model that is not anisotropic takes no twist, and the map is not read.
    """

    brdf: str = Field("blinn-phong", min_length=1, description="reflectance model, by name")
    parameters: dict[str, Any] = Field({}, description="parameters of the reflectance model")
    albedo: str = Field(
        "made:asphalt",
        min_length=1,
        description="map of 3 channels; sRGB if its metadata or extension says so, else linear",
    )
    normal: str = Field(
        "made:asphalt",
        min_length=1,
        description="map of 3 channels, tangent space x right, y forward, z up; integers hold (n + 1) / 2",
    )
    gloss: str = Field(
        "made:asphalt",
        min_length=1,
        description="map of 2 channels: Ks and power; integer files hold power = 2^(1 + 12 c)",
    )
    twist: str | None = Field(
        None,
        min_length=1,
        description="map that turns the tangent, for anisotropic models: 2 channels, x right and y forward, integers "
        "hold (c + 1) / 2; or 1 channel, the angle from x to y in radians, integers hold angle / (2 pi); default: none",
    )

    @field_validator(*MADE)
    @classmethod
    def _known_maker(cls, value: str | None, info: ValidationInfo) -> str | None:
        made = MADE[str(info.field_name)]
        if value is not None and value.startswith("made:") and value != made:
            raise ValueError(f"no such made map: {value!r} (there is {made}; anything else is a file)")
        return value


class Sun(Table):
    """A directional light, relative to the road and not to the camera."""

    azimuth: Real = Field(4.0, ge=-360, le=360, description="degrees clockwise from straight ahead (-360..360)")
    elevation: Real = Field(14.0, ge=-90, le=90, description="degrees above the horizon (-90..90)")
    diffuse: Real = Field(0.6, ge=0, le=1e6, description="diffuse intensity: fD = sat(N.L) * diffuse")

    @property
    def direction(self) -> NDArray[np.float64]:
        """L, the unit vector to the sun: (cos e sin a, cos e cos a, sin e), float64 [3]."""
        azimuth, elevation = math.radians(self.azimuth), math.radians(self.elevation)
        level = math.cos(elevation)
        return np.array((level * math.sin(azimuth), level * math.cos(azimuth), math.sin(elevation)))


class Wires(Table):
    """Flat ribbons along the road, of its material and evenly spaced across: slivers on the screen."""

    count: Whole = Field(ge=1, le=64, description="number of wires (1..64)")
    width: Real = Field(0.01, gt=0, le=10, description="width of a wire, m (0..10)")
    height: Real = Field(0.1, gt=0, le=100, description="height of the wires above the road, m (0..100)")

    def places(self, road: Road) -> NDArray[np.float64]:
        """Where the middles of the wires lie, m right of the road's centre line, float64 [count]."""
        return ((np.arange(self.count) + 0.5) / self.count - 0.5) * road.width


class Posts(Table):
    """Upright boards across the road and thin rails along them, of its material: they hide the road and show it again.

    The boards stand in rows along the road, at y = 0 and every `spacing` m; each row has a rail at their upper ends.
    """

    rows: tuple[Real, ...] = Field(
        (-2.5, 2.5), min_length=1, max_length=16, description="where the rows stand, m right of the centre line (1..16)"
    )
    spacing: Real = Field(6.0, gt=0, le=1000, description="m from a post to the next one along the road (0..1000)")
    width: Real = Field(0.25, gt=0, le=100, description="width of a post, m (0..100)")
    height: Real = Field(1.0, gt=0, le=100, description="height of the posts above the road, m (0..100)")
    rail: Real = Field(0.03, ge=0, le=10, description="width of the rails, m (0..10); 0 for none")

    @field_validator("rows")
    @classmethod
    def _each_once(cls, value: tuple[float, ...]) -> tuple[float, ...]:
        if len(set(value)) < len(value):
            raise ValueError("two rows stand at one place; give each place once")
        return value


class Scene(Table):
    """What stands still: road, wires over it, posts on it, material, sun."""

    road: Road = Field(default=Road(), description="shape of the road")
    wires: Wires | None = Field(None, description="thin ribbons over the road; none unless given")
    posts: Posts | None = Field(None, description="posts and rails along the road; none unless given")
    material: Material = Field(default=Material(), description="reflectance model and maps")
    sun: Sun = Field(default=Sun(), description="the light")

    @field_validator("wires")
    @classmethod
    def _apart(cls, value: Wires | None, info: ValidationInfo) -> Wires | None:
        road = info.data.get("road")
        if value is not None and road is not None and value.count * value.width > road.width:
            raise ValueError(f"{value.count} wires of {value.width} m overlap on a road of {road.width} m")
        return value
