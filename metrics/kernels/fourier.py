"""Windowed tiles of a picture to surface-locked spectra, in one go: half the work of measuring.

A library transforms row by row, a few numbers side by side, and blocks, their products with the window and spectra go
through memory; here a tile stays in the cache, and LANES columns are transformed at a time. Spectra live in the host's
memory, so it runs on the CPU.
"""

import numpy as np
import warp as wp
from numpy.typing import NDArray

from metrics.kernels.forms import Twins, Within, form
from metrics.kernels.lanes import LANES, transposition
from metrics.kernels.making import made_once

wp.set_module_options({"enable_backward": False})

_CODE = """
    constexpr int N = %(size)d, H = N/2, L = %(lanes)d, W = H/L;
    typedef float lanes __attribute__((ext_vector_type(L)));
    struct Number { lanes re, im; };
    static const float cosines[] = {%(cosines)s};
    static const float sines[] = {%(sines)s};
    const auto load = [](const float* from) {
        lanes value;
        __builtin_memcpy(&value, from, sizeof(value));
        return value;
    };
    // Along the first axis, four numbers at a time (Stockham); what is found stands in either of the two.
    const auto transformed = [&](Number* from, Number* to) {
        int step = W;
        for (int n = N; n >= 4; n /= 4, step *= 4) {
            const int m = n/4;
            for (int p = 0; p < m; ++p) {
                const int turn = p*(N/n);
                const float c1 = cosines[turn], s1 = sines[turn], c2 = cosines[2*turn], s2 = sines[2*turn];
                const float c3 = cosines[3*turn], s3 = sines[3*turn];
                for (int q = 0; q < step; ++q) {
                    const Number a = from[q + step*p], b = from[q + step*(p + m)];
                    const Number c = from[q + step*(p + 2*m)], d = from[q + step*(p + 3*m)];
                    const Number even = {a.re + c.re, a.im + c.im}, odd = {a.re - c.re, a.im - c.im};
                    const Number sum = {b.re + d.re, b.im + d.im}, quarter = {b.im - d.im, d.re - b.re};
                    const Number f = {odd.re + quarter.re, odd.im + quarter.im};
                    const Number g = {even.re - sum.re, even.im - sum.im};
                    const Number h = {odd.re - quarter.re, odd.im - quarter.im};
                    Number* const at = to + q + 4*step*p;
                    at[0] = Number{even.re + sum.re, even.im + sum.im};
                    at[step] = Number{f.re*c1 + f.im*s1, f.im*c1 - f.re*s1};
                    at[2*step] = Number{g.re*c2 + g.im*s2, g.im*c2 - g.re*s2};
                    at[3*step] = Number{h.re*c3 + h.im*s3, h.im*c3 - h.re*s3};
                }
            }
            Number* const last = from;
            from = to;
            to = last;
        }
        if (step == H*W) {
            for (int q = 0; q < step; ++q) {
                const Number a = from[q], b = from[q + step];
                to[q] = Number{a.re + b.re, a.im + b.im};
                to[q + step] = Number{a.re - b.re, a.im - b.im};
            }
            from = to;
        }
        return from;
    };
    const auto transpose = [](lanes* block) {
        lanes a, b;
%(transposition)s
    };
    alignas(64) Number one[N*W], other[N*W];
    const int channels = picture.shape[0], height = picture.shape[1], width = picture.shape[2];
    const int* const corner = (const int*)corners.data + 2*(index/channels);
    const float* pixels = (const float*)picture.data + ((long)(index%%channels)*height + corner[0])*width + corner[1];
    const float *w = (const float*)window.data, *v = (const float*)levelling.data;
    // Columns c and c + H go as the real and the imaginary part of one.
    lanes level = 0.0f;
    for (int row = 0; row < N; ++row, pixels += width, w += N, v += N)
        for (int k = 0; k < H; k += L) {
            const Number seen = {load(pixels + k)*load(w + k), load(pixels + H + k)*load(w + H + k)};
            level += seen.re*load(v + k) + seen.im*load(v + H + k);
            one[row*W + k/L] = seen;
        }
    float sum = 0.0f;
    for (int lane = 0; lane < L; ++lane) sum += level[lane];
    ((float*)mean.data)[index] = sum;
    Number* const z = transformed(one, other);
    Number* const upright = z == one ? other : one;
    // Apart again, since the spectrum of what is real is symmetric, and transposed. The rows 0 and H, which are real
    // themselves, go as the two parts of one.
    for (int k = 0; k < W; ++k)
        for (int top = 0; top < H; top += L) {
            lanes parts[4][L];
            for (int row = top; row < top + L; ++row) {
                const Number a = z[row*W + k], b = z[(row ? N - row : H)*W + k];
                parts[0][row - top] = row ? 0.5f*(a.re + b.re) : a.re;
                parts[1][row - top] = row ? 0.5f*(a.im - b.im) : b.re;
                parts[2][row - top] = row ? 0.5f*(a.im + b.im) : a.im;
                parts[3][row - top] = row ? 0.5f*(b.re - a.re) : b.im;
            }
            for (int part = 0; part < 4; ++part) transpose(parts[part]);
            for (int c = 0; c < L; ++c) {
                upright[(k*L + c)*W + top/L] = Number{parts[0][c], parts[1][c]};
                upright[(H + k*L + c)*W + top/L] = Number{parts[2][c], parts[3][c]};
            }
        }
    const Number* const y = transformed(upright, z);
    const float *cosine = (const float*)phase.data, *sine = cosine + N*(H + 1);
    float* const to = (float*)spectra.data + (long)index*2*N*(H + 1);
    const auto store = [&](int row, int column, lanes re, lanes im) {
        const int place = row*(H + 1) + column;
        const lanes c = load(cosine + place), s = load(sine + place), real = re*c - im*s, imaginary = re*s + im*c;
        const auto both = __builtin_shufflevector(real, imaginary, %(interleaved)s);
        __builtin_memcpy(to + 2*place, &both, sizeof(both));
    };
    for (int k = 0; k < H; k += L)
        for (int top = 0; top < H; top += L) {
            lanes parts[4][L];
            for (int c = 0; c < L; ++c) {
                const Number ahead = y[(k + c)*W + top/L], back = y[((N - k - c)%%N)*W + top/L];
                parts[0][c] = ahead.re;
                parts[1][c] = ahead.im;
                parts[2][c] = back.re;
                parts[3][c] = back.im;
            }
            for (int part = 0; part < 4; ++part) transpose(parts[part]);
            for (int row = top; row < top + L; ++row) {
                const lanes re = parts[0][row - top], im = parts[1][row - top];
                const lanes back = parts[2][row - top], under = parts[3][row - top];
                store(row, k, row ? re : 0.5f*(re + back), row ? im : 0.5f*(im - under));
                store(row ? N - row : H, k, row ? back : 0.5f*(im + under), row ? -under : 0.5f*(back - re));
            }
        }
    // The last column is its own opposite.
    for (int row = 0; row < N; ++row) {
        const int up = row < H ? row : N - row, place = row*(H + 1) + H;
        const Number end = y[H*W + up%%H/L];
        const float re = row == H ? end.im[0] : end.re[up%%L], all = end.im[up%%L];
        const float im = up%%H == 0 ? 0.0f : row < H ? all : -all;
        to[2*place] = re*cosine[place] - im*sine[place];
        to[2*place + 1] = re*sine[place] + im*cosine[place];
    }
"""


@form(cases=[(64,), (32,), (16,)], agrees=Within("single precision spectra"))
def tile_spectrum(size: int) -> Twins:
    """The function that transforms one channel of one tile of `size` px, 16 and more, and finds its mean.

    index: tile * channels + channel. picture: [channels, H, W]. corners: [n, 2] (y, x), each tile's first pixel.
    window, levelling: [size, size], the second is multiplied with the windowed block and summed, which is its mean, [n,
    channels]. phase: [2, size, size / 2 + 1], real and imaginary part. spectra: [n channels, size, size + 2], both
    parts in turns.
    """

    @wp.func(module="unique")
    def transform(
        index: wp.int32,
        picture: wp.array3d(dtype=wp.float32),
        corners: wp.array2d(dtype=wp.int32),
        window: wp.array2d(dtype=wp.float32),
        levelling: wp.array2d(dtype=wp.float32),
        phase: wp.array3d(dtype=wp.float32),
        spectra: wp.array3d(dtype=wp.float32),
        mean: wp.array2d(dtype=wp.float32),
    ):
        tile = index / picture.shape[0]
        channel = index % picture.shape[0]
        length = window.shape[0]
        level = wp.float32(0.0)
        for row in range(length):
            for column in range(length):
                value = picture[channel, corners[tile, 0] + row, corners[tile, 1] + column]
                level += value * window[row, column] * levelling[row, column]
        mean[tile, channel] = level
        for ky in range(length):
            for kx in range(length / 2 + 1):
                re = wp.float64(0.0)
                im = wp.float64(0.0)
                for row in range(length):
                    for column in range(length):
                        value = picture[channel, corners[tile, 0] + row, corners[tile, 1] + column]
                        seen = wp.float64(value * window[row, column])
                        turns = wp.float64((ky * row + kx * column) % length) / wp.float64(length)
                        re += seen * wp.cos(wp.float64(wp.static(2.0 * np.pi)) * turns)
                        im -= seen * wp.sin(wp.float64(wp.static(2.0 * np.pi)) * turns)
                cosine = wp.float64(phase[0, ky, kx])
                sine = wp.float64(phase[1, ky, kx])
                spectra[index, ky, 2 * kx] = wp.float32(re * cosine - im * sine)
                spectra[index, ky, 2 * kx + 1] = wp.float32(re * sine + im * cosine)

    lanes = min(LANES, size // 2)
    angle = 2 * np.pi * np.arange(size) / size
    code = _CODE % {
        "size": size,
        "lanes": lanes,
        "cosines": _literals(np.cos(angle)),
        "sines": _literals(np.sin(angle)),
        "transposition": transposition(lanes),
        "interleaved": ", ".join(f"{lane}, {lanes + lane}" for lane in range(lanes)),
    }
    return Twins(transform, code, size)


@made_once
def tile_spectra(size: int) -> wp.Kernel:
    """The kernel that transforms tiles of `size` px; a thread takes one channel of one."""
    transform = tile_spectrum(size).native

    @wp.kernel(module="unique", enable_backward=False)
    def kernel(
        picture: wp.array3d(dtype=wp.float32),
        corners: wp.array2d(dtype=wp.int32),
        window: wp.array2d(dtype=wp.float32),
        levelling: wp.array2d(dtype=wp.float32),
        phase: wp.array3d(dtype=wp.float32),
        spectra: wp.array3d(dtype=wp.float32),
        mean: wp.array2d(dtype=wp.float32),
    ):
        transform(wp.tid(), picture, corners, window, levelling, phase, spectra, mean)

    return kernel


def _literals(values: NDArray[np.float64]) -> str:
    return ", ".join(f"{value:.9e}f" for value in values.tolist())
