/* The grid kernels of the iteration: one pass through memory each.

   `array_api.py` defines what they compute, `compiled.py` calls them. Nothing here depends on Python: arrays are
   passed as addresses, in C order and contiguous. */

#include <math.h>
#include <stddef.h>
#include <stdint.h>
#include <stdlib.h>
#include <string.h>

#include "threads.h"

#define CLOSED 1e-30           /* replaces a gap of zero at a point of the active set; as in array_api.py */
#define NEGLIGIBLE_LOAD 1e-5   /* share of the load of a cell that is set to zero; as in array_api.py */

enum { UNKNOWN, SCATTERED, ALONG_A_LINE }; /* `Arrangement` of protocol.py */

#define SMALLER(a, b) ((a) < (b) ? (a) : (b)) /* b if one of them is NaN */
#define LARGER(a, b) ((a) > (b) ? (a) : (b))
#define FREE(p, cap) (((p) > 0) & ((p) < (cap)))
/* Whether a point belongs to the active set: see `active_set` in array_api.py. */
#define ACTIVE(p, gap, cap) \
    ((((p) <= 0) & ((gap) < 0)) | (((p) >= (cap)) & ((gap) > 0)) | FREE(p, cap))

/* Vectorised loops. Only the sums named here may be reordered, as vectorisation requires; everything else is
   computed in the order of the source. */
#define DO_PRAGMA(text) _Pragma(#text)
#define VECTOR DO_PRAGMA(omp simd)
#define SUM(a) DO_PRAGMA(omp simd reduction(+ : a))
#define TWO_SUMS(a, b) DO_PRAGMA(omp simd reduction(+ : a, b))
#define SIX_SUMS(a, b, c, d, e, f) DO_PRAGMA(omp simd reduction(+ : a, b, c, d, e, f))

#define JOIN_(a, b, c) a##_##b##_##c
#define JOIN(a, b, c) JOIN_(a, b, c)
#define REAL_f float
#define REAL_d double
#define REAL_OF_(letter) REAL_##letter
#define REAL_OF(letter) REAL_OF_(letter)

/* Call a function on groups of `factor` points: a compile-time factor allows vectorisation. */
#define BY_FACTOR(name, in, n, factor, share, out) \
    ((factor) == 1 ? NAME(name)(in, n, 1, share, out) : (factor) == 2 ? NAME(name)(in, n, 2, share, out) \
                                                      : NAME(name)(in, n, factor, share, out))

/* The arguments of a pass, and the head of its function. */
#define PASS(name, ...) \
    struct NAME(name) __VA_ARGS__; \
    static void NAME(work_##name)(const struct NAME(name) *given, int64_t first, int64_t last, void *scratch, \
                                  struct Found *found); \
    static void NAME(run_##name)(const void *given, int64_t first, int64_t last, void *scratch, struct Found *found) \
    { \
        NAME(work_##name)(given, first, last, scratch, found); \
    } \
    static void NAME(work_##name)(const struct NAME(name) *given, int64_t first, int64_t last, void *scratch, \
                                  struct Found *found)

/* Lines of the transforms: one in each lane of a vector. A "row" of their passes is a block of 128 bytes of rows of the
   field (two lines per lane of the widest vectors), or of 64 bytes of its columns (one line per lane). */
#define V NAME(Vector)
#define COMPLEX struct NAME(Complex)
#define LANES ((int64_t)(LANE_BYTES / sizeof(REAL)))
#define IN_BLOCK (2 * LANES) /* lines transformed at a time */
#define ROWS ((int64_t)(128 / sizeof(REAL)))
#define COLUMNS ((int64_t)(64 / sizeof(REAL)))
#define TILE ((int64_t)(64 / sizeof(REAL))) /* entries of a line moved at a time */
#define MEDIANS 64 /* computed at a time */

struct Weights { double across_y, across_x, diagonal; };

struct Entry {
    const char *name;
    Pass *pass;
    size_t size; /* of its arguments */
};

/* Clip to the range from 0 to the cap; NaN stays NaN. */
#define HELD(value, cap) SMALLER(cap, LARGER(0, value))
#define ROOT(value) _Generic((value), float: sqrtf, double: sqrt)(value)

static inline int64_t before(int64_t i, int64_t n) { return i > 0 ? i - 1 : n - 1; }
static inline int64_t after(int64_t i, int64_t n) { return i < n - 1 ? i + 1 : 0; }
static inline int64_t wrap(int64_t i, int64_t n) { return (i % n + n) % n; } /* an index, into the period */

/* Connected regions of a periodic map, as a union-find forest of runs (uninterrupted pieces of a row). `parent` of a
   run is the number of its parent plus 1, or for a root minus the number of runs in its tree. `copies` is the periodic
   image of the map, along y and x, in which a run lies relative to its parent. */
struct Copy { int32_t y, x; };

struct Regions {
    int64_t *parent;
    struct Copy *copies;
    double *around; /* whether a region percolates through the period along y, and along x */
};

struct Run { int64_t start, end; };

struct Row {
    struct Run *runs;
    int64_t begin, count; /* index of its first run among all runs, number of its runs */
};

/* Return the root of a run, and the periodic image of the run relative to the root. */
static int64_t root_of(int64_t run, int64_t *parent, struct Copy *copies, struct Copy *seen)
{
    int64_t root = run;
    struct Copy whole = {0, 0};
    for (; parent[root] > 0; root = parent[root] - 1) {
        whole.y += copies[root].y;
        whole.x += copies[root].x;
    }
    *seen = whole;
    while (parent[run] > 0) { /* path compression */
        const int64_t next = parent[run] - 1;
        const struct Copy step = copies[run];
        parent[run] = root + 1;
        copies[run] = whole;
        whole.y -= step.y;
        whole.x -= step.x;
        run = next;
    }
    return root;
}

/* Join the regions of two runs, of which the second lies `step` periodic images away. A region that meets itself in
   another image percolates. */
static void join(const struct Regions *regions, int64_t run, int64_t neighbour, struct Copy step)
{
    int64_t *parent = regions->parent;
    struct Copy own, other;
    const int64_t root = root_of(run, parent, regions->copies, &own);
    const int64_t beside = root_of(neighbour, parent, regions->copies, &other);
    /* periodic image of the other root relative to this one */
    const struct Copy apart = {own.y + step.y - other.y, own.x + step.x - other.x};
    if (root != beside) {
        const int larger = parent[root] <= parent[beside]; /* both are negative numbers of runs */
        const int64_t over = larger ? root : beside, under = larger ? beside : root;
        parent[over] += parent[under];
        parent[under] = over + 1;
        regions->copies[under] = larger ? apart : (struct Copy){-apart.y, -apart.x};
        return;
    }
    if (apart.y)
        regions->around[0] = 1;
    if (apart.x)
        regions->around[1] = 1;
}

/* Join the runs of a row with the runs of the next row that they touch. */
static void join_rows(const struct Regions *regions, const struct Row *row, const struct Row *next, struct Copy step)
{
    for (int64_t a = 0, b = 0; a < row->count && b < next->count;) {
        const struct Run here = row->runs[a], there = next->runs[b];
        if (here.start < there.end && there.start < here.end)
            join(regions, row->begin + a, next->begin + b, step);
        if (here.end < there.end)
            a++;
        else
            b++;
    }
}

#define LEVEL plain
#define LANE_BYTES 16
#include "precisions.h"

/* The same for processors with wider vectors. */
#if defined(__x86_64__) && (defined(__GNUC__) || defined(__clang__))
#define WIDE
#include <cpuid.h>
#ifdef __clang__
#define BEGIN_TARGET(features) DO_PRAGMA(clang attribute push(__attribute__((target(features))), apply_to = function))
#define END_TARGET DO_PRAGMA(clang attribute pop)
#else
#define BEGIN_TARGET(features) DO_PRAGMA(GCC push_options) DO_PRAGMA(GCC target(features))
#define END_TARGET DO_PRAGMA(GCC pop_options)
#endif

BEGIN_TARGET("avx2,fma,bmi,bmi2")
#define LEVEL wide
#define LANE_BYTES 32
#include "precisions.h"
END_TARGET

BEGIN_TARGET("avx2,fma,bmi,bmi2,avx512f,avx512vl,avx512dq,avx512bw")
#define LEVEL widest
#define LANE_BYTES 64
#include "precisions.h"
END_TARGET

/* Return 2 for AVX-512, 1 for AVX2 and FMA, else 0, if the operating system saves their registers. */
static int vectors(void)
{
    unsigned a, b, c, d, low, high;
    if (!__get_cpuid(1, &a, &b, &c, &d) || (c & (bit_FMA | bit_OSXSAVE)) != (bit_FMA | bit_OSXSAVE))
        return 0;
    __asm__("xgetbv" : "=a"(low), "=d"(high) : "c"(0));
    if (!__get_cpuid_count(7, 0, &a, &b, &c, &d))
        return 0;
    const unsigned two = bit_AVX2 | bit_BMI | bit_BMI2, four = bit_AVX512F | bit_AVX512VL | bit_AVX512DQ | bit_AVX512BW;
    if ((low & 6) != 6 || (b & two) != two)
        return 0;
    return (low & 0xe6) == 0xe6 && (b & four) == four ? 2 : 1;
}
#endif

/* Return a pass by its name, such as measure_df, for this processor; NULL if there is none with arguments of `size`
   bytes. */
EXPORT const void *find_pass_given(const char *name, int64_t size)
{
    const struct Entry *entry = table_of_plain;
#ifdef WIDE
    entry = vectors() == 2 ? table_of_widest : vectors() == 1 ? table_of_wide : table_of_plain;
#endif
    for (; entry->name; entry++)
        if (!strcmp(entry->name, name) && entry->size == (size_t)size)
            return (const void *)entry->pass;
    return NULL;
}
