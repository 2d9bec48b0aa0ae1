"""Sums over locked spectra that follow a clip: one pass over memory where array operations take ten.

Of a tile each lane sums single precision over some hundred numbers; lanes are summed in double precision. Spectra live
in the host's memory, so these run on the CPU. A spectrum's real and imaginary parts stand in turns.
"""

import warp as wp

from metrics.kernels.forms import Twins, Within, form
from metrics.kernels.lanes import VECTORS
from metrics.kernels.making import made_once
from metrics.octaves import OCTAVES

wp.set_module_options({"enable_backward": False})

ENERGY, CHANGE, VARIED = range(3)
"""What is summed of spectra that are followed: their energy, that of the step since the frame before, and that of the
step from their mean so far."""

OTHER, DIFFERENCE = 3, 4
"""Of others that are followed beside them: the energy of their step from their mean, and of the difference of both."""

_CODE = """
    constexpr int O = %(octaves)d, S = %(sums)d;
    const int channels = spectra.shape[1], parts = spectra.shape[2];
    const long first = (long)tile*channels*parts;
    const auto rows = [&](const auto& array) { return (float*)array.data + first; };
    float* const seen = rows(spectra);
    %(rows)s
    const auto store = [](float* to, lanes value) { __builtin_memcpy(to, &value, sizeof(value)); };
    lanes sums[O][S] = {};
    for (int part = 0; part < parts; part += L) {
        lanes squares[S] = {};
        for (int channel = 0; channel < channels; ++channel) {
            const long at = (long)channel*parts + part;
            const lanes value = load(seen + at);
            squares[0] += value*value;
            %(follow)s
        }
        flags octave;
        __builtin_memcpy(&octave, (const int*)octaves.data + part, sizeof(octave));
        if (!any(octave != octave[0]))
            for (int sum = 0; sum < S; ++sum) sums[octave[0]][sum] += squares[sum];
        else for (int number = 0; number < O; ++number)
            for (int sum = 0; sum < S; ++sum) sums[number][sum] += octave == number ? squares[sum] : 0.0f;
    }
    for (int number = 0; number < O; ++number)
        for (int sum = 0; sum < S; ++sum) {
            double total = 0.0;
            for (int lane = 0; lane < L; ++lane) total += sums[number][sum][lane];
            ((double*)energies.data)[((long)tile*S + sum)*O + number] = total;
        }
"""

_ROWS = "float *const earlier = rows(before), *const middle = rows(mean);"
_FOLLOW = """
            const lanes step = value - load(earlier + at), so_far = load(middle + at), away = value - so_far;
            store(middle + at, share == 1.0f ? value : so_far + share*away);
            squares[1] += step*step;
            squares[2] += away*away;
"""
_OTHER_ROWS = "float *const shown = rows(other), *const middle_of_other = rows(other_mean);"
_FOLLOW_OTHER = """
            const lanes shows = load(shown + at), other_so_far = load(middle_of_other + at);
            const lanes other_away = shows - other_so_far, difference = other_away - away;
            store(middle_of_other + at, share == 1.0f ? shows : other_so_far + share*other_away);
            squares[3] += other_away*other_away;
            squares[4] += difference*difference;
"""


def _code(rows: str, follow: str, sums: int) -> str:
    return VECTORS + _CODE % {"octaves": len(OCTAVES), "sums": sums, "rows": rows, "follow": follow}


AGREES = Within("parseval", floor=0.0)


@wp.func
def square(value: wp.float32) -> wp.float64:
    """In double precision."""
    return wp.float64(value) * wp.float64(value)


@form(agrees=AGREES)
def octave_sums() -> Twins:
    """The function that sums a tile's squares by the octave of each part.

    spectra: [n, channels, parts], whole vectors of LANES parts. octaves: [parts]. energies: [n, 1, octaves].
    """

    @wp.func(module="unique")
    def add(
        tile: wp.int32,
        spectra: wp.array3d(dtype=wp.float32),
        octaves: wp.array(dtype=wp.int32),
        energies: wp.array3d(dtype=wp.float64),
    ):
        for number in range(energies.shape[2]):
            energies[tile, ENERGY, number] = wp.float64(0.0)
        for channel in range(spectra.shape[1]):
            for part in range(spectra.shape[2]):
                energies[tile, ENERGY, octaves[part]] += square(spectra[tile, channel, part])

    return Twins(add, _code("", "", 1))


@form(agrees=AGREES)
def following() -> Twins:
    """The function that sums ENERGY, CHANGE and VARIED of a tile's spectra, [n, 3, octaves].

    before: what they were in the frame before. Their mean moves by a share of the way to them, all of it at 1. All
    three are [n, channels, parts].
    """

    @wp.func(module="unique")
    def follow(
        tile: wp.int32,
        spectra: wp.array3d(dtype=wp.float32),
        before: wp.array3d(dtype=wp.float32),
        mean: wp.array3d(dtype=wp.float32),
        share: wp.float32,
        octaves: wp.array(dtype=wp.int32),
        energies: wp.array3d(dtype=wp.float64),
    ):
        for sum in range(energies.shape[1]):
            for number in range(energies.shape[2]):
                energies[tile, sum, number] = wp.float64(0.0)
        for channel in range(spectra.shape[1]):
            for part in range(spectra.shape[2]):
                value = spectra[tile, channel, part]
                so_far = mean[tile, channel, part]
                energies[tile, ENERGY, octaves[part]] += square(value)
                energies[tile, CHANGE, octaves[part]] += square(value - before[tile, channel, part])
                energies[tile, VARIED, octaves[part]] += square(value - so_far)
                mean[tile, channel, part] = wp.where(share == 1.0, value, so_far + share * (value - so_far))

    return Twins(follow, _code(_ROWS, _FOLLOW, 3))


@form(agrees=AGREES)
def following_both() -> Twins:
    """The same with other spectra, which have a mean too: OTHER and DIFFERENCE beside the rest, [n, 5, octaves]."""

    @wp.func(module="unique")
    def follow(
        tile: wp.int32,
        spectra: wp.array3d(dtype=wp.float32),
        before: wp.array3d(dtype=wp.float32),
        mean: wp.array3d(dtype=wp.float32),
        other: wp.array3d(dtype=wp.float32),
        other_mean: wp.array3d(dtype=wp.float32),
        share: wp.float32,
        octaves: wp.array(dtype=wp.int32),
        energies: wp.array3d(dtype=wp.float64),
    ):
        for sum in range(energies.shape[1]):
            for number in range(energies.shape[2]):
                energies[tile, sum, number] = wp.float64(0.0)
        for channel in range(spectra.shape[1]):
            for part in range(spectra.shape[2]):
                value = spectra[tile, channel, part]
                so_far = mean[tile, channel, part]
                shows = other[tile, channel, part]
                other_so_far = other_mean[tile, channel, part]
                energies[tile, ENERGY, octaves[part]] += square(value)
                energies[tile, CHANGE, octaves[part]] += square(value - before[tile, channel, part])
                energies[tile, VARIED, octaves[part]] += square(value - so_far)
                energies[tile, OTHER, octaves[part]] += square(shows - other_so_far)
                energies[tile, DIFFERENCE, octaves[part]] += square(shows - other_so_far - (value - so_far))
                mean[tile, channel, part] = wp.where(share == 1.0, value, so_far + share * (value - so_far))
                moved = other_so_far + share * (shows - other_so_far)
                other_mean[tile, channel, part] = wp.where(share == 1.0, shows, moved)

    return Twins(follow, _code(_ROWS + _OTHER_ROWS, _FOLLOW + _FOLLOW_OTHER, 5))


@made_once
def octave_energies() -> wp.Kernel:
    """The kernel that runs `octave_sums`, a tile a thread."""
    add = octave_sums().native

    @wp.kernel(module="unique", enable_backward=False)
    def kernel(
        spectra: wp.array3d(dtype=wp.float32),
        octaves: wp.array(dtype=wp.int32),
        energies: wp.array3d(dtype=wp.float64),
    ):
        add(wp.tid(), spectra, octaves, energies)

    return kernel


@made_once
def following_energies() -> wp.Kernel:
    """The kernel that runs `following`, a tile a thread."""
    follow = following().native

    @wp.kernel(module="unique", enable_backward=False)
    def kernel(
        spectra: wp.array3d(dtype=wp.float32),
        before: wp.array3d(dtype=wp.float32),
        mean: wp.array3d(dtype=wp.float32),
        share: wp.float32,
        octaves: wp.array(dtype=wp.int32),
        energies: wp.array3d(dtype=wp.float64),
    ):
        follow(wp.tid(), spectra, before, mean, share, octaves, energies)

    return kernel


@made_once
def following_energies_of_both() -> wp.Kernel:
    """The kernel that runs `following_both`, a tile a thread."""
    follow = following_both().native

    @wp.kernel(module="unique", enable_backward=False)
    def kernel(
        spectra: wp.array3d(dtype=wp.float32),
        before: wp.array3d(dtype=wp.float32),
        mean: wp.array3d(dtype=wp.float32),
        other: wp.array3d(dtype=wp.float32),
        other_mean: wp.array3d(dtype=wp.float32),
        share: wp.float32,
        octaves: wp.array(dtype=wp.int32),
        energies: wp.array3d(dtype=wp.float64),
    ):
        follow(wp.tid(), spectra, before, mean, other, other_mean, share, octaves, energies)

    return kernel
