/* The step: STATE, INNER and OUT are the precisions of the old pressure, the correction and the new pressure. */

PASS(advance, {
    const STATE *pressure;
    INNER *correction;
    OUT *out;
    INNER *values;
    double mean, length, cap;
    int64_t nx;
})
{
    const STATE cap = (STATE)given->cap;
    const OUT most = (OUT)given->cap;
    const INNER mean = (INNER)given->mean, length = (INNER)given->length;
    for (int64_t i = first; i < last; i++) {
        const STATE *pressure = given->pressure + i * given->nx;
        INNER *correction = given->correction + i * given->nx, *values = given->values + i * given->nx;
        OUT *out = given->out + i * given->nx;
        VECTOR
        for (int64_t j = 0; j < given->nx; j++) {
            const STATE p = pressure[j];
            const int active = values[j] != 0;
            const INNER own = active ? length : 0;      /* inactive points at the cap keep their pressure ... */
            const OUT start = p >= cap ? most : (OUT)p; /* the cap, in the precision OUT */
            const OUT moved = start - own * (correction[j] - mean);
            const OUT held = active | (p >= cap) ? HELD(moved, most) : 0; /* ... the others become zero */
            out[j] = held;
            correction[j] = (INNER)(moved - held);
            values[j] = FREE(held, most) ? (INNER)1 : (INNER)0;
        }
    }
}
