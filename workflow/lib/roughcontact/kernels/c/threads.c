/* Threads that wait for passes.

   They are started when they are first wanted, and stay. One caller has them at a time; another one meanwhile
   does all its shares itself. None is left in a process that was forked: callers there must ask for one share. */

#include "threads.h"

#include <math.h>
#include <pthread.h>
#include <stdatomic.h>
#include <stddef.h>
#include <stdlib.h>

#define MOST 64       /* shares */
#define PATIENCE 2000 /* looks at what another thread does before this one lies down */

struct Job {
    Pass *pass;
    const void *given;
    int64_t rows, shares, scratch;
    char *scratches;
    struct Found parts[MOST];
};

static pthread_mutex_t turn = PTHREAD_MUTEX_INITIALIZER; /* of callers */
static pthread_mutex_t lock = PTHREAD_MUTEX_INITIALIZER; /* of those who lie down and those who wake them */
static pthread_cond_t wake = PTHREAD_COND_INITIALIZER, rest = PTHREAD_COND_INITIALIZER;
static struct Job *job;
static atomic_uint_fast64_t call;   /* MOST + 1 times the number of the job, plus the shares that it has */
static atomic_int_fast64_t pending; /* shares of it that are not done, but for the caller's own */
static int64_t started;             /* threads, the caller not counted */
static uint_fast64_t first_call[MOST];

static inline void wait_a_little(void)
{
#if defined(__x86_64__)
    __builtin_ia32_pause();
#elif defined(__aarch64__)
    __asm__ volatile("yield");
#endif
}

static void do_share(struct Job *of, int64_t share)
{
    const int64_t first = of->rows * share / of->shares, last = of->rows * (share + 1) / of->shares;
    of->parts[share] = (struct Found){.least = INFINITY, .most = -INFINITY};
    if (first < last)
        of->pass(of->given, first, last, of->scratches + share * of->scratch, &of->parts[share]);
}

static void *work(void *number)
{
    const uint_fast64_t own = (uint_fast64_t)(intptr_t)number;
    uint_fast64_t heard = first_call[own];
    for (;;) {
        for (int looks = 0; looks < PATIENCE && atomic_load(&call) == heard; looks++)
            wait_a_little();
        if (atomic_load(&call) == heard) {
            pthread_mutex_lock(&lock);
            while (atomic_load(&call) == heard)
                pthread_cond_wait(&wake, &lock);
            pthread_mutex_unlock(&lock);
        }
        heard = atomic_load(&call);
        if (own >= heard % (MOST + 1))
            continue; /* not meant: the job may be over already */
        do_share(job, (int64_t)own);
        if (atomic_fetch_sub(&pending, 1) == 1) {
            pthread_mutex_lock(&lock);
            pthread_cond_signal(&rest);
            pthread_mutex_unlock(&lock);
        }
    }
    return NULL;
}

/* Return whether there are threads for so many shares, the caller's own counted; start them where not. */
static int enough_threads(int64_t shares)
{
    while (started < shares - 1) {
        pthread_t thread;
        const int64_t number = started + 1;
        first_call[number] = atomic_load(&call);
        if (pthread_create(&thread, NULL, work, (void *)(intptr_t)number))
            return 0;
        pthread_detach(thread);
        started++;
    }
    return 1;
}

static void do_together(struct Job *given)
{
    job = given;
    atomic_store(&pending, given->shares - 1);
    pthread_mutex_lock(&lock);
    atomic_store(&call, (atomic_load(&call) / (MOST + 1) + 1) * (MOST + 1) + (uint_fast64_t)given->shares);
    pthread_cond_broadcast(&wake);
    pthread_mutex_unlock(&lock);
    do_share(given, 0);
    for (int looks = 0; looks < PATIENCE && atomic_load(&pending); looks++)
        wait_a_little();
    if (atomic_load(&pending)) {
        pthread_mutex_lock(&lock);
        while (atomic_load(&pending))
            pthread_cond_wait(&rest, &lock);
        pthread_mutex_unlock(&lock);
    }
}

EXPORT int run_pass(const void *pass, int64_t shares, int64_t rows, int64_t scratch, const void *given,
                    struct Found *found)
{
    struct Job own;
    own.pass = (Pass *)pass;
    own.given = given;
    own.rows = rows;
    own.shares = shares < 1 ? 1 : shares > MOST ? MOST : shares;
    own.scratch = (scratch + 63) / 64 * 64;
    own.scratches = NULL;
    if (scratch && !(own.scratches = malloc((size_t)(own.shares * own.scratch))))
        return 1;
    if (own.shares > 1 && !pthread_mutex_trylock(&turn)) {
        if (enough_threads(own.shares))
            do_together(&own);
        else
            for (int64_t share = 0; share < own.shares; share++)
                do_share(&own, share);
        pthread_mutex_unlock(&turn);
    } else
        for (int64_t share = 0; share < own.shares; share++)
            do_share(&own, share);
    free(own.scratches);
    *found = own.parts[0];
    for (int64_t share = 1; share < own.shares; share++) {
        const struct Found *part = &own.parts[share];
        for (int k = 0; k < 6; k++)
            found->sums[k] += part->sums[k];
        found->least = part->least < found->least ? part->least : found->least;
        found->most = part->most > found->most ? part->most : found->most;
    }
    return 0;
}
