/* Callers and threads under ThreadSanitizer: three callers start passes of many shares at once, with one to four
   threads each, and every sum must be right. Exits with 1 where one is not; the sanitizer itself exits with 66.
   Compiled with SEEDED it has a race, which must be found. */

#include <pthread.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>

#include "threads.h"

#define CALLERS 3
#define PASSES 400
#define ROWS 257

struct Given {
    int64_t *rows; /* each is written by the one that has its share */
    int64_t plus;
};

#ifdef SEEDED
static int64_t unguarded;
#endif

static void count(const void *given, int64_t first, int64_t last, void *scratch, struct Found *found)
{
    const struct Given *of = given;
    int64_t *own = scratch; /* of the thread alone */
    *own = 0;
    for (int64_t row = first; row < last; row++) {
        of->rows[row] += of->plus;
        *own += of->rows[row];
        found->least = of->rows[row] < found->least ? of->rows[row] : found->least;
        found->most = of->rows[row] > found->most ? of->rows[row] : found->most;
    }
    found->sums[0] += (double)*own;
#ifdef SEEDED
    unguarded += *own;
#endif
}

static void *call(void *number)
{
    int64_t rows[ROWS] = {0}, wrong = 0;
    struct Given given = {rows, (int64_t)(intptr_t)number + 1};
    for (int64_t pass = 1; pass <= PASSES; pass++) {
        struct Found found = {0};
        if (run_pass(count, 1 + pass % 4, ROWS, 64, &given, &found))
            return (void *)1;
        const int64_t each = pass * given.plus;
        wrong += found.sums[0] != (double)(ROWS * each) || found.least != each || found.most != each;
    }
    return (void *)(intptr_t)wrong;
}

int main(void)
{
    pthread_t callers[CALLERS];
    int64_t wrong = 0;
    for (intptr_t k = 0; k < CALLERS; k++)
        if (pthread_create(&callers[k], NULL, call, (void *)k))
            return 1;
    for (int k = 0; k < CALLERS; k++) {
        void *found;
        pthread_join(callers[k], &found);
        wrong += (int64_t)(intptr_t)found;
    }
    printf("%d passes, %d wrong\n", CALLERS * PASSES, (int)wrong);
    return wrong != 0;
}
