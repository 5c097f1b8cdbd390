/* The step: STATE, INNER and OUT are the precisions of the pressure before, of the correction and of the pressure. */

PASS(advance, {
    const STATE *pressure, *separation;
    INNER *correction;
    OUT *out;
    INNER *free;
    double offset, mean, length, cap;
    int64_t nx;
})
{
    const STATE offset = (STATE)given->offset, cap = (STATE)given->cap;
    const OUT most = (OUT)given->cap;
    const INNER mean = (INNER)given->mean, length = (INNER)given->length;
    for (int64_t i = first; i < last; i++) {
        const STATE *pressure = given->pressure + i * given->nx, *separation = given->separation + i * given->nx;
        INNER *correction = given->correction + i * given->nx, *free = given->free + i * given->nx;
        OUT *out = given->out + i * given->nx;
        VECTOR
        for (int64_t j = 0; j < given->nx; j++) {
            const STATE p = pressure[j], gap = separation[j] - offset;
            const INNER own = ACTIVE(p, gap, cap) ? length : 0; /* inactive points keep what they have */
            const OUT start = p >= cap ? most : (OUT)p;         /* a rounded cap stands for the cap */
            const OUT moved = start - own * (correction[j] - mean), held = HELD(moved, most);
            out[j] = held;
            correction[j] = (INNER)(moved - held);
            free[j] = FREE(moved, most) ? (INNER)1 : (INNER)0;
        }
    }
}
