/* Worker threads for passes.

   They are started on first use and persist. A pass is divided into more shares than threads, and idle threads
   take the next share (work sharing): the caller never waits for a thread that is still asleep or has no
   processor at the moment. Only one caller uses the threads at a time; another caller meanwhile runs all its
   shares itself. A forked process has no worker threads: callers there must request one thread. */

#include "threads.h"

#include <math.h>
#include <pthread.h>
#include <stdatomic.h>
#include <stddef.h>
#include <stdlib.h>

#define MAX_THREADS 64
#define SHARES_PER_THREAD 4
#define SPIN_COUNT 20000 /* polls before a thread sleeps: up to a millisecond */

struct Job {
    Pass *pass;
    const void *given;
    int64_t rows, shares, scratch;
    char *scratches; /* of each thread */
    struct Found parts[MAX_THREADS * SHARES_PER_THREAD];
};

static pthread_mutex_t turn = PTHREAD_MUTEX_INITIALIZER; /* of callers */
static pthread_mutex_t lock = PTHREAD_MUTEX_INITIALIZER; /* for sleeping and waking */
static pthread_cond_t wake = PTHREAD_COND_INITIALIZER, finished = PTHREAD_COND_INITIALIZER;
static struct Job *job;
/* From the highest bits: number of the job, its threads, its shares, and the first share not yet taken. */
static atomic_uint_fast64_t offer;
#define OFFER(number, threads, shares) ((uint_fast64_t)(number) << 36 | (uint_fast64_t)(threads) << 24 | \
                                        (uint_fast64_t)(shares) << 12)
#define NUMBER(offer) ((offer) >> 36)
static atomic_int_fast64_t pending; /* unfinished shares */
static atomic_int_fast64_t asleep;  /* threads that wait for `wake` */
static atomic_int waits;            /* whether the caller waits for `finished` */
static int64_t started;             /* threads, without the caller */

static inline void wait_a_little(void)
{
#if defined(__x86_64__)
    __builtin_ia32_pause();
#elif defined(__aarch64__)
    __asm__ volatile("yield");
#endif
}

static void do_share(struct Job *of, int64_t share, int64_t thread)
{
    const int64_t first = of->rows * share / of->shares, last = of->rows * (share + 1) / of->shares;
    of->parts[share] = (struct Found){.least = INFINITY, .most = -INFINITY};
    if (first < last)
        of->pass(of->given, first, last, of->scratches + thread * of->scratch, &of->parts[share]);
}

/* Return whether the offer `seen` has a share for a thread. */
static inline int is_open(uint_fast64_t seen, int64_t thread)
{
    return (seen & 0xfff) < (seen >> 12 & 0xfff) && thread < (int64_t)(seen >> 24 & 0xfff);
}

/* Run shares until none is left; the job stays valid as long as any share is unfinished. */
static void do_shares(int64_t thread)
{
    uint_fast64_t seen = atomic_load(&offer);
    while (is_open(seen, thread)) {
        if (!atomic_compare_exchange_weak(&offer, &seen, seen + 1))
            continue;
        do_share(job, (int64_t)(seen & 0xfff), thread);
        if (atomic_fetch_sub(&pending, 1) == 1 && atomic_load(&waits)) {
            pthread_mutex_lock(&lock);
            pthread_cond_signal(&finished);
            pthread_mutex_unlock(&lock);
        }
        seen = atomic_load(&offer);
    }
}

static void *work(void *number)
{
    const int64_t thread = (int64_t)(intptr_t)number;
    for (;;) {
        for (int spins = 0; spins < SPIN_COUNT && !is_open(atomic_load(&offer), thread); spins++)
            wait_a_little();
        if (!is_open(atomic_load(&offer), thread)) {
            pthread_mutex_lock(&lock);
            atomic_fetch_add(&asleep, 1);
            while (!is_open(atomic_load(&offer), thread))
                pthread_cond_wait(&wake, &lock);
            atomic_fetch_sub(&asleep, 1);
            pthread_mutex_unlock(&lock);
        }
        do_shares(thread);
    }
    return NULL;
}

static void do_together(struct Job *given, int64_t threads)
{
    pthread_t next; /* where a thread cannot be started the others run its shares */
    for (; started < threads - 1 && !pthread_create(&next, NULL, work, (void *)(intptr_t)(started + 1)); started++)
        pthread_detach(next);
    job = given;
    atomic_store(&pending, given->shares);
    atomic_store(&offer, OFFER(NUMBER(atomic_load(&offer)) + 1, threads, given->shares));
    if (atomic_load(&asleep)) {
        pthread_mutex_lock(&lock);
        pthread_cond_broadcast(&wake);
        pthread_mutex_unlock(&lock);
    }
    do_shares(0);
    for (int spins = 0; spins < SPIN_COUNT && atomic_load(&pending); spins++)
        wait_a_little();
    if (atomic_load(&pending)) {
        pthread_mutex_lock(&lock);
        atomic_store(&waits, 1);
        while (atomic_load(&pending))
            pthread_cond_wait(&finished, &lock);
        atomic_store(&waits, 0);
        pthread_mutex_unlock(&lock);
    }
}

EXPORT int run_pass(const void *pass, int64_t threads, int64_t rows, int64_t scratch, const void *given,
                    struct Found *found)
{
    struct Job own;
    threads = threads < 1 ? 1 : threads > MAX_THREADS ? MAX_THREADS : threads;
    own.pass = (Pass *)pass;
    own.given = given;
    own.rows = rows;
    own.shares = threads == 1 ? 1 : threads * SHARES_PER_THREAD;
    own.scratch = (scratch + 63) / 64 * 64;
    own.scratches = NULL;
    if (scratch && !(own.scratches = malloc((size_t)(threads * own.scratch))))
        return 1;
    if (threads > 1 && !pthread_mutex_trylock(&turn)) {
        do_together(&own, threads);
        pthread_mutex_unlock(&turn);
    } else
        for (int64_t share = 0; share < own.shares; share++)
            do_share(&own, share, 0);
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
