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
    const auto plus = [](Number a, Number b) { return Number{a.re + b.re, a.im + b.im}; };
    const auto minus = [](Number a, Number b) { return Number{a.re - b.re, a.im - b.im}; };
    const auto quarter_back = [](Number a) { return Number{a.im, -a.re}; };
    // The transform of four numbers, in place.
    const auto four = [&](Number& a, Number& b, Number& c, Number& d) {
        const Number even = plus(a, c), odd = minus(a, c), sum = plus(b, d), turned = quarter_back(minus(b, d));
        a = plus(even, sum);
        b = plus(odd, turned);
        c = minus(even, sum);
        d = minus(odd, turned);
    };
    struct Four { enum { radix = 4 }; };
    struct Eight { enum { radix = 8 }; };
    const auto pass = [&](auto by, int n, int step, const Number* from, Number* to) {
        constexpr int R = decltype(by)::radix;
        const int m = n/R;
        for (int p = 0; p < m; ++p)
            for (int q = 0; q < step; ++q) {
                Number z[R];
                #pragma unroll
                for (int j = 0; j < R; ++j) z[j] = from[q + step*(p + m*j)];
                if constexpr (R == 8) {
                    #pragma unroll
                    for (int j = 0; j < 4; ++j) {
                        const Number early = z[j], late = z[j + 4];
                        z[j] = plus(early, late);
                        z[j + 4] = minus(early, late);
                    }
                    const float half = 0.70710678f;
                    z[5] = Number{half*(z[5].re + z[5].im), half*(z[5].im - z[5].re)};
                    z[6] = quarter_back(z[6]);
                    z[7] = Number{half*(z[7].im - z[7].re), -half*(z[7].im + z[7].re)};
                    four(z[4], z[5], z[6], z[7]);
                }
                four(z[0], z[1], z[2], z[3]);
                Number* const at = to + q + R*step*p;
                #pragma unroll
                for (int k = 0; k < R; ++k) {
                    const Number found = z[R == 4 ? k : k/2 + 4*(k%%2)];
                    const float c = cosines[p*k*(N/n)], s = sines[p*k*(N/n)];
                    at[k*step] = p ? Number{found.re*c + found.im*s, found.im*c - found.re*s} : found;
                }
            }
    };
    // Along the first axis, eight numbers at a time, or four (Stockham); what is found stands in either of the two.
    const auto transformed = [&](Number* from, Number* to) {
        for (int n = N, step = W; n > 1;) {
            const int radix = n == 4 || n == 16 ? 4 : 8;
            if (radix == 8) pass(Eight{}, n, step, from, to);
            else pass(Four{}, n, step, from, to);
            n /= radix;
            step *= radix;
            Number* const last = from;
            from = to;
            to = last;
        }
        return from;
    };
    const auto transpose = [](lanes* block) {
        lanes a, b;
%(transposition)s
    };
    alignas(64) Number one[N*W], other[N*W];
    const int channels = picture.shape[0], height = picture.shape[1], width = picture.shape[2];
    const auto pixels_of = [&](int which) {
        const int* const corner = (const int*)corners.data + 2*(which/channels);
        return (const float*)picture.data + ((long)(which%%channels)*height + corner[0])*width + corner[1];
    };
    const float* pixels = pixels_of(index);
    // The next block is on its way while this one is transformed; its rows begin anywhere in a line of the cache.
    const float* next = pixels_of(index + 1 < channels*corners.shape[0] ? index + 1 : index);
    const float *w = (const float*)window.data, *v = (const float*)levelling.data;
    // Columns c and c + H go as the real and the imaginary part of one.
    lanes level = 0.0f;
    for (int row = 0; row < N; ++row, pixels += width, next += width) {
        for (int k = 0; k <= N; k += 16) __builtin_prefetch(next + k, 0, 2);
        lanes across = 0.0f;
        #pragma unroll
        for (int k = 0; k < H; k += L) {
            const float *const right = w + N + k, *const level_right = v + N + k;
            const Number seen = {load(pixels + k)*(w[row]*load(right)), load(pixels + H + k)*(w[row]*load(right + H))};
            across += seen.re*load(level_right) + seen.im*load(level_right + H);
            one[row*W + k/L] = seen;
        }
        level += v[row]*across;
    }
    float sum = 0.0f;
    for (int lane = 0; lane < L; ++lane) sum += level[lane];
    ((float*)mean.data)[index] = sum;
    Number* const z = transformed(one, other);
    Number* const upright = z == one ? other : one;
    // Apart again, since the spectrum of what is real is symmetric, and transposed. The rows 0 and H, which are real
    // themselves, go as the two parts of one.
    const auto part = [&](int k, int top, auto of) {
        struct Block { lanes lane[L]; } block;
        #pragma unroll
        for (int r = 0; r < L; ++r) {
            const int row = top + r;
            block.lane[r] = of(row, z[row*W + k], z[(row ? N - row : H)*W + k]);
        }
        transpose(block.lane);
        return block;
    };
    const auto put = [&](int first, int k, int top, const auto& re, const auto& im) {
        #pragma unroll
        for (int c = 0; c < L; ++c) upright[(first + k*L + c)*W + top/L] = Number{re.lane[c], im.lane[c]};
    };
    for (int k = 0; k < W; ++k)
        for (int top = 0; top < H; top += L) {
            put(0, k, top, part(k, top, [](int row, Number a, Number b) { return row ? 0.5f*(a.re + b.re) : a.re; }),
                           part(k, top, [](int row, Number a, Number b) { return row ? 0.5f*(a.im - b.im) : b.re; }));
            put(H, k, top, part(k, top, [](int row, Number a, Number b) { return row ? 0.5f*(a.im + b.im) : a.im; }),
                           part(k, top, [](int row, Number a, Number b) { return row ? 0.5f*(b.re - a.re) : b.im; }));
        }
    const Number* const y = transformed(upright, z);
    // Turned as the tile's place demands: by a phase for each row, and one for each column.
    const float *const down_re = (const float*)down.data, *const down_im = down_re + N;
    const float *const right_re = (const float*)right.data, *const right_im = right_re + H + 1;
    float* const to = (float*)spectra.data + (long)index*2*N*(H + 1);
    const auto store = [&](int row, int column, lanes re, lanes im) {
        const lanes c = load(right_re + column), s = load(right_im + column), x = re*c - im*s, y = re*s + im*c;
        const lanes real = x*down_re[row] - y*down_im[row], imaginary = x*down_im[row] + y*down_re[row];
        const auto both = __builtin_shufflevector(real, imaginary, %(interleaved)s);
        __builtin_memcpy(to + 2*(row*(H + 1) + column), &both, sizeof(both));
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
    float last[2][H];
    for (int k = 0; k < W; ++k) {
        __builtin_memcpy(last[0] + k*L, &y[H*W + k].re, sizeof(lanes));
        __builtin_memcpy(last[1] + k*L, &y[H*W + k].im, sizeof(lanes));
    }
    for (int row = 0; row < N; ++row) {
        const int up = row < H ? row : N - row;
        const float re = row == H ? last[1][0] : last[0][up%%H];
        const float im = up%%H == 0 ? 0.0f : row < H ? last[1][up] : -last[1][up];
        const float x = re*right_re[H] - im*right_im[H], y = re*right_im[H] + im*right_re[H];
        float* const at = to + 2*(row*(H + 1) + H);
        at[0] = x*down_re[row] - y*down_im[row];
        at[1] = x*down_im[row] + y*down_re[row];
    }
"""


@form(cases=[(64,), (32,), (16,)], agrees=Within("single precision spectra"))
def tile_spectrum(size: int) -> Twins:
    """The function that transforms one channel of one tile of `size` px, 16 and more, and finds its mean.

    index: tile * channels + channel. picture: [channels, H, W]. corners: [n, 2] (y, x), each tile's first pixel.
    window, levelling: [2, size], down and to the right; by the second the windowed block is multiplied and summed,
    which is its mean, [n, channels]. down, right: [2, size] and [2, size / 2 + 1], real and imaginary part of the
    phases of rows and columns. spectra: [n channels, size, size + 2], both parts in turns.
    """

    @wp.func(module="unique")
    def transform(
        index: wp.int32,
        picture: wp.array3d(dtype=wp.float32),
        corners: wp.array2d(dtype=wp.int32),
        window: wp.array2d(dtype=wp.float32),
        levelling: wp.array2d(dtype=wp.float32),
        down: wp.array2d(dtype=wp.float32),
        right: wp.array2d(dtype=wp.float32),
        spectra: wp.array3d(dtype=wp.float32),
        mean: wp.array2d(dtype=wp.float32),
    ):
        tile = index / picture.shape[0]
        channel = index % picture.shape[0]
        length = window.shape[1]
        level = wp.float64(0.0)
        for row in range(length):
            for column in range(length):
                value = picture[channel, corners[tile, 0] + row, corners[tile, 1] + column]
                weight = window[0, row] * window[1, column] * levelling[0, row] * levelling[1, column]
                level += wp.float64(value * weight)
        mean[tile, channel] = wp.float32(level)
        for ky in range(length):
            for kx in range(length / 2 + 1):
                re = wp.float64(0.0)
                im = wp.float64(0.0)
                for row in range(length):
                    for column in range(length):
                        value = picture[channel, corners[tile, 0] + row, corners[tile, 1] + column]
                        seen = wp.float64(value * (window[0, row] * window[1, column]))
                        turns = wp.float64((ky * row + kx * column) % length) / wp.float64(length)
                        re += seen * wp.cos(wp.float64(wp.static(2.0 * np.pi)) * turns)
                        im -= seen * wp.sin(wp.float64(wp.static(2.0 * np.pi)) * turns)
                cosine = wp.float64(down[0, ky] * right[0, kx] - down[1, ky] * right[1, kx])
                sine = wp.float64(down[0, ky] * right[1, kx] + down[1, ky] * right[0, kx])
                spectra[index, ky, 2 * kx] = wp.float32(re * cosine - im * sine)
                spectra[index, ky, 2 * kx + 1] = wp.float32(re * sine + im * cosine)

    return Twins(transform, _code(size), size)


def _code(size: int) -> str:
    lanes = min(LANES, size // 2)
    angle = 2 * np.pi * np.arange(size) / size
    return _CODE % {
        "size": size,
        "lanes": lanes,
        "cosines": _literals(np.cos(angle)),
        "sines": _literals(np.sin(angle)),
        "transposition": transposition(lanes),
        "interleaved": ", ".join(f"{lane}, {lanes + lane}" for lane in range(lanes)),
    }


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
        down: wp.array2d(dtype=wp.float32),
        right: wp.array2d(dtype=wp.float32),
        spectra: wp.array3d(dtype=wp.float32),
        mean: wp.array2d(dtype=wp.float32),
    ):
        transform(wp.tid(), picture, corners, window, levelling, down, right, spectra, mean)

    return kernel


def _literals(values: NDArray[np.float64]) -> str:
    return ", ".join(f"{value:.9e}f" for value in values.tolist())
