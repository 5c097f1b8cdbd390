/* Fourier transforms of several lines at a time, one in each vector lane.

   Stockham's algorithm: one stage for each small factor of the length, from one buffer to another, with the result in
   natural order [1]. Two real lines are transformed as real and imaginary parts of a complex one. The backward
   transform is the forward one with real and imaginary parts exchanged before and after.

   [1] Van Loan (1992), Computational Frameworks for the Fast Fourier Transform, section 1.7. */

typedef REAL NAME(Vector) __attribute__((vector_size(LANE_BYTES)));

COMPLEX { V re, im; };

static inline COMPLEX NAME(plus)(COMPLEX a, COMPLEX b) { return (COMPLEX){a.re + b.re, a.im + b.im}; }
static inline COMPLEX NAME(minus)(COMPLEX a, COMPLEX b) { return (COMPLEX){a.re - b.re, a.im - b.im}; }

/* Return a times the number at `root`. */
static inline COMPLEX NAME(turned)(COMPLEX a, const REAL *root)
{
    const REAL c = root[0], s = root[1];
    return (COMPLEX){a.re * c - a.im * s, a.re * s + a.im * c};
}

/* Transform the numbers z[0], z[step], z[2 step], z[3 step]. */
static inline void NAME(four)(COMPLEX *z, int step)
{
    const COMPLEX a = NAME(plus)(z[0], z[2 * step]), b = NAME(minus)(z[0], z[2 * step]);
    const COMPLEX c = NAME(plus)(z[step], z[3 * step]), d = NAME(minus)(z[step], z[3 * step]);
    z[0] = NAME(plus)(a, c);
    z[step] = (COMPLEX){b.re + d.im, b.im - d.re};
    z[2 * step] = NAME(minus)(a, c);
    z[3 * step] = (COMPLEX){b.re - d.im, b.im + d.re};
}

/* Transform `radix` numbers: 2, 3, 4, 5 or 8. */
static inline __attribute__((always_inline)) void NAME(transform_few)(COMPLEX *z, const int64_t radix)
{
    if (radix == 2) {
        const COMPLEX a = z[0], b = z[1];
        z[0] = NAME(plus)(a, b);
        z[1] = NAME(minus)(a, b);
    } else if (radix == 3) {
        const REAL sine = (REAL)0.86602540378443864676;
        const COMPLEX a = NAME(plus)(z[1], z[2]), b = NAME(minus)(z[1], z[2]);
        const COMPLEX c = {z[0].re - a.re * (REAL)0.5, z[0].im - a.im * (REAL)0.5};
        z[0] = NAME(plus)(z[0], a);
        z[1] = (COMPLEX){c.re + b.im * sine, c.im - b.re * sine};
        z[2] = (COMPLEX){c.re - b.im * sine, c.im + b.re * sine};
    } else if (radix == 4) {
        NAME(four)(z, 1);
    } else if (radix == 5) {
        const REAL c1 = (REAL)0.30901699437494742410, c2 = (REAL)-0.80901699437494742410;
        const REAL s1 = (REAL)0.95105651629515357212, s2 = (REAL)0.58778525229247312917;
        const COMPLEX a = NAME(plus)(z[1], z[4]), b = NAME(minus)(z[1], z[4]);
        const COMPLEX c = NAME(plus)(z[2], z[3]), d = NAME(minus)(z[2], z[3]);
        const COMPLEX e = {z[0].re + a.re * c1 + c.re * c2, z[0].im + a.im * c1 + c.im * c2};
        const COMPLEX f = {z[0].re + a.re * c2 + c.re * c1, z[0].im + a.im * c2 + c.im * c1};
        const COMPLEX g = {b.im * s1 + d.im * s2, -b.re * s1 - d.re * s2};
        const COMPLEX h = {b.im * s2 - d.im * s1, d.re * s1 - b.re * s2};
        z[0] = NAME(plus)(z[0], NAME(plus)(a, c));
        z[1] = NAME(plus)(e, g);
        z[2] = NAME(plus)(f, h);
        z[3] = NAME(minus)(f, h);
        z[4] = NAME(minus)(e, g);
    } else if (radix == 8) {
        const REAL half = (REAL)0.70710678118654752440;
        NAME(four)(z, 2);
        NAME(four)(z + 1, 2);
        const COMPLEX b = z[3], c = z[5], d = z[7];
        const COMPLEX odd[4] = {z[1],
                                {(b.re + b.im) * half, (b.im - b.re) * half},
                                {c.im, -c.re},
                                {(d.im - d.re) * half, (d.re + d.im) * -half}};
        const COMPLEX even[4] = {z[0], z[2], z[4], z[6]};
        for (int k = 0; k < 4; k++) {
            z[k] = NAME(plus)(even[k], odd[k]);
            z[k + 4] = NAME(minus)(even[k], odd[k]);
        }
    }
}

/* One stage: `stride` transforms of radix x rest numbers become radix times as many of `rest` numbers. */
static inline __attribute__((always_inline)) void NAME(stage)(const int64_t radix, const COMPLEX *from, COMPLEX *to,
                                                              int64_t rest, int64_t stride, const REAL *roots)
{
    for (int64_t p = 0; p < rest; p++)
        for (int64_t q = 0; q < stride; q++) {
            COMPLEX z[8];
#pragma GCC unroll 8
            for (int64_t k = 0; k < radix; k++)
                z[k] = from[q + stride * (p + rest * k)];
            NAME(transform_few)(z, radix);
#pragma GCC unroll 8
            for (int64_t k = 0; k < radix; k++)
                to[q + stride * (radix * p + k)] =
                    k == 0 || rest == 1 ? z[k] : NAME(turned)(z[k], roots + 2 * p * k * stride);
        }
}

/* Transform the `n` numbers of every lane at `from`; return the buffer with the result: `from` or `to`.

   `roots`: exp(-2 pi i k / n) for k from 0 to n - 1. */
static COMPLEX *NAME(transform)(COMPLEX *from, COMPLEX *to, int64_t n, const REAL *roots)
{
    for (int64_t rest = n, stride = 1, radix; rest > 1; stride *= radix) {
        radix = rest % 8 == 0 ? 8 : rest % 4 == 0 ? 4 : rest % 5 == 0 ? 5 : rest % 3 == 0 ? 3 : 2;
        rest /= radix;
        switch (radix) {
        case 8: NAME(stage)(8, from, to, rest, stride, roots); break;
        case 5: NAME(stage)(5, from, to, rest, stride, roots); break;
        case 4: NAME(stage)(4, from, to, rest, stride, roots); break;
        case 3: NAME(stage)(3, from, to, rest, stride, roots); break;
        default: NAME(stage)(2, from, to, rest, stride, roots);
        }
        COMPLEX *swapped = from;
        from = to;
        to = swapped;
    }
    return from;
}

/* Return the start of `scratch`, aligned to vectors. */
static inline COMPLEX *NAME(buffer)(void *scratch)
{
    return (COMPLEX *)(((uintptr_t)scratch + LANE_BYTES - 1) / LANE_BYTES * LANE_BYTES);
}

/* Put real and imaginary parts of the lanes into pairs, and back. */
static inline void NAME(pair)(const V *re, const V *im, REAL *out)
{
    const REAL *reals = (const REAL *)re, *imaginaries = (const REAL *)im;
    VECTOR
    for (int64_t k = 0; k < LANES; k++) {
        out[2 * k] = reals[k];
        out[2 * k + 1] = imaginaries[k];
    }
}

static inline void NAME(part)(const REAL *in, V *re, V *im)
{
    REAL *reals = (REAL *)re, *imaginaries = (REAL *)im;
    VECTOR
    for (int64_t k = 0; k < LANES; k++) {
        reals[k] = in[2 * k];
        imaginaries[k] = in[2 * k + 1];
    }
}

/* The field counts less its `offset`. */
PASS(rows_forward, { const REAL *field; REAL *spectrum; const REAL *roots; double offset; int64_t ny, nx; })
{
    const int64_t ny = given->ny, nx = given->nx, waves = nx / 2 + 1;
    const REAL offset = (REAL)given->offset;
    COMPLEX *from = NAME(buffer)(scratch), *to = from + nx;
    for (int64_t start = first * ROWS; start < SMALLER(last * ROWS, ny); start += IN_BLOCK) {
        const int64_t rows = SMALLER(IN_BLOCK, ny - start);
        REAL *lanes = (REAL *)from;
        for (int64_t j = 0; j < nx; j += TILE)
            for (int64_t i = 0; i < IN_BLOCK; i++) {
                const REAL *row = given->field + (start + SMALLER(i, rows - 1)) * nx;
                for (int64_t k = j; k < SMALLER(j + TILE, nx); k++)
                    lanes[k * IN_BLOCK + i] = row[k] - offset;
            }
        const COMPLEX *z = NAME(transform)(from, to, nx, given->roots);
        for (int64_t j = 0; j < waves; j += TILE) {
            REAL tile[64 / sizeof(REAL)][4 * LANE_BYTES / sizeof(REAL)] __attribute__((aligned(LANE_BYTES)));
            const int64_t count = SMALLER(TILE, waves - j);
            for (int64_t k = 0; k < count; k++) {
                const COMPLEX a = z[j + k], b = z[j + k ? nx - j - k : 0];
                const COMPLEX one = {(a.re + b.re) * (REAL)0.5, (a.im - b.im) * (REAL)0.5};
                const COMPLEX other = {(a.im + b.im) * (REAL)0.5, (b.re - a.re) * (REAL)0.5};
                NAME(pair)(&one.re, &one.im, tile[k]);
                NAME(pair)(&other.re, &other.im, tile[k] + IN_BLOCK);
            }
            for (int64_t i = 0; i < rows; i++) {
                REAL *row = given->spectrum + 2 * ((start + i) * waves + j);
                for (int64_t k = 0; k < count; k++)
                    memcpy(row + 2 * k, tile[k] + 2 * i, 2 * sizeof(REAL));
            }
        }
    }
}

PASS(rows_backward, { REAL *field; const REAL *spectrum; const REAL *roots; double factor; int64_t ny, nx; })
{
    const int64_t ny = given->ny, nx = given->nx, waves = nx / 2 + 1;
    const REAL factor = (REAL)given->factor;
    COMPLEX *from = NAME(buffer)(scratch), *to = from + nx;
    for (int64_t start = first * ROWS; start < SMALLER(last * ROWS, ny); start += IN_BLOCK) {
        const int64_t rows = SMALLER(IN_BLOCK, ny - start);
        for (int64_t j = 0; j < waves; j += TILE) {
            REAL tile[64 / sizeof(REAL)][4 * LANE_BYTES / sizeof(REAL)] __attribute__((aligned(LANE_BYTES)));
            const int64_t count = SMALLER(TILE, waves - j);
            for (int64_t i = 0; i < IN_BLOCK; i++) {
                const REAL *row = given->spectrum + 2 * ((start + SMALLER(i, rows - 1)) * waves + j);
                for (int64_t k = 0; k < count; k++)
                    memcpy(tile[k] + 2 * i, row + 2 * k, 2 * sizeof(REAL));
            }
            for (int64_t k = 0; k < count; k++) {
                const int64_t wave = j + k, mirrored = nx - wave;
                COMPLEX one, other;
                NAME(part)(tile[k], &one.re, &one.im);
                NAME(part)(tile[k] + IN_BLOCK, &other.re, &other.im);
                if (wave == 0 || wave == mirrored) { /* real: imaginary parts are rounding errors */
                    from[wave] = (COMPLEX){other.re, one.re};
                    continue;
                }
                from[wave] = (COMPLEX){one.im + other.re, one.re - other.im};
                from[mirrored] = (COMPLEX){other.re - one.im, one.re + other.im};
            }
        }
        const REAL *lanes = (const REAL *)NAME(transform)(from, to, nx, given->roots);
        for (int64_t j = 0; j < nx; j += TILE)
            for (int64_t i = 0; i < rows; i++) {
                REAL *row = given->field + (start + i) * nx;
                for (int64_t k = j; k < SMALLER(j + TILE, nx); k++)
                    row[k] = lanes[k * IN_BLOCK + (i + LANES) % IN_BLOCK] * factor;
            }
    }
}

/* Columns of a spectrum in place; `backward`: 0 or 1. */
PASS(columns, { REAL *spectrum; const REAL *roots; int64_t ny, waves, backward; })
{
    const int64_t ny = given->ny, waves = given->waves;
    COMPLEX *from = NAME(buffer)(scratch), *to = from + ny;
    for (int64_t start = first * COLUMNS; start < SMALLER(last * COLUMNS, waves); start += LANES) {
        const int64_t count = SMALLER(LANES, waves - start);
        REAL few[2 * LANE_BYTES / sizeof(REAL)] = {0}; /* for fewer columns than lanes */
        for (int64_t i = 0; i < ny; i++) {
            const REAL *in = given->spectrum + 2 * (i * waves + start);
            if (count < LANES)
                in = memcpy(few, in, (size_t)(2 * count) * sizeof(REAL));
            V re, im;
            NAME(part)(in, &re, &im);
            from[i] = given->backward ? (COMPLEX){im, re} : (COMPLEX){re, im};
        }
        const COMPLEX *found = NAME(transform)(from, to, ny, given->roots);
        for (int64_t i = 0; i < ny; i++) {
            REAL *out = given->spectrum + 2 * (i * waves + start);
            const V *re = given->backward ? &found[i].im : &found[i].re;
            const V *im = given->backward ? &found[i].re : &found[i].im;
            NAME(pair)(re, im, count < LANES ? few : out);
            if (count < LANES)
                memcpy(out, few, (size_t)(2 * count) * sizeof(REAL));
        }
    }
}

#undef REAL
#undef TYPES
