/* Passes over fields of two precisions: OUTER is that of the state, INNER that of the correction. */

#define INNER REAL_OF(LETTER)

PASS(make_dimensionless, { const OUTER *heights; INNER *out; double reference, scale; int64_t nx; })
{
    const OUTER reference = (OUTER)given->reference, scale = (OUTER)given->scale;
    for (int64_t i = first; i < last; i++) {
        const OUTER *heights = given->heights + i * given->nx;
        INNER *out = given->out + i * given->nx;
        VECTOR
        for (int64_t j = 0; j < given->nx; j++)
            out[j] = (INNER)((heights[j] - reference) * scale);
    }
}

/* Here INNER is the precision of the heights as given by the user. */
PASS(measure, {
    OUTER *separation;
    const INNER *heights;
    const OUTER *start, *before, *pressure;
    double reference, scale, offset, cap;
    int64_t nx;
})
{
    const INNER reference = (INNER)given->reference, scale = (INNER)given->scale;
    const OUTER offset = (OUTER)given->offset, cap = (OUTER)given->cap;
    double work = 0, square = 0, free_sum = 0, slope = 0, slope_after = 0;
    int64_t free = 0;
    for (int64_t i = first; i < last; i++) {
        OUTER *separation = given->separation + i * given->nx;
        const INNER *heights = given->heights + i * given->nx;
        const OUTER *start = given->start + i * given->nx, *before = given->before + i * given->nx;
        const OUTER *pressure = given->pressure + i * given->nx;
        int32_t count = 0;
        SIX_SUMS(work, square, free_sum, slope, slope_after, count)
        for (int64_t j = 0; j < given->nx; j++) {
            const OUTER p = pressure[j], u = separation[j];
            const OUTER v = u - (heights[j] - reference) * scale, change = p - start[j];
            const int is_free = FREE(p, cap);
            separation[j] = v;
            work += p * u;
            square += u * u;
            free_sum += is_free ? v : (OUTER)0;
            slope += change * (before[j] - offset);
            slope_after += change * (v - offset);
            count += is_free;
        }
        free += count;
    }
    const double sums[] = {work, square, free_sum, (double)free, slope, slope_after};
    memcpy(found->sums, sums, sizeof sums);
}

/* The passes that find an active set also give its share in the cells of the next coarser grid. */
PASS(masked_residual, {
    const OUTER *pressure, *separation;
    INNER *values, *share, *means;
    double offset, cap;
    int64_t ny, nx, fy, fx;
})
{
    const OUTER offset = (OUTER)given->offset, cap = (OUTER)given->cap;
    const int64_t nx = given->nx, fx = given->fx, cells = INNER_NAME(cells_of)(nx, fx);
    const INNER part = (INNER)1 / (INNER)(given->fy * fx);
    for (int64_t block = first; block < last; block++) {
        const int64_t start = block * given->fy, rows = SMALLER(given->fy, given->ny - start);
        const OUTER *pressure = given->pressure + start * nx, *separation = given->separation + start * nx;
        INNER *values = given->values + start * nx;
        VECTOR
        for (int64_t j = 0; j < rows * nx; j++) {
            const OUTER gap = separation[j] - offset;
            const int active = ACTIVE(pressure[j], gap, cap);
            const INNER value = (INNER)gap;
            values[j] = active ? (value == 0 ? (INNER)CLOSED : value) : (INNER)0;
        }
        INNER_NAME(share_of_rows)(values, rows, nx, fx, part, scratch, given->share + block * cells);
        INNER_NAME(mean_of_rows)(values, rows, nx, fx, part, scratch, given->means + block * cells);
    }
}

PASS(predict_active, {
    const OUTER *pressure;
    const INNER *residual;
    INNER *values, *share, *means;
    struct Weights weights;
    double stiffness, cap;
    int64_t ny, nx, fy, fx;
})
{
    const OUTER cap = (OUTER)given->cap;
    const INNER stiffness = (INNER)given->stiffness, part = (INNER)1 / (INNER)(given->fy * given->fx);
    const int64_t ny = given->ny, nx = given->nx, fx = given->fx, cells = INNER_NAME(cells_of)(nx, fx);
    INNER *columns = scratch, *mean = columns + nx, *row = mean + nx;
    for (int64_t block = first; block < last; block++) {
        const int64_t start = block * given->fy, rows = SMALLER(given->fy, ny - start);
        for (int64_t i = start; i < start + rows; i++) {
            const OUTER *pressure = given->pressure + i * nx;
            const INNER *residual = given->residual + i * nx;
            const INNER *up = given->residual + before(i, ny) * nx, *down = given->residual + after(i, ny) * nx;
            INNER *values = given->values + i * nx;
            INNER_NAME(around)(up, residual, down, &given->weights, row, mean, nx);
            VECTOR
            for (int64_t j = 0; j < nx; j++) {
                const OUTER p = pressure[j], foreseen = p - stiffness * (residual[j] - mean[j]);
                values[j] = (foreseen > 0) | (p >= cap) ? values[j] : (INNER)0;
            }
        }
        const INNER *values = given->values + start * nx;
        INNER_NAME(share_of_rows)(values, rows, nx, fx, part, columns, given->share + block * cells);
        INNER_NAME(mean_of_rows)(values, rows, nx, fx, part, columns, given->means + block * cells);
    }
}

PASS(redistribute, {
    OUTER *field;
    const INNER *passed, *coarse, *free;
    double cap;
    int64_t ny, nx, fy, fx;
})
{
    const int64_t cells = INNER_NAME(cells_of)(given->nx, given->fx);
    const OUTER cap = (OUTER)given->cap;
    const INNER share = (INNER)1 / (INNER)(given->fy * given->fx);
    INNER *row = scratch;
    double outside = 0, total = 0;
    for (int64_t block = first; block < last; block++) {
        INNER_NAME(unfold)(given->coarse + block * cells, given->nx, given->fx, share, row);
        for (int64_t i = block * given->fy; i < SMALLER((block + 1) * given->fy, given->ny); i++) {
            OUTER *field = given->field + i * given->nx;
            const INNER *passed = given->passed + i * given->nx, *free = given->free + i * given->nx;
            TWO_SUMS(outside, total)
            for (int64_t j = 0; j < given->nx; j++) {
                const INNER change = passed[j] + row[j];
                const OUTER value = field[j] + (free[j] == 0 ? (INNER)0 : change), held = HELD(value, cap);
                const OUTER off = value - held;
                field[j] = value;
                outside += off > 0 ? off : -off;
                total += held;
            }
        }
    }
    found->sums[0] = outside;
    found->sums[1] = total;
}

PASS(project, {
    OUTER *field;
    INNER *taken, *free, *share;
    double cap;
    int64_t ny, nx, fy, fx;
})
{
    const OUTER cap = (OUTER)given->cap;
    const int64_t nx = given->nx, fx = given->fx, cells = INNER_NAME(cells_of)(nx, fx);
    const INNER part = (INNER)1 / (INNER)(given->fy * fx);
    for (int64_t block = first; block < last; block++) {
        const int64_t start = block * given->fy, rows = SMALLER(given->fy, given->ny - start);
        OUTER *field = given->field + start * nx;
        INNER *taken = given->taken + start * nx, *free = given->free + start * nx;
        VECTOR
        for (int64_t j = 0; j < rows * nx; j++) {
            const OUTER value = field[j], held = HELD(value, cap);
            field[j] = held;
            taken[j] = (INNER)(value - held);
            free[j] = FREE(value, cap) ? (INNER)1 : (INNER)0;
        }
        INNER_NAME(mean_of_rows)(free, rows, nx, fx, part, scratch, given->share + block * cells);
    }
}

PASS(project_residual, {
    const OUTER *pressure, *separation;
    INNER *values;
    double offset, cap;
    int64_t nx;
})
{
    const OUTER offset = (OUTER)given->offset, cap = (OUTER)given->cap;
    double total = 0;
    for (int64_t i = first; i < last; i++) {
        const OUTER *pressure = given->pressure + i * given->nx, *separation = given->separation + i * given->nx;
        INNER *values = given->values + i * given->nx;
        SUM(total)
        for (int64_t j = 0; j < given->nx; j++) {
            const OUTER p = pressure[j];
            const INNER value = values[j], gap = (INNER)(separation[j] - offset);
            const INNER least = SMALLER(gap, value), below = p <= 0 ? least : value;
            const INNER most = LARGER(gap, below), held = p >= cap ? most : below;
            const INNER change = held - value;
            values[j] = held;
            total += change * change;
        }
    }
    found->sums[0] = total;
}

#undef INNER
#undef TYPES
#undef OUTER
#undef LETTER
