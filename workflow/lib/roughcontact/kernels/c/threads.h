/* Passes over rows, shared among threads. */

#ifndef THREADS_H
#define THREADS_H

#include <stdint.h>

#ifdef _WIN32
#define EXPORT __declspec(dllexport)
#else
#define EXPORT __attribute__((visibility("default")))
#endif

/* What a pass tells of its rows; that of shares is put together by minimum, maximum and sum. */
struct Found {
    double sums[6], least, most;
};

/* Work on the rows from `first` to `last`, with `scratch` to work in. */
typedef void Pass(const void *given, int64_t first, int64_t last, void *scratch, struct Found *found);

/* Run `pass` over `rows` rows by up to `threads` threads, each with `scratch` bytes to work in. What it finds comes
   into `found`, which is the same however many threads there were in the end. Returns 0, or 1 without memory. */
EXPORT int run_pass(const void *pass, int64_t threads, int64_t rows, int64_t scratch, const void *given,
                    struct Found *found);

#endif
