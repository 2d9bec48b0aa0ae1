"""Power spectra of tiles, added up by the strip of the picture that each tile is in."""

import warp as wp

from metrics.kernels.energies import AGREES, square
from metrics.kernels.forms import Twins, form
from metrics.kernels.making import made_once

wp.set_module_options({"enable_backward": False})

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


@form(agrees=AGREES)
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
