"""Hard cases of whole frames: horizons, suns, kilometres, tiny steps, views through the eye plane, maps of a texel."""

from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np
import warp as wp
from numpy.typing import NDArray

from metrics.kernels.launch import Launcher, Strip
from sequences import Sequence, load
from swimlab.render.catalogue import model_of, techniques
from swimlab.render.inputs import Maps
from swimlab.render.kernels.inspection import filtered_samples, shaded_samples, surfaces
from swimlab.render.kernels.structs import LANES, Sun, Texel
from swimlab.render.kernels.texture_filter import anisotropic_to
from swimlab.render.kernels.texture_space import unpremultiplication
from swimlab.render.material import Material
from swimlab.render.mesh import ROWS_PER_WAVE
from swimlab.render.shot import Shot
from swimlab.render.texture import MipChain
from swimlab.render.triangles import visibility
from swimlab.studies.stability.twin import Doubles, Error, Twin, chain, compare, rms, stretched

SIZE = (96, 54)
ASPECTS = (1.0, 16.0, 100.0, 1e3, 1e4)
SEGMENT = 8.0
"""Metres that the maps repeat after, in the library's sequences."""
START = 3.7
"""Where drives begin, m: a place that is not a round number in binary."""
DISTANCES = (8e3, 8e5, 1e7, 8e8)
GREY = 0.5
SETTINGS: dict[str, dict[str, Any]] = {"tsl": {"size": 64}, "taa": {"preroll": 2}, "vertex": {"quads": [4, 4]}}
"""Of techniques where the defaults would be slow here."""


@dataclass(frozen=True)
class Frames:
    """Renders small frames of a sequence with given maps."""

    launcher: Launcher
    maps: Maps

    def shot(self, sequence: Sequence, frame: int) -> Shot:
        """A frame before any technique."""
        return Shot(sequence, frame, Material(self.launcher, self.maps), model_of(sequence), 4, self.launcher)

    def picture(self, sequence: Sequence, frame: int, name: str) -> NDArray[np.float32]:
        """A frame [H, W, 4] under a technique."""
        technique = techniques()[name]
        return technique.render(self.shot(sequence, frame), technique.settings(**SETTINGS.get(name, {}))).rgba

    def error(self, sequence: Sequence, name: str, *, most: int | None) -> Error:
        """Radiance of two frames against the same in double precision, as fractions of its rms."""
        twin, found, exact = Twin(sequence, self.maps), [], []
        for frame in (0, 1):
            rgba = self.picture(sequence, frame, name)
            hit, colour = twin.radiance(frame, most=most)
            image = np.zeros((*hit.shape, 3))
            image[hit] = colour
            # A sample on the road's very edge may fall on either side of it.
            both = (hit & (rgba[..., 3] > 0))[..., None]
            found.append(np.where(both, rgba[..., :3], 0))
            exact.append(np.where(both, image, 0))
        return compare(found, exact)


def base(**changes: Any) -> Sequence:
    """The library's road-shift at a small size; `changes` of its tables are added to what they hold."""
    sequence = load("road-shift").with_changes(size=SIZE, frames=2)
    merged = {}
    for key, value in changes.items():
        before = getattr(sequence, key).model_dump()
        merged[key] = value if key == "motion" else {**before, **value}
    return sequence.with_changes(**merged)


def scene(**changes: Any) -> dict[str, Any]:
    """Changes of tables of the scene, each added to what it holds."""
    before = load("road-shift").scene.model_dump()
    return {key: {**before[key], **value} for key, value in changes.items()}


def footprints(launcher: Launcher) -> dict[float, Error]:
    """Anisotropic filters of random values 0..1 by the footprint's aspect, as fractions of 1.

    In two frames the footprints are 1/1024 of their length apart.
    """
    rng = np.random.default_rng(0)
    side, count = 64, 64 * LANES
    device = MipChain.allocate(launcher, width=side, height=side, dtype=Texel, clamps=False)
    texels = rng.random((side, side, 8), np.float32)
    device.texels[: side * side].assign(texels.reshape(-1, 8))
    device.reduce(launcher)
    levels = chain(texels.astype(np.float64))
    kernel = filtered_samples(anisotropic_to(16).fill(8, launcher.device), 8)
    found = {}
    for aspect in ASPECTS:
        uv = rng.random((count, 2))
        angle, turn = rng.uniform(0, 2 * np.pi, (2, count, 1))
        minor = 10.0 ** rng.uniform(-3, -1, (count, 1)) / np.sqrt(aspect)
        across = np.concatenate([np.cos(angle), np.sin(angle)], axis=1) * minor * aspect
        along = np.concatenate([-np.sin(angle), np.cos(angle)], axis=1) * minor
        dx, dy = across * np.cos(turn) + along * np.sin(turn), along * np.cos(turn) - across * np.sin(turn)
        frames, exact = [], []
        for step in (0.0, 1 / 1024):
            places = np.concatenate([uv + step * across, dx, dy], axis=1)
            packets = np.ascontiguousarray(places.reshape(-1, LANES, 6).transpose(0, 2, 1)).reshape(-1, 6 * LANES)
            out = launcher.zeros((len(packets), 8 * LANES), wp.float32)
            inputs = [device.texels, device.shape, LANES, launcher.array(packets, wp.float64), out]
            launcher.launch(kernel, len(packets), inputs)
            frames.append(out.numpy().reshape(-1, 8, LANES).transpose(0, 2, 1).reshape(-1, 8))
            exact.append(stretched(levels, places[:, :2], dx, dy, 16))
        found[aspect] = compare(frames, exact, scale=1.0)
    return found


def views(launcher: Launcher, maps: Maps) -> dict[str, tuple[Error, Error]]:
    """Frames under hard views and suns: pixel-bilinear and pixel-aniso against double precision."""
    endless = scene(road={"length": 1e4})
    cases = {"as in the library": base()}
    cases["eye 5 cm above an endless road, level"] = base(camera={"height": 0.05, "pitch": 0.0}, scene=endless)
    low = scene(road={"length": 1e4}, sun={"elevation": 0.0})
    cases["the same, sun on the horizon"] = base(camera={"height": 0.05, "pitch": 0.0}, scene=low)
    cases["straight down, 5 cm above the road"] = base(camera={"height": 0.05, "pitch": -90.0})
    cases["up, road only at the lower edge"] = base(camera={"pitch": 20.0})
    for azimuth, elevation, name in ((184, 14, "behind"), (4, 0, "on the horizon"), (4, 90, "overhead")):
        cases[f"sun {name}"] = base(scene=scene(sun={"azimuth": azimuth, "elevation": elevation}))
    cases["sun below the road"] = base(scene=scene(sun={"elevation": -30.0}))
    cases["1/1024 px a frame"] = base(motion={"kind": "shift", "velocity": [1 / 1024, 1 / 1024]})
    cases["10,000 km away"] = base(camera={"distance": 1e7 + START})
    frames = Frames(launcher, maps)
    return {
        name: (frames.error(case, "pixel-bilinear", most=None), frames.error(case, "pixel-aniso", most=16))
        for name, case in cases.items()
    }


class Drive(NamedTuple):
    """Frames at a distance against the same at the start, as fractions of the brightest and of the rms.

    largest: of the difference on a flat road. flicker: rms of its change between two frames. hills: largest on hills.
    naive: what single-precision coordinates along the road would be off by, texels of a map of 1024.
    """

    largest: float
    flicker: float
    hills: float
    naive: float


def drives(launcher: Launcher, maps: Maps, name: str) -> dict[float, Drive]:
    """By metres driven, whole segments and waves of the hills: frames under a technique that should not change."""
    frames = Frames(launcher, maps)
    roads = [load(road).with_changes(size=SIZE) for road in ("road-drive", "road-hills")]

    def pictures(road: Sequence, distance: float) -> list[NDArray[np.float32]]:
        camera = road.camera.model_dump() | {"distance": START + distance}
        return [frames.picture(road.with_changes(camera=camera), frame, name) for frame in (0, 1)]

    found = {}
    at_start = [pictures(road, 0.0) for road in roads]
    for distance in DISTANCES:
        differences = []
        for road, before in zip(roads, at_start, strict=True):
            after = pictures(road, distance)
            differences.append([np.float64(a) - b for a, b in zip(after, before, strict=True)])
        flat, hills = (
            max(np.abs(each).max() for each in pair) / max(each.max() for each in before)
            for pair, before in zip(differences, at_start, strict=True)
        )
        flicker = rms(differences[0][1] - differences[0][0]) / rms(at_start[0])
        naive = float(np.spacing(np.float32(distance / SEGMENT))) * 1024
        found[distance] = Drive(float(flat), flicker, float(hills), naive)
    return found


class Step(NamedTuple):
    """Sample places after some frames of 1/1024 px a frame: their largest error, px; and whether after whole pixels
    the picture is the first one moved, to the bit."""

    error: float
    same: bool


def tiny_steps(launcher: Launcher, maps: Maps) -> dict[int, Step]:
    """By frames. Places are found from what they see of the road, whose motion is known."""
    sequence = base(motion={"kind": "shift", "velocity": [1 / 1024, 1 / 1024]})
    frames = Frames(launcher, maps)
    first = frames.picture(sequence, 0, "pixel-aniso")
    found = {}
    for frame in (1, 3, 1023, 1024, 4096):
        seen = Twin(sequence, maps).seen(frame)
        hit, uv, _ = looked_at(frames.shot(sequence, frame))
        both = seen.hit & hit
        away = (uv[both] - seen.uv[both[seen.hit]]) * [8.0, SEGMENT]
        away[:, 1] -= np.round(away[:, 1] / SEGMENT) * SEGMENT
        # In pixels: by the derivative that makes the least of a metre.
        pixel = np.min(np.linalg.norm(np.stack([seen.dx, seen.dy]) * [8.0, SEGMENT], axis=2), axis=0)
        error = float(np.max(np.linalg.norm(away, axis=1) / pixel[both[seen.hit]]))
        whole, part = divmod(frame, 1024)
        same = False
        if part == 0:
            moved = frames.picture(sequence, frame, "pixel-aniso")
            same = bool(np.array_equal(moved[whole:, whole:], first[:-whole, :-whole]))
        found[frame] = Step(error, same)
    return found


def looked_at(shot: Shot) -> tuple[NDArray[np.bool_], Doubles, Doubles]:
    """Of each pixel's centre: whether it sees anything, its uv and its place relative to the eye, m."""
    launcher, grid = shot.launcher, shot.grid()
    size = (grid.height, grid.width)
    visible = visibility(launcher, shot.triangles, grid, Strip(0, grid.height))
    uv, dx, dy = (launcher.zeros(size, wp.vec2d) for _ in range(3))
    position = launcher.zeros(size, wp.vec3d)
    launcher.launch(surfaces, size, [grid, visible, shot.triangles.planes, uv, dx, dy, position])
    return visible.numpy() >= 0, uv.numpy(), position.numpy()


class Crossing(NamedTuple):
    """A view whose eye plane cuts the road: pixels that see it, NaN or infinite values of what they see, and how far
    (m) the surface they see is off the road's polygons at its place."""

    pixels: int
    bad: int
    off: float


def crossings(launcher: Launcher, maps: Maps) -> dict[str, Crossing]:
    """Eyes close above a flat and a hilly road, looking down, back, aside and into a slope."""
    hills, frames = load("road-hills"), Frames(launcher, maps)
    found = {}
    for name, camera in {
        "down": {"pitch": -90.0},
        "back and down": {"pitch": -60.0, "yaw": 180.0},
        "aside": {"pitch": -20.0, "yaw": 90.0},
        "into a slope": {"pitch": 0.0, "distance": 24.0},
    }.items():
        for road, profile in ((load("road-drive"), "flat"), (hills, "hills")):
            low = road.camera.model_dump() | {"height": 0.05, **camera}
            sequence = road.with_changes(size=SIZE, camera=low)
            hit, uv, place = looked_at(frames.shot(sequence, 0))
            eye = sequence.camera.eye(sequence.scene.road)
            y = place[hit][:, 1] + eye[1]
            wave = sequence.scene.road.wavelength or SEGMENT
            rows = np.arange(
                np.floor(y.min(initial=0) / wave), np.ceil(y.max(initial=0) / wave) + 1e-9, 1 / ROWS_PER_WAVE
            )
            ground = np.interp(y, rows * wave, sequence.scene.road.height_at(rows * wave))
            off = np.abs(place[hit][:, 2] + eye[2] - ground)
            bad = int(np.sum(~np.isfinite(place)) + np.sum(~np.isfinite(uv)))
            found[f"{name}, {profile}"] = Crossing(int(hit.sum()), bad, float(off.max()))
    return found


def constant(width: int, height: int) -> Maps:
    """Grey maps of one value without a highlight."""
    normal = np.zeros((height, width, 3), np.float32)
    normal[..., 2] = 1
    gloss = np.zeros((height, width, 2), np.float32)
    gloss[..., 1] = 10
    return Maps(np.full((height, width, 3), GREY, np.float32), normal, gloss)


def expected(sequence: Sequence) -> float:
    """Radiance of a flat grey road without a highlight."""
    sun = sequence.sun(0)
    return float(GREY * sun.diffuse * sun.direction[2])


def flat_light(launcher: Launcher, sequence: Sequence, maps: Maps, name: str) -> tuple[float, int]:
    """Of covered pixels of a road of one colour: the largest relative error, and values that are NaN or infinite."""
    rgba = Frames(launcher, maps).picture(sequence, 0, name)
    whole = np.abs(rgba[..., 3] - 1) < 1e-6
    value = expected(sequence)
    off = np.abs(rgba[whole][:, :3].astype(np.float64) / value - 1)
    return float(off.max()), int(np.sum(~np.isfinite(rgba)))


def single_texels(launcher: Launcher) -> dict[str, list[tuple[float, int]]]:
    """By technique: a road of one colour from maps of 1x1, 1x8 and 8x1 texels."""
    sizes = [constant(1, 1), constant(8, 1), constant(1, 8)]
    return {name: [flat_light(launcher, base(), maps, name) for maps in sizes] for name in techniques()}


def faint_texels(launcher: Launcher) -> dict[int, tuple[float, float]]:
    """By the side of a target of which one texel is lit: alpha of its last level, and the relative error of its light
    once divided by alpha. Where the deck's rule, alpha > 1e-5, leaves it undivided the error is 1."""
    colour, found = np.float32(0.3), {}
    for side in (16, 64, 256, 512, 1024):
        target = MipChain.allocate(launcher, width=side, height=side, dtype=wp.vec4, clamps=True)
        lit = np.zeros((side * side, 4), np.float32)
        lit[side + 1] = colour, colour, colour, 1
        target.texels[: side * side].assign(lit)
        target.reduce(launcher)
        last = np.tile(target.texels.numpy()[-1], (LANES, 1))
        out = launcher.zeros(LANES, wp.vec3)
        inputs = [launcher.array(last, wp.vec4), launcher.zeros(LANES, wp.vec3), Sun(), out]
        launcher.launch(shaded_samples(unpremultiplication().native, 4), 1, inputs)
        found[side] = float(last[0, 3]), abs(float(out.numpy()[0, 0]) / float(colour) - 1)
    return found


def thin_charts(launcher: Launcher) -> dict[float, tuple[float, int]]:
    """TSL of a road of one colour whose last segment is drawn to a fraction only, and so is its target's alpha.

    The camera looks straight down at the road's end, from so near that the fraction is some pixels wide.
    """
    found = {}
    for fraction in (0.1, 1e-2, 1e-3, 1e-4, 1e-5):
        extent = SEGMENT * fraction
        height = max(4 * extent, 0.02)
        fov = max(1.0, 2 * float(np.degrees(np.arctan(2 * extent / height))))
        near = base(
            camera={"pitch": -90.0, "height": height, "fov": fov},
            scene=scene(road={"length": extent}),
        )
        found[fraction] = flat_light(launcher, near, constant(8, 8), "tsl")
    return found
