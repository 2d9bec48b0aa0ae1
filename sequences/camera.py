"""The camera: a pinhole above the road."""

import math

import numpy as np
from numpy.typing import NDArray
from pydantic import Field

from .scene import Road
from .table import Real, Table


class Camera(Table):
    """A pinhole camera without roll: square pixels, principal point at the middle of the image.

    World axes: x right, y forward along the road, z up, in metres.
    """

    height: Real = Field(1.3, gt=0, le=1000, description="height of the eye above the road below it, m (0..1000)")
    lateral: Real = Field(0.0, ge=-1e4, le=1e4, description="eye right of the centre line, m")
    distance: Real = Field(0.0, ge=-1e9, le=1e9, description="eye along the road, m")
    pitch: Real = Field(-8.0, ge=-90, le=90, description="tilt in degrees, up is positive (-90..90)")
    yaw: Real = Field(0.0, ge=-360, le=360, description="turn about z in degrees, right is positive (-360..360)")
    fov: Real = Field(50.0, ge=1, le=170, description="vertical field of view in degrees (1..170)")

    def basis(self) -> NDArray[np.float64]:
        """Rotation from world to camera axes: rows right, down, forward, float64 [3, 3], orthonormal."""
        yaw, pitch = math.radians(self.yaw), math.radians(self.pitch)
        right = (math.cos(yaw), -math.sin(yaw), 0.0)
        ahead = (math.sin(yaw), math.cos(yaw))
        down = (ahead[0] * math.sin(pitch), ahead[1] * math.sin(pitch), -math.cos(pitch))
        forward = (ahead[0] * math.cos(pitch), ahead[1] * math.cos(pitch), math.sin(pitch))
        return np.array((right, down, forward))

    def eye(self, road: Road) -> NDArray[np.float64]:
        """Place of the eye in the world, m, float64 [3]: `height` above the road right below it."""
        ground = float(road.height_at(self.distance))
        return np.array((self.lateral, self.distance, self.height + ground))

    def focal(self, height_px: float) -> float:
        """Focal length in pixels of an image `height_px` pixels high: (H/2) / tan(fov/2)."""
        return height_px / 2 / math.tan(math.radians(self.fov) / 2)
