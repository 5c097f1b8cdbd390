/* Passes over rows, distributed over threads. */

#ifndef THREADS_H
#define THREADS_H

#include <stdint.h>

#ifdef _WIN32
#define EXPORT __declspec(dllexport)
#else
#define EXPORT __attribute__((visibility("default")))
#endif

/* Reductions of a pass over its rows; those of shares are combined by minimum, maximum and sum. */
struct Found {
    double sums[6], least, most;
};

/* Process the rows from `first` to `last`, with `scratch` as work memory. */
typedef void Pass(const void *given, int64_t first, int64_t last, void *scratch, struct Found *found);

/* Run `pass` over `rows` rows with up to `threads` threads, each with `scratch` bytes of work memory. The reductions
   go to `found`; they do not depend on the number of threads that took part. Returns 0, or 1 if memory is short. */
EXPORT int run_pass(const void *pass, int64_t threads, int64_t rows, int64_t scratch, const void *given,
                    struct Found *found);

#endif
