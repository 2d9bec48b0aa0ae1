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


_AGREES = Within("parseval", floor=0.0)


@wp.func
def square(value: wp.float32) -> wp.float64:
    """In double precision."""
    return wp.float64(value) * wp.float64(value)


@form(agrees=_AGREES)
def octave_sums() -> Twins:
    """The function that sums a tile's squares by the octave of each part.

    spectra: [n, channels, parts]. octaves: [parts]. energies: [n, 1, octaves].
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


@form(agrees=_AGREES)
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


@form(agrees=_AGREES)
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


_POWER = """
    const int tiles = test.shape[0], channels = test.shape[1], bins = test.shape[2]/2;
    double* const to = (double*)power.data + (long)strip*3*bins;
    for (int tile = 0; tile < tiles; ++tile) {
        if (((const int*)strips.data)[tile] != strip) continue;
        const float* const seen = (const float*)test.data + (long)tile*channels*2*bins;
        const float* const off = (const float*)error.data + (long)tile*channels*2*bins;
        constexpr int some = 64;
        for (int first = 0; first < bins; first += some) {
            const int n = bins - first < some ? bins - first : some;
            float sums[3][some] = {};
            for (int channel = 0; channel < channels; ++channel) {
                const float* const x = seen + 2*((long)channel*bins + first);
                const float* const e = off + 2*((long)channel*bins + first);
                #pragma clang loop vectorize(enable)
                for (int bin = 0; bin < n; ++bin) {
                    const float re = x[2*bin], im = x[2*bin + 1], off_re = e[2*bin], off_im = e[2*bin + 1];
                    const float exact_re = re - off_re, exact_im = im - off_im;
                    sums[0][bin] += re*re + im*im;
                    sums[1][bin] += exact_re*exact_re + exact_im*exact_im;
                    sums[2][bin] += off_re*off_re + off_im*off_im;
                }
            }
            for (int kind = 0; kind < 3; ++kind)
                for (int bin = 0; bin < n; ++bin) to[kind*bins + first + bin] += sums[kind][bin];
        }
    }
"""


@form(agrees=_AGREES)
def strip_power() -> Twins:
    """The function that adds up, over the tiles of one strip, the power of test, reference and error in every bin.

    test, error: [n, channels, parts]; the reference is their difference. strips: [n], of every tile. power: [strips, 3,
    bins], to which it is added.
    """

    @wp.func(module="unique")
    def add(
        strip: wp.int32,
        test: wp.array3d(dtype=wp.float32),
        error: wp.array3d(dtype=wp.float32),
        strips: wp.array(dtype=wp.int32),
        power: wp.array3d(dtype=wp.float64),
    ):
        for tile in range(test.shape[0]):
            if strips[tile] == strip:
                for channel in range(test.shape[1]):
                    for part in range(test.shape[2]):
                        shows = test[tile, channel, part]
                        off = error[tile, channel, part]
                        power[strip, 0, part / 2] += square(shows)
                        power[strip, 1, part / 2] += square(shows - off)
                        power[strip, 2, part / 2] += square(off)

    return Twins(add, _POWER)


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


@made_once
def strip_powers() -> wp.Kernel:
    """The kernel that runs `strip_power`, a strip a thread."""
    add = strip_power().native

    @wp.kernel(module="unique", enable_backward=False)
    def kernel(
        test: wp.array3d(dtype=wp.float32),
        error: wp.array3d(dtype=wp.float32),
        strips: wp.array(dtype=wp.int32),
        power: wp.array3d(dtype=wp.float64),
    ):
        add(wp.tid(), test, error, strips, power)

    return kernel
