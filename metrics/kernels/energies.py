"""Sums over locked spectra that follow a clip: one pass over memory where array operations take ten.

Of a tile each lane sums single precision over some hundred numbers; lanes are summed in double precision. Spectra live
in the host's memory, so these run on the CPU. A spectrum's real and imaginary parts stand in turns.
"""

import warp as wp

from metrics.kernels.forms import Twins, Within, form
from metrics.kernels.making import made_once
from metrics.octaves import OCTAVES

wp.set_module_options({"enable_backward": False})

LANES = 16
"""Numbers that are summed side by side."""

_CODE = """
    typedef float lanes __attribute__((ext_vector_type(%(lanes)d)));
    typedef int which __attribute__((ext_vector_type(%(lanes)d)));
    const int channels = spectra.shape[1], parts = spectra.shape[2];
    const float* const seen = (const float*)spectra.data + (long)tile*channels*parts;
    const int* const octave = (const int*)octaves.data;
    %(state)s
    lanes sums[%(octaves)d] = {};
    for (int part = 0; part < parts; part += %(lanes)d) {
        lanes squares = 0.0f;
        for (int channel = 0; channel < channels; ++channel) {
            const long at = (long)channel*parts + part;
            lanes value;
            __builtin_memcpy(&value, seen + at, sizeof(value));
            %(follow)s
            squares += value*value;
        }
        which here;
        __builtin_memcpy(&here, octave + part, sizeof(here));
        for (int number = 0; number < %(octaves)d; ++number) sums[number] += here == number ? squares : 0.0f;
    }
    for (int number = 0; number < %(octaves)d; ++number) {
        double sum = 0.0;
        for (int lane = 0; lane < %(lanes)d; ++lane) sum += sums[number][lane];
        ((double*)energies.data)[(long)tile*%(octaves)d + number] = sum;
    }
"""

_FOLLOW = """
            lanes last;
            __builtin_memcpy(&last, held + at, sizeof(last));
            const lanes away = value - last, next = share == 1.0f ? value : last + share*away;
            __builtin_memcpy(held + at, &next, sizeof(next));
            value = away;
"""
_POWER = """
    const int channels = spectra.shape[1], bins = spectra.shape[2]/2;
    const float* const seen = (const float*)spectra.data + (long)tile*channels*2*bins;
    float* const to = (float*)power.data + (long)tile*bins;
    for (int bin = 0; bin < bins; ++bin) to[bin] = 0.0f;
    for (int channel = 0; channel < channels; ++channel) {
        const float* const from = seen + (long)channel*2*bins;
        #pragma clang loop vectorize(enable)
        for (int bin = 0; bin < bins; ++bin) to[bin] += from[2*bin]*from[2*bin] + from[2*bin + 1]*from[2*bin + 1];
    }
"""
_NUMBERS = {"lanes": LANES, "octaves": len(OCTAVES)}
_HELD = "float* const held = (float*)state.data + (long)tile*channels*parts;"


_AGREES = Within("parseval", floor=0.0)


@form(agrees=_AGREES)
def octave_sums() -> Twins:
    """The function that sums a tile's squares by the octave of each part.

    spectra: [n, channels, parts]. octaves: [parts]. energies: [n, octaves].
    """

    @wp.func(module="unique")
    def add(
        tile: wp.int32,
        spectra: wp.array3d(dtype=wp.float32),
        octaves: wp.array(dtype=wp.int32),
        energies: wp.array2d(dtype=wp.float64),
    ):
        for number in range(energies.shape[1]):
            energies[tile, number] = wp.float64(0.0)
        for channel in range(spectra.shape[1]):
            for part in range(spectra.shape[2]):
                value = wp.float64(spectra[tile, channel, part])
                energies[tile, octaves[part]] += value * value

    return Twins(add, _CODE % {**_NUMBERS, "state": "", "follow": ""})


@form(agrees=_AGREES)
def following() -> Twins:
    """The function that moves a tile's state [n, channels, parts] by a share of the way to spectra, all of it at 1.

    It sums the squares of the ways as `octave_sums` does.
    """

    @wp.func(module="unique")
    def follow(
        tile: wp.int32,
        state: wp.array3d(dtype=wp.float32),
        spectra: wp.array3d(dtype=wp.float32),
        share: wp.float32,
        octaves: wp.array(dtype=wp.int32),
        energies: wp.array2d(dtype=wp.float64),
    ):
        for number in range(energies.shape[1]):
            energies[tile, number] = wp.float64(0.0)
        for channel in range(spectra.shape[1]):
            for part in range(spectra.shape[2]):
                value = spectra[tile, channel, part]
                last = state[tile, channel, part]
                away = value - last
                state[tile, channel, part] = wp.where(share == 1.0, value, last + share * away)
                energies[tile, octaves[part]] += wp.float64(away) * wp.float64(away)

    return Twins(follow, _CODE % {**_NUMBERS, "state": _HELD, "follow": _FOLLOW})


@form(agrees=_AGREES)
def bin_sums() -> Twins:
    """The function that sums a tile's squares over channels and both parts of every bin, [n, bins]."""

    @wp.func(module="unique")
    def add(tile: wp.int32, spectra: wp.array3d(dtype=wp.float32), power: wp.array2d(dtype=wp.float32)):
        for bin in range(power.shape[1]):
            power[tile, bin] = 0.0
            for channel in range(spectra.shape[1]):
                re = spectra[tile, channel, 2 * bin]
                im = spectra[tile, channel, 2 * bin + 1]
                power[tile, bin] += re * re + im * im

    return Twins(add, _POWER)


@made_once
def octave_energies() -> wp.Kernel:
    """The kernel that runs `octave_sums`, a tile a thread."""
    add = octave_sums().native

    @wp.kernel(module="unique", enable_backward=False)
    def kernel(
        spectra: wp.array3d(dtype=wp.float32),
        octaves: wp.array(dtype=wp.int32),
        energies: wp.array2d(dtype=wp.float64),
    ):
        add(wp.tid(), spectra, octaves, energies)

    return kernel


@made_once
def following_energies() -> wp.Kernel:
    """The kernel that runs `following`, a tile a thread."""
    follow = following().native

    @wp.kernel(module="unique", enable_backward=False)
    def kernel(
        state: wp.array3d(dtype=wp.float32),
        spectra: wp.array3d(dtype=wp.float32),
        share: wp.float32,
        octaves: wp.array(dtype=wp.int32),
        energies: wp.array2d(dtype=wp.float64),
    ):
        follow(wp.tid(), state, spectra, share, octaves, energies)

    return kernel


@made_once
def bin_energies() -> wp.Kernel:
    """The kernel that runs `bin_sums`, a tile a thread."""
    add = bin_sums().native

    @wp.kernel(module="unique", enable_backward=False)
    def kernel(spectra: wp.array3d(dtype=wp.float32), power: wp.array2d(dtype=wp.float32)):
        add(wp.tid(), spectra, power)

    return kernel
