"""C++ that native forms share: vectors of LANES floats, LANES pixels of a row side by side.

Each text is written before a native form's own code, in which its names then stand.
"""

LANES = 16
"""Floats of a vector: as many as the widest registers hold."""


def listed(numbers: list[int]) -> str:
    """Numbers with commas, as a shuffle takes them."""
    return ", ".join(map(str, numbers))


def transposition(lanes: int) -> str:
    """What transposes a block of as many vectors as lanes, with two vectors a and b at hand.

    Ever larger quarters above and below the diagonal change places.
    """
    lines = []
    for step in (2**power for power in range(lanes.bit_length() - 1)):
        upper = listed([lanes + lane - step if lane & step else lane for lane in range(lanes)])
        lower = listed([lanes + lane if lane & step else lane + step for lane in range(lanes)])
        for row in range(lanes):
            if not row & step:
                lines.append(f"        a = block[{row}], b = block[{row + step}];")
                lines.append(f"        block[{row}] = __builtin_shufflevector(a, b, {upper});")
                lines.append(f"        block[{row + step}] = __builtin_shufflevector(a, b, {lower});")
    return "\n".join(lines)


_VECTORS = """
    constexpr int L = %(lanes)d;
    typedef float lanes __attribute__((ext_vector_type(L)));
    typedef int flags __attribute__((ext_vector_type(L)));
    typedef float pairs __attribute__((ext_vector_type(2*L)));
    const auto load = [](const float* from) {
        lanes value;
        __builtin_memcpy(&value, from, sizeof(value));
        return value;
    };
    const auto any = [](flags which) { return __builtin_reduce_or(which) != 0; };
    // The first n of a row of vectors of two; the last stands for those beyond.
    const auto split = [&](const float* from, int n, lanes& x, lanes& y) {
        if (n == L) {
            pairs both;
            __builtin_memcpy(&both, from, sizeof(both));
            x = __builtin_shufflevector(both, both, %(even)s);
            y = __builtin_shufflevector(both, both, %(odd)s);
        } else for (int k = 0; k < L; ++k) {
            x[k] = from[2*(k < n ? k : n - 1)];
            y[k] = from[2*(k < n ? k : n - 1) + 1];
        }
    };
    const auto join = [&](float* to, int n, lanes x, lanes y) {
        const pairs both = __builtin_shufflevector(x, y, %(joined)s);
        if (n == L) __builtin_memcpy(to, &both, sizeof(both));
        else for (int k = 0; k < 2*n; ++k) to[k] = both[k];
    };
    const auto first_of = [](int n) {
        flags which;
        for (int k = 0; k < L; ++k) which[k] = k < n ? -1 : 0;
        return which;
    };
"""
VECTORS = _VECTORS % {
    "lanes": LANES,
    "even": listed([2 * k for k in range(LANES)]),
    "odd": listed([2 * k + 1 for k in range(LANES)]),
    "joined": listed([part * LANES + k for k in range(LANES) for part in range(2)]),
}
"""Vectors of floats, and of flags that are 0 or -1; rows of vectors of two taken apart and put together."""
