/* The step: STATE, INNER and OUT are the precisions of the old pressure, the correction and the new pressure. */

#define INNER REAL_OF(LETTER)

PASS(advance, {
    const STATE *pressure;
    INNER *correction;
    const INNER *passed, *coarse;
    OUT *out;
    INNER *values, *share;
    double mean, length, cap;
    int64_t ny, nx, fy, fx;
})
{
    const STATE cap = (STATE)given->cap;
    const OUT most = (OUT)given->cap;
    const INNER mean = (INNER)given->mean, length = (INNER)given->length;
    const int64_t nx = given->nx, fx = given->fx, cells = INNER_NAME(cells_of)(nx, fx);
    const INNER part = (INNER)1 / (INNER)(given->fy * fx);
    INNER *row = scratch;
    for (int64_t block = first; block < last; block++) {
        const int64_t start = block * given->fy, rows = SMALLER(given->fy, given->ny - start);
        INNER_NAME(unfold)(given->coarse + block * cells, nx, fx, part, row);
        for (int64_t i = start; i < start + rows; i++) {
            const STATE *pressure = given->pressure + i * nx;
            const INNER *passed = given->passed + i * nx;
            INNER *correction = given->correction + i * nx, *values = given->values + i * nx;
            OUT *out = given->out + i * nx;
            VECTOR
            for (int64_t j = 0; j < nx; j++) {
                const STATE p = pressure[j];
                const INNER whole = correction[j] + (passed[j] + row[j]);
                const int active = values[j] != 0;
                const INNER own = active ? length : 0;      /* inactive points at the cap keep their pressure ... */
                const OUT start = p >= cap ? most : (OUT)p; /* the cap, in the precision OUT */
                const OUT moved = start - own * (whole - mean);
                const OUT held = active | (p >= cap) ? HELD(moved, most) : 0; /* ... the others become zero */
                out[j] = held;
                correction[j] = (INNER)(moved - held);
                values[j] = FREE(held, most) ? (INNER)1 : (INNER)0;
            }
        }
        /* where the load of the coarse cells was, which these rows have taken over */
        INNER_NAME(mean_of_rows)(given->values + start * nx, rows, nx, fx, part, row, given->share + block * cells);
    }
}

#undef INNER
#undef TYPES
#undef STATE
#undef OUT
#undef LETTER
