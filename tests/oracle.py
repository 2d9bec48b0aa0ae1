"""An independent renderer of the flat road: rays and planes in double-precision numpy, no code shared with swimlab.

It follows the written definitions (ray against plane, singular values from numpy, one image at a time), so that where
both agree, conventions and formulas do.
"""

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from sequences import Sequence


@dataclass(frozen=True)
class Oracle:
    """A frame of a sequence on a flat road with maps [n, n, 8]: albedo, normal, Ks, power."""

    sequence: Sequence
    maps: np.ndarray
    frame: int

    def chain(self, inputs="box"):
        """Levels from full size to 1x1 by 2x2 means, of the maps or of their moments."""
        if inputs not in self._chains:
            self._chains[inputs] = mip_levels(moments_of(self.maps.astype(np.float64), inputs))
        return self._chains[inputs]

    @cached_property
    def _chains(self):
        return {}

    def surface(self, x, y):
        """What the image-plane places (x, y) see: hit mask, position relative to the eye, uv, d(uv)/dx, d(uv)/dy."""
        view, road = self.sequence.view(self.frame), self.sequence.scene.road
        camera = view.camera
        width, height = self.sequence.size
        focal = height / 2 / np.tan(np.radians(camera.fov) / 2)
        yaw, pitch = np.radians(camera.yaw), np.radians(camera.pitch)
        forward = np.array([np.sin(yaw) * np.cos(pitch), np.cos(yaw) * np.cos(pitch), np.sin(pitch)])
        right = np.array([np.cos(yaw), -np.sin(yaw), 0.0])
        up = np.cross(right, forward)
        ray = forward + right * ((x - width / 2) / focal)[..., None] - up * ((y - height / 2) / focal)[..., None]
        by_x, by_y = right / focal, -up / focal
        with np.errstate(divide="ignore", invalid="ignore"):
            distance = np.where(ray[..., 2] < 0, -camera.height / ray[..., 2], np.nan)
            position = ray * distance[..., None]
            along = position[..., :2] + np.array([camera.lateral, camera.distance])
            scale = np.array([road.width, road.segment])
            uv = along / scale + np.array([0.5, 0.0])
            derivatives = [
                (step[:2] * distance[..., None] - ray[..., :2] * (distance / ray[..., 2] * step[2])[..., None]) / scale
                for step in (by_x * view.pitch[0], by_y * view.pitch[1])
            ]
            ahead = position[..., 1]
            hit = (np.abs(along[..., 0]) <= road.width / 2) & (ahead >= -road.segment) & (ahead <= road.length)
        return hit, position, uv, *derivatives

    def centres(self):
        """Image-plane places of the frame's pixel centres."""
        view = self.sequence.view(self.frame)
        j, i = np.mgrid[: view.height, : view.width]
        return view.origin[0] + (i + 0.5) * view.pitch[0], view.origin[1] + (j + 0.5) * view.pitch[1]

    def shade(self, texel, position, inputs="box"):
        """The deck's Blinn-Phong on a flat road, or what filtered moments make of it."""
        sun = self.sequence.scene.sun
        azimuth, elevation = np.radians(sun.azimuth), np.radians(sun.elevation)
        light = np.array([np.cos(elevation) * np.sin(azimuth), np.cos(elevation) * np.cos(azimuth), np.sin(elevation)])
        half = unit(light - unit(position))
        normal, power = lobe_of(texel, inputs)
        specular = np.clip((normal * half).sum(-1), 0, 1) ** power * power * texel[..., 6]
        if inputs == "lean":
            specular = gaussian_of_slopes(texel, half) * texel[..., 6]
        lambert = np.clip(normal @ light, 0, 1) * sun.diffuse
        return texel[..., :3] * lambert[..., None] + specular[..., None]

    def picture(self, technique, **settings):
        """Hit mask [H, W] and radiance [H, W, 3] under a technique."""
        if technique == "supersample":
            return self._supersampled(**settings)
        hit, position, uv, dx, dy = self.surface(*self.centres())
        position, uv, dx, dy = position[hit], uv[hit], dx[hit], dy[hit]
        if technique == "tsl":
            colour = self._texture_space(uv, dx, dy, **settings)
        elif technique in MOMENTS:
            texel = anisotropic(self.chain(technique), uv, dx, dy, settings.get("anisotropy", 16))
            colour = self.shade(texel, position, technique)
        elif technique == "specular-aa":
            colour = self.shade(self._widened(uv, dx, dy, **settings), position)
        else:
            colour = self.shade(self._filter(technique, uv, dx, dy, **settings), position)
        out = np.zeros((*hit.shape, 3))
        out[hit] = colour
        return hit, out

    def reference(self, n, seed):
        """Mean of n x n samples a pixel, jittered by numpy's own random numbers, and the standard error of it."""
        view, rng = self.sequence.view(self.frame), np.random.default_rng(seed)
        total = squares = 0.0
        j, i = np.mgrid[: view.height, : view.width]
        for cell in np.ndindex(n, n):
            x = view.origin[0] + (i + (cell[1] + rng.random(i.shape)) / n) * view.pitch[0]
            y = view.origin[1] + (j + (cell[0] + rng.random(i.shape)) / n) * view.pitch[1]
            hit, position, uv, _, _ = self.surface(x, y)
            colour = np.zeros((*hit.shape, 3))
            colour[hit] = self.shade(bilinear(self.maps, uv[hit]), position[hit])
            total, squares = total + colour, squares + colour**2
        mean = total / n**2
        return mean, np.sqrt(np.maximum(squares / n**2 - mean**2, 0) / n**2)

    def _supersampled(self, samples=4, anisotropy=16):
        """Where all places of a regular grid hit, and their mean radiance."""
        view, n = self.sequence.view(self.frame), round(samples**0.5)
        total = hits = 0.0
        j, i = np.mgrid[: view.height, : view.width]
        for cell in np.ndindex(n, n):
            x = view.origin[0] + (i + (cell[1] + 0.5) / n) * view.pitch[0]
            y = view.origin[1] + (j + (cell[0] + 0.5) / n) * view.pitch[1]
            hit, position, uv, dx, dy = self.surface(x, y)
            colour = np.zeros((*hit.shape, 3))
            texel = anisotropic(self.chain(), uv[hit], dx[hit] / n, dy[hit] / n, anisotropy)
            colour[hit] = self.shade(texel, position[hit])
            total, hits = total + colour / n**2, hits + hit
        return hits == n**2, total

    def _widened(self, uv, dx, dy, variance=0.15, threshold=0.2, anisotropy=16):
        """Filtered texels with the power lowered by how fast their normals turn from pixel to pixel."""
        texel, right, down = (anisotropic(self.chain(), uv + by, dx, dy, anisotropy) for by in (0, dx, dy))
        turns = sum(((unit(each[:, 3:6]) - unit(texel[:, 3:6])) ** 2).sum(1) for each in (right, down))
        squared = np.minimum(2 / (texel[:, 7] + 2) + np.minimum(2 * variance * turns, threshold), 1)
        texel[:, 7] = 2 / squared - 2
        return texel

    def _filter(self, technique, uv, dx, dy, start=0.0, end=4.0, anisotropy=16):
        texels = np.array(self.maps.shape[1::-1])
        longest = np.maximum(np.linalg.norm(dx * texels, axis=-1), np.linalg.norm(dy * texels, axis=-1))
        if technique == "pixel-point":
            cell = np.floor(uv * texels).astype(int) % texels
            return self.maps[cell[:, 1], cell[:, 0]]
        if technique == "pixel-bilinear":
            return bilinear(self.maps, uv)
        if technique == "pixel-trilinear":
            return trilinear(self.chain(), uv, np.log2(longest))
        texel = anisotropic(self.chain(), uv, dx, dy, anisotropy)
        if technique == "lod-hack":
            texel[:, 3:5] *= np.clip((end - np.log2(longest)) / (end - start), 0, 1)[:, None]
        return texel

    def _texture_space(self, uv, dx, dy, size=1024, anisotropy=16, inputs="box"):
        road, camera = self.sequence.scene.road, self.sequence.view(self.frame).camera
        owner = np.floor(uv[:, 1]).astype(int)
        out = np.zeros((len(uv), 3))
        j, i = np.mgrid[:size, :size]
        for segment in np.unique(owner):
            place = np.stack([(i + 0.5) / size, (j + 0.5) / size], axis=-1)
            position = np.empty((size, size, 3))
            position[..., 0] = (place[..., 0] - 0.5) * road.width - camera.lateral
            position[..., 1] = (place[..., 1] + segment) * road.segment - camera.distance
            position[..., 2] = -camera.height
            lod = np.log2(max(self.maps.shape[:2]) / size)
            texel = trilinear(self.chain(inputs), place.reshape(-1, 2), np.full(size * size, lod))
            lit = self.shade(texel.reshape(size, size, -1), position, inputs)
            inside = (position[..., 1] >= -road.segment) & (position[..., 1] <= road.length)
            target = np.concatenate([lit, np.ones((size, size, 1))], axis=-1) * inside[..., None]
            mine = owner == segment
            local = uv[mine] - np.array([0, segment])
            colour = anisotropic(mip_levels(target), local, dx[mine], dy[mine], anisotropy, clamps=True)
            alpha = colour[:, 3:]
            out[mine] = np.where(alpha > 1e-5, colour[:, :3] / np.maximum(alpha, 1e-5), colour[:, :3])
        return out


MOMENTS = ("toksvig", "vmf", "clean", "lean")


def moments_of(maps, inputs):
    """What a chain holds: the maps; albedo, normal, Ks, 1/power; or albedo, slopes, Ks and their second moments."""
    if inputs == "box":
        return maps
    variance = 1 / maps[..., 7:]
    if inputs in ("toksvig", "vmf"):
        return np.concatenate([maps[..., :7], variance], axis=-1)
    x, y = maps[..., 3:4] / maps[..., 5:6], maps[..., 4:5] / maps[..., 5:6]
    seconds = [x * x + y * y + 2 * variance] if inputs == "clean" else [x * x + variance, y * y + variance, x * y]
    return np.concatenate([maps[..., :3], x, y, 0 * x, maps[..., 6:7], *seconds], axis=-1)


def lobe_of(texel, inputs):
    """Unit normal and power of filtered moments."""
    if inputs in ("clean", "lean"):
        normal = unit(np.concatenate([texel[..., 3:5], np.ones_like(texel[..., :1])], axis=-1))
        squared = (texel[..., 3:5] ** 2).sum(-1)
        return normal, 2 / (texel[..., 7] - squared) if inputs == "clean" else np.ones_like(squared)
    length = np.minimum(np.linalg.norm(texel[..., 3:6], axis=-1), 1)
    power = texel[..., 7]
    if inputs == "toksvig":
        power = 1 / power
        power = power * length / (length + power * (1 - length))
    elif inputs == "vmf":
        power = 1 / power
        with np.errstate(divide="ignore", invalid="ignore"):
            kappa = (3 * length - length**3) / (1 - length**2)
            power = np.where(length < 1, power * kappa / (power + kappa), power)
    return unit(texel[..., 3:6]), power


def gaussian_of_slopes(texel, half):
    """exp(-1/2 (h - b)^T S^-1 (h - b)) / sqrt(det S) by numpy's own inverse."""
    b = texel[..., 3:5]
    second = texel[..., [7, 9, 9, 8]].reshape(*b.shape[:-1], 2, 2)
    covariance = second - b[..., :, None] * b[..., None, :]
    away = half[..., :2] / half[..., 2:] - b
    exponent = np.einsum("...i,...ij,...j->...", away, np.linalg.inv(covariance), away)
    return np.exp(-exponent / 2) / np.sqrt(np.linalg.det(covariance))


def unit(v):
    return v / np.linalg.norm(v, axis=-1, keepdims=True)


def mip_levels(image):
    levels = [np.asarray(image, np.float64)]
    while max(levels[-1].shape[:2]) > 1:
        below = levels[-1]
        for axis in (0, 1):
            if below.shape[axis] > 1:
                even = [slice(None)] * 3
                odd = [slice(None)] * 3
                even[axis], odd[axis] = slice(0, None, 2), slice(1, None, 2)
                below = (below[tuple(even)] + below[tuple(odd)]) / 2
        levels.append(below)
    return levels


def bilinear(image, uv, clamps=False):
    height, width = image.shape[:2]
    x, y = uv[:, 0] * width - 0.5, uv[:, 1] * height - 0.5
    i, j = np.floor(x).astype(int), np.floor(y).astype(int)
    a, b = (x - i)[:, None], (y - j)[:, None]

    def at(column, row):
        if clamps:
            return image[np.clip(row, 0, height - 1), np.clip(column, 0, width - 1)]
        return image[row % height, column % width]

    return (at(i, j) * (1 - a) + at(i + 1, j) * a) * (1 - b) + (at(i, j + 1) * (1 - a) + at(i + 1, j + 1) * a) * b


def trilinear(chain, uv, lod, clamps=False):
    lod = np.clip(lod, 0, len(chain) - 1)
    level = np.floor(lod).astype(int)
    out = np.zeros((len(uv), chain[0].shape[2]))
    for each in np.unique(level):
        mine = level == each
        blend = (lod[mine] - each)[:, None]
        upper = bilinear(chain[min(each + 1, len(chain) - 1)], uv[mine], clamps)
        out[mine] = bilinear(chain[each], uv[mine], clamps) * (1 - blend) + upper * blend
    return out


def anisotropic(chain, uv, dx, dy, most, clamps=False):
    texels = np.array(chain[0].shape[1::-1])
    jacobian = np.stack([dx * texels, dy * texels], axis=-1)
    left, singular, _ = np.linalg.svd(jacobian)
    major, minor = singular[:, 0], singular[:, 1]
    probes = np.where(major <= 1, 1, np.minimum(np.ceil(major / np.maximum(minor, 1e-300) - 1e-6), most)).astype(int)
    lod = np.log2(major / probes)
    out = np.zeros((len(uv), chain[0].shape[2]))
    for count in np.unique(probes):
        mine = probes == count
        step = left[mine, :, 0] * major[mine, None] / texels
        for probe in range(count):
            place = uv[mine] + step * ((probe + 0.5) / count - 0.5)
            out[mine] += trilinear(chain, place, lod[mine], clamps) / count
    return out
