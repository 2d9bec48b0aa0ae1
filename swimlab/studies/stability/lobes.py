"""Hard cases of the highlight: large powers, light and eye nearly opposite, 0/0, normals that cancel, low suns."""

from collections.abc import Callable, Iterable
from typing import Any, NamedTuple

import numpy as np
import warp as wp
from numpy.typing import ArrayLike, NDArray

from metrics.kernels.launch import Launcher
from swimlab.render.brdf import Model
from swimlab.render.catalogue import brdfs
from swimlab.render.kernels.inspection import shaded_samples
from swimlab.render.kernels.packet import plain_packet
from swimlab.render.kernels.shading import in_local_frame
from swimlab.render.kernels.structs import LANES, Sun, Texel
from swimlab.studies.stability.twin import Doubles, Error, compare, radiance, unit

SAMPLES = 128 * LANES
EYE = 1.3
"""Height of the eye, m."""
STEP = np.array([0.0, 0.001, 0.0])
"""How far the eye goes between two frames, m."""
POWERS = (1.0, 10.0, 100.0, 1e3, 1e4, 1e5)
LENGTHS = (1.0, 1e-2, 1e-4, 1e-6)

Shade = Callable[[Doubles, Doubles, Doubles], NDArray[Any]]
"""(texels [N, 8], places relative to the eye [N, 3], direction to the light) -> radiance [N, 3]."""


class Lobes(NamedTuple):
    """The highlight by a dot product and a power in single precision, by the plain form, by the native form."""

    naive: Error
    plain: Error
    native: Error


def model(name: str, **parameters: object) -> Model:
    """A reflectance model by name."""
    brdf = brdfs()[name]
    return brdf.model(brdf.settings.model_validate(parameters))


def form(launcher: Launcher, shade_packet: wp.Function, *, diffuse: float = 0.6) -> Shade:
    """A packet's shading as a function of arrays."""
    kernel = shaded_samples(shade_packet, 8)

    def shade(texels: Doubles, places: Doubles, light: Doubles) -> NDArray[Any]:
        out = launcher.zeros(len(texels), wp.vec3)
        sun: Any = Sun()
        sun.direction, sun.diffuse = wp.vec3(*light.tolist()), diffuse
        inputs = [launcher.array(np.float32(texels), Texel), launcher.array(np.float32(places), wp.vec3), sun, out]
        launcher.launch(kernel, len(texels) // LANES, inputs)
        return np.asarray(out.numpy())

    return shade


def plain(launcher: Launcher, chosen: Model) -> Shade:
    """A model as it is read."""
    return form(launcher, plain_packet(in_local_frame(chosen.evaluate, 8), 8))


def native(launcher: Launcher, chosen: Model) -> Shade:
    """A model in its form for CPUs."""
    assert chosen.native is not None
    return form(launcher, chosen.native)


def naive(texels: Doubles, places: Doubles, light: Doubles) -> NDArray[Any]:
    """Blinn-Phong as it is first written down, all in single precision; no diffuse light."""
    position, normal = np.float32(places), np.float32(texels[:, 3:6])
    half = np.float32(light) - position / np.sqrt(np.sum(position * position, axis=1, keepdims=True))
    half /= np.sqrt(np.sum(half * half, axis=1, keepdims=True))
    normal = normal / np.sqrt(np.sum(normal * normal, axis=1, keepdims=True))
    cosine = np.maximum(np.sum(normal * half, axis=1), np.float32(0))
    power = np.float32(texels[:, 7])
    return np.repeat((cosine**power * power * np.float32(texels[:, 6]))[:, None], 3, axis=1)


def toward(azimuth: float, elevation: float) -> Doubles:
    """Direction to a sun, degrees."""
    a, e = np.radians([azimuth, elevation])
    return np.array([np.cos(e) * np.sin(a), np.cos(e) * np.cos(a), np.sin(e)])


def highlight(azimuth: float, elevation: float, distance: float, power: float) -> tuple[Doubles, list[Doubles]]:
    """Texels [N, 8] whose normals lie about the half vector, within the lobe, and their places in two frames.

    They lie about `distance` metres away below the sun's azimuth.
    """
    rng = np.random.default_rng(0)
    ahead = distance * rng.uniform(0.9, 1.1, SAMPLES)
    aside = rng.uniform(-1, 1, SAMPLES)
    c, s = np.cos(np.radians(azimuth)), np.sin(np.radians(azimuth))
    place = np.stack([aside * c + ahead * s, ahead * c - aside * s, np.full(SAMPLES, -EYE)], axis=1)
    half = unit(toward(azimuth, elevation) - unit(place))
    texels = np.zeros((SAMPLES, 8))
    texels[:, 3:6] = unit(half + rng.normal(0, 1 / np.sqrt(power), (SAMPLES, 3)))
    texels[:, 6:] = 1.0, power
    return texels.astype(np.float32).astype(np.float64), [place, place - STEP]


def lobes_of(launcher: Launcher, azimuth: float, elevation: float, distance: float, power: float) -> Lobes:
    """Errors of the highlight as fractions of its peak."""
    texels, places = highlight(azimuth, elevation, distance, power)
    light, chosen = toward(azimuth, elevation), model("blinn-phong")
    exact = [radiance(texels, place, light, 0.0) for place in places]

    def error(shade: Shade) -> Error:
        return compare([shade(texels, place, light) for place in places], exact, scale=power)

    return Lobes(error(naive), error(plain(launcher, chosen)), error(native(launcher, chosen)))


def powers(launcher: Launcher) -> dict[float, Lobes]:
    """By power, at 20 m under the sun of the library's sequences."""
    return {power: lobes_of(launcher, 4, 14, 20, power) for power in POWERS}


def low_suns(launcher: Launcher) -> dict[tuple[float, float], Lobes]:
    """By power and distance, m, towards a sun on the horizon, where light and eye come to be opposite."""
    return {
        (power, distance): lobes_of(launcher, 4, 0, distance, power)
        for power in (200.0, 1e4)
        for distance in (20.0, 200.0, 2e3, 2e4)
    }


def cancelled(launcher: Launcher) -> dict[float, Error]:
    """By the length of a mean of two normals that all but cancel: radiance, as a fraction of what it is at rms.

    In two frames other pairs have the same mean; what differs is their rounding to single precision.
    """
    texels, places = highlight(4, 14, 20, 20.0)
    texels[:, :3] = 0.5
    rng, shade = np.random.default_rng(1), native(launcher, model("blinn-phong"))
    light, mean = toward(4, 14), texels[:, 3:6].copy()
    exact = radiance(texels, places[0], light, 0.6)
    errors = {}
    for length in LENGTHS:
        found = []
        for _ in range(2):
            one = np.float32(unit(rng.normal(size=mean.shape)))
            other = np.float32(2 * length * mean - one)
            given = texels.copy()
            given[:, 3:6] = (one + other) / np.float32(2)
            found.append(shade(given, places[0], light))
        errors[length] = compare(found, [exact, exact])
    return errors


class Degenerate(NamedTuple):
    """A case whose formula is 0/0 or 0^0: what it is by its limit, and what both forms give (None: the form does not
    exist)."""

    name: str
    expected: float
    plain: float
    native: float | None


def degenerate(launcher: Launcher) -> list[Degenerate]:
    """Cases where formulas stumble."""
    up, flat = np.array([0.0, 0.0, 1.0]), np.array([0.0, 1.0, 0.0])
    oblique = unit([0.0, 3.0, 4.0])
    mirrored = oblique * np.array([1, -1, 1])
    ndf = model("blinn-phong", normalisation="ndf")
    shirley, drawn = (model("ashikhmin-shirley", anisotropy=a) for a in (1.0, 4.0))
    # At H = N: sqrt((nu + 1)(nv + 1)) / 8 F N.L / (H.V max(N.L, N.V)), here with F = Ks = 1 and all cosines .8.
    peak = [np.sqrt((100 / a + 1) * (100 * a + 1)) / 8 / 0.8 for a in (1.0, 4.0)]
    # Name, value, model, normal, light, eye, power.
    rows: list[tuple[str, float, Model, Doubles, Doubles, Doubles, float]] = [
        ("power 0 on the horizon, N.H = 0, factor (p + 2) / (2 pi)", 1 / np.pi, ndf, up, flat, flat, 0.0),
        ("power 0 below the horizon, N.H < 0", 1 / np.pi, ndf, -up, oblique, up, 0.0),
        ("normal of length 0", 0.0, model("blinn-phong"), 0 * up, oblique, mirrored, 100.0),
        ("light right behind the surface, L = -V", 0.0, model("blinn-phong"), up, -up, up, 100.0),
        ("H = N, power 1e5", 1e5, model("blinn-phong"), up, oblique, mirrored, 1e5),
        ("Ashikhmin-Shirley, H = N", peak[0], shirley, up, oblique, mirrored, 100.0),
        ("Ashikhmin-Shirley drawn out 4:1, H = N", peak[1], drawn, up, oblique, mirrored, 100.0),
    ]
    found = []
    for name, expected, chosen, normal, light, eye, power in rows:
        texels = np.tile(np.concatenate([[0, 0, 0], normal, [1, power]]), (LANES, 1))
        places = np.tile(-eye * 10, (LANES, 1))
        shown = [float(shade(texels, places, light)[0, 0]) for shade in _forms(launcher, chosen)]
        found.append(Degenerate(name, float(expected), shown[0], shown[1] if len(shown) > 1 else None))
    return found


def _forms(launcher: Launcher, chosen: Model) -> Iterable[Shade]:
    yield plain(launcher, chosen)
    if chosen.native is not None:
        yield native(launcher, chosen)


class Soundness(NamedTuple):
    """Of a model at extreme inputs: evaluations, how many came out NaN or infinite, how many negative."""

    evaluations: int
    bad: int
    negative: int


def soundness(launcher: Launcher) -> dict[str, Soundness]:
    """Every reflectance model under every combination of extreme normals, lights, eyes, powers and Ks."""
    tiny = 1e-6
    directions = [(0, 0, 1), (0, 0, -1), (0, 1, 0), (0, -1, 0), (1, 0, 0), (0, 1, tiny), (0, -1, tiny), (tiny, 0, 1)]
    directions += [(0, 3, 4), (0, -3, 4), (0, 3, -4), (1, 1, 1e-3), (1, 1, -1e-3)]
    extremes = unit(directions)
    normals = np.concatenate([extremes, extremes[:2] * 1e-3, extremes[:1] * 1e-20, np.zeros((1, 3))])
    numbers = np.array([(ks, power) for ks in (0.0, 1.0) for power in (0.0, 1e-4, 1.0, 1e3, 1e5)])
    at = np.array(list(np.ndindex(len(normals), len(extremes), len(numbers)))).T
    texels = np.concatenate([np.full((at.shape[1], 3), 0.5), normals[at[0]], numbers[at[2]]], axis=1)
    eyes = extremes[at[1]]
    padded = -(-len(texels) // LANES) * LANES
    texels, places = (np.resize(each, (padded, each.shape[1])) for each in (texels, -10 * eyes))
    found = {}
    for name in brdfs():
        for shade, label in zip(_forms(launcher, model(name)), (name, f"{name}, native"), strict=False):
            values: ArrayLike = np.array([shade(texels, places, light) for light in extremes])
            bad = ~np.isfinite(values)
            found[label] = Soundness(bad.size // 3, int(bad.sum()), int(np.sum(np.asarray(values)[~bad] < 0)))
    return found
