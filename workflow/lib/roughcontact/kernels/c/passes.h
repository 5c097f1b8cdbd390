/* Passes over fields of one precision, REAL. Included once for each precision and each kind of processor.

   `array_api.py` defines what they compute. Every pass processes the rows from `first` to `last`; passes between a
   fine and a coarse grid count the rows of the coarse one. `scratch` is work memory of the thread. */

#define REAL REAL_OF(TYPES)

/* ---- rows ---- */

/* Return the number of cells of `factor` points in a row of `n` points; the last cell may have fewer points. */
static inline int64_t NAME(cells_of)(int64_t n, int64_t factor) { return (n + factor - 1) / factor; }

/* Write the sums over groups of `factor` among `n` points, times `share`, to `out`. */
static inline void NAME(fold_by)(const REAL *columns, int64_t n, int64_t factor, REAL share, REAL *out)
{
    VECTOR
    for (int64_t j = 0; j < n / factor; j++) {
        REAL total = columns[j * factor];
        for (int64_t k = 1; k < factor; k++)
            total += columns[j * factor + k];
        out[j] = total * share;
    }
    if (n % factor) {
        REAL total = 0;
        for (int64_t k = n - n % factor; k < n; k++)
            total += columns[k];
        out[n / factor] = total * share;
    }
}

static void NAME(fold)(const REAL *columns, int64_t n, int64_t factor, REAL share, REAL *out)
{
    BY_FACTOR(fold_by, columns, n, factor, share, out);
}

/* Write every value of `coarse`, times `share`, `factor` times to `out`, up to `n` values. */
static inline void NAME(unfold_by)(const REAL *coarse, int64_t n, int64_t factor, REAL share, REAL *out)
{
    VECTOR
    for (int64_t j = 0; j < n / factor; j++)
        for (int64_t k = 0; k < factor; k++)
            out[j * factor + k] = coarse[j] * share;
    for (int64_t k = n - n % factor; k < n; k++)
        out[k] = coarse[n / factor] * share;
}

static void NAME(unfold)(const REAL *coarse, int64_t n, int64_t factor, REAL share, REAL *out)
{
    BY_FACTOR(unfold_by, coarse, n, factor, share, out);
}

/* Write the weighted means of the eight neighbours of the row `here` to `result`; `row`: work memory, nx + 2. */
static inline void NAME(around)(const REAL *up, const REAL *here, const REAL *down, const struct Weights *weights,
                                REAL *row, REAL *result, int64_t nx)
{
    const REAL across_y = (REAL)weights->across_y, across_x = (REAL)weights->across_x;
    const REAL diagonal = (REAL)weights->diagonal;
    VECTOR
    for (int64_t j = 0; j < nx; j++) {
        const REAL column = up[j] + down[j];
        row[j + 1] = across_x * here[j] + diagonal * column;
        result[j] = across_y * column;
    }
    row[0] = row[nx];
    row[nx + 1] = row[1];
    VECTOR
    for (int64_t j = 0; j < nx; j++)
        result[j] += row[j] + row[j + 2];
}

/* ---- spectra, as pairs of real and imaginary parts ---- */

PASS(multiply, { REAL *spectrum; const REAL *symbol; int64_t nx; })
{
    for (int64_t i = first; i < last; i++) {
        REAL *spectrum = given->spectrum + 2 * i * given->nx;
        const REAL *symbol = given->symbol + i * given->nx;
        if (i == 0)
            spectrum[0] = spectrum[1] = 0;
        VECTOR
        for (int64_t j = i == 0; j < given->nx; j++) {
            spectrum[2 * j] *= symbol[j];
            spectrum[2 * j + 1] *= symbol[j];
        }
    }
}

PASS(divide, { REAL *spectrum; const REAL *symbol, *weights; int64_t nx; })
{
    const REAL *weights = given->weights;
    double energy = 0;
    for (int64_t i = first; i < last; i++) {
        REAL *spectrum = given->spectrum + 2 * i * given->nx;
        const REAL *symbol = given->symbol + i * given->nx;
        if (i == 0)
            spectrum[0] = spectrum[1] = 0;
        SUM(energy)
        for (int64_t j = i == 0; j < given->nx; j++) {
            const REAL real = spectrum[2 * j], imaginary = spectrum[2 * j + 1], factor = 1 / symbol[j];
            energy += (real * real + imaginary * imaginary) * factor * weights[j];
            spectrum[2 * j] = real * factor;
            spectrum[2 * j + 1] = imaginary * factor;
        }
    }
    found->sums[0] = energy;
}

PASS(inverse_root, { const REAL *along_y, *along_x; REAL *out; int64_t nx; })
{
    for (int64_t i = first; i < last; i++) {
        const REAL *along_x = given->along_x, y = given->along_y[i];
        REAL *out = given->out + i * given->nx;
        VECTOR
        for (int64_t j = 0; j < given->nx; j++)
            out[j] = 2 / ROOT(y + along_x[j]);
    }
}

PASS(slope_power, { const REAL *spectrum; const double *weights, *along_y, *along_x; int64_t nx; })
{
    const double *weights = given->weights, *along_x = given->along_x;
    double total = 0;
    for (int64_t i = first; i < last; i++) {
        const REAL *spectrum = given->spectrum + 2 * i * given->nx;
        const double y = given->along_y[i];
        SUM(total)
        for (int64_t j = 0; j < given->nx; j++) {
            const REAL real = spectrum[2 * j], imaginary = spectrum[2 * j + 1];
            total += (real * real + imaginary * imaginary) * (weights[j] * (y + along_x[j]));
        }
    }
    found->sums[0] = total;
}

/* ---- regions ---- */

/* Whether a connected region of the points at or above `level` percolates through the period along y and along x: the
   first and the second sum. Regions consist of runs, uninterrupted pieces of a row: see `join`. */
PASS(percolates, { const REAL *field; const int64_t *parent, *copies; double level; int64_t ny, nx; })
{
    const int64_t ny = given->ny, nx = given->nx;
    const struct Regions regions = {(int64_t *)given->parent, (struct Copy *)given->copies, found->sums};
    struct Row top = {0}, above = {0};
    (void)first, (void)last;
    for (int64_t i = 0; i < ny; i++) {
        const REAL *field = given->field + i * nx;
        /* the first row is kept for the last one, every other row for the next one */
        struct Row row = {(struct Run *)scratch + (i ? 1 + i % 2 : 0) * (nx / 2 + 1), above.begin + above.count, 0};
        for (int64_t j = 0; j < nx; j++) {
            if (!(field[j] >= given->level))
                continue;
            const int64_t start = j++;
            while (j < nx && field[j] >= given->level)
                j++;
            regions.parent[row.begin + row.count] = -1;
            row.runs[row.count++] = (struct Run){start, j};
        }
        if (row.count && row.runs[0].start == 0 && row.runs[row.count - 1].end == nx)
            join(&regions, row.begin + row.count - 1, row.begin, (struct Copy){0, 1});
        join_rows(&regions, &above, &row, (struct Copy){0, 0});
        above = row;
        if (i == 0)
            top = row;
    }
    join_rows(&regions, &above, &top, (struct Copy){1, 0});
}

/* ---- fields ---- */

PASS(extent, { const REAL *field; int64_t nx; })
{
    const int64_t nx = given->nx;
    REAL *least = scratch, *most = least + nx; /* of every column, which allows vectorisation */
    int64_t missing = 0;
    memcpy(least, given->field + first * nx, (size_t)nx * sizeof(REAL));
    memcpy(most, least, (size_t)nx * sizeof(REAL));
    for (int64_t i = first; i < last; i++) {
        const REAL *field = given->field + i * nx;
        int32_t strange = 0;
        SUM(strange)
        for (int64_t j = 0; j < nx; j++) {
            const REAL value = field[j];
            least[j] = SMALLER(value, least[j]);
            most[j] = LARGER(value, most[j]);
            strange += value - value != 0; /* only for infinities and NaN */
        }
        missing += strange;
    }
    for (int64_t j = 0; j < nx; j++) {
        found->least = SMALLER(least[j], found->least);
        found->most = LARGER(most[j], found->most);
    }
    found->sums[0] = (double)missing;
}

PASS(rescale, { REAL *field; double factor, cap; int64_t nx; })
{
    const REAL factor = (REAL)given->factor, cap = (REAL)given->cap;
    double total = 0;
    for (int64_t i = first; i < last; i++) {
        REAL *field = given->field + i * given->nx;
        SUM(total)
        for (int64_t j = 0; j < given->nx; j++) {
            const REAL value = HELD(field[j], cap) * factor;
            field[j] = value;
            total += value;
        }
    }
    found->sums[0] = total;
}

PASS(product, { const REAL *left, *right; int64_t nx; })
{
    const REAL *left = given->left, *right = given->right;
    double total = 0;
    SUM(total)
    for (int64_t j = first * given->nx; j < last * given->nx; j++)
        total += left[j] * right[j];
    found->sums[0] = total;
}

PASS(restore_units, { REAL *pressure, *gap; int8_t *contact; double offset, pressure_unit, gap_unit; int64_t nx; })
{
    const int64_t nx = given->nx;
    const REAL offset = (REAL)given->offset;
    const REAL pressure_unit = (REAL)given->pressure_unit, gap_unit = (REAL)given->gap_unit;
    REAL *least = scratch; /* of every column */
    double total = 0;
    for (int64_t j = 0; j < nx; j++)
        least[j] = INFINITY;
    for (int64_t i = first; i < last; i++) {
        REAL *pressure = given->pressure + i * nx, *gap = given->gap + i * nx;
        int8_t *contact = given->contact + i * nx;
        SUM(total)
        for (int64_t j = 0; j < nx; j++) {
            const REAL p = pressure[j] * pressure_unit, g = (gap[j] - offset) * gap_unit;
            pressure[j] = p;
            gap[j] = g;
            contact[j] = p > 0;
            total += p;
            least[j] = SMALLER(g, least[j]);
        }
    }
    for (int64_t j = 0; j < nx; j++)
        found->least = SMALLER(least[j], found->least);
    found->sums[0] = total;
}

/* ---- from a fine grid to a coarse one, and back ---- */

/* Write the means of one row of blocks, `rows` high and `fx` wide, to `out`; `share`: one over the points of a complete
   block, `columns`: work memory, nx. */
static void NAME(mean_of_rows)(const REAL *field, int64_t rows, int64_t nx, int64_t fx, REAL share, REAL *columns,
                               REAL *out)
{
    memcpy(columns, field, (size_t)nx * sizeof(REAL));
    for (int64_t k = 1; k < rows; k++)
        VECTOR
        for (int64_t j = 0; j < nx; j++)
            columns[j] += field[k * nx + j];
    NAME(fold)(columns, nx, fx, share, out);
}

/* The same for the share of points where the field is not zero. */
static void NAME(share_of_rows)(const REAL *active, int64_t rows, int64_t nx, int64_t fx, REAL share, REAL *columns,
                                REAL *out)
{
    memset(columns, 0, (size_t)nx * sizeof(REAL));
    for (int64_t k = 0; k < rows; k++)
        VECTOR
        for (int64_t j = 0; j < nx; j++)
            columns[j] += active[k * nx + j] == 0 ? (REAL)0 : (REAL)1;
    NAME(fold)(columns, nx, fx, share, out);
}

PASS(block_mean, { const REAL *field; REAL *out; int64_t ny, nx, fy, fx; })
{
    const int64_t nx = given->nx, fy = given->fy, cells = NAME(cells_of)(nx, given->fx);
    for (int64_t i = first; i < last; i++)
        NAME(mean_of_rows)(given->field + i * fy * nx, SMALLER(fy, given->ny - i * fy), nx, given->fx,
                           (REAL)1 / (REAL)(fy * given->fx), scratch, given->out + i * cells);
}

/* `weigh` of array_api.py for cells of `points` parts each; the arrangement is passed as an integer. Without
   `next_share` there is no coarser grid. */
PASS(weigh, {
    const REAL *parts, *share;
    REAL *empty, *gain, *next_parts, *next_share;
    int64_t ny, nx, points, arrangement, fy, fx;
})
{
    const int64_t nx = given->nx, fy = given->fy, fx = given->fx, cells = NAME(cells_of)(nx, fx);
    const int64_t arrangement = given->arrangement;
    const REAL points = (REAL)given->points, root = (REAL)sqrt((double)given->points);
    const REAL part = (REAL)1 / (REAL)(fy * fx);
    REAL *columns = scratch, *weights = columns + nx;
    for (int64_t block = first; block < last; block++) {
        const int64_t start = block * fy, rows = SMALLER(fy, given->ny - start);
        const REAL *parts = given->parts + start * nx, *share = given->share + start * nx;
        REAL *empty = given->empty + start * nx, *gain = given->gain + start * nx;
        if (arrangement == ALONG_A_LINE)
            for (int64_t j = 0; j < rows * nx; j++) {
                weights[j] = points * parts[j] / (1 + (points - 1) * parts[j]);
                gain[j] = weights[j] / (parts[j] > 0 ? parts[j] : (REAL)1);
            }
        else
            VECTOR
            for (int64_t j = 0; j < rows * nx; j++) {
                const REAL whole = ROOT(share[j]), apart = parts[j] * root, below = 1 + apart - whole;
                const REAL own = parts[j] > 0 ? parts[j] : 1, inverse = 1 / (below * own);
                const REAL pieces = apart * own * inverse;
                weights[j] = arrangement == SCATTERED ? pieces : ROOT(whole * pieces);
                gain[j] = weights[j] * below * inverse;
            }
        VECTOR
        for (int64_t j = 0; j < rows * nx; j++)
            empty[j] = 1 - weights[j];
        if (!given->next_share)
            continue;
        NAME(mean_of_rows)(weights, rows, nx, fx, part, columns, given->next_parts + block * cells);
        NAME(mean_of_rows)(share, rows, nx, fx, part, columns, given->next_share + block * cells);
    }
}

PASS(mix, { const REAL *values, *empty, *coarse; REAL *out; int64_t ny, nx, fy, fx; })
{
    const int64_t cells = NAME(cells_of)(given->nx, given->fx);
    REAL *row = scratch;
    for (int64_t block = first; block < last; block++) {
        NAME(unfold)(given->coarse + block * cells, given->nx, given->fx, 1, row);
        for (int64_t i = block * given->fy; i < SMALLER((block + 1) * given->fy, given->ny); i++) {
            const REAL *values = given->values + i * given->nx, *empty = given->empty + i * given->nx;
            REAL *out = given->out + i * given->nx;
            VECTOR
            for (int64_t j = 0; j < given->nx; j++)
                out[j] = values[j] + empty[j] * row[j];
        }
    }
}

PASS(neighbours, { const REAL *field; REAL *out; struct Weights weights; int64_t ny, nx; })
{
    const int64_t ny = given->ny, nx = given->nx;
    for (int64_t i = first; i < last; i++)
        NAME(around)(given->field + before(i, ny) * nx, given->field + i * nx, given->field + after(i, ny) * nx,
                     &given->weights, scratch, given->out + i * nx, nx);
}

PASS(fill, { const REAL *values, *empty, *mixed; REAL *out; struct Weights weights; int64_t ny, nx; })
{
    const int64_t ny = given->ny, nx = given->nx;
    REAL *result = scratch, *row = result + nx;
    for (int64_t i = first; i < last; i++) {
        const REAL *values = given->values + i * nx, *empty = given->empty + i * nx;
        REAL *out = given->out + i * nx;
        NAME(around)(given->mixed + before(i, ny) * nx, given->mixed + i * nx, given->mixed + after(i, ny) * nx,
                     &given->weights, row, result, nx);
        VECTOR
        for (int64_t j = 0; j < nx; j++)
            out[j] = values[j] + empty[j] * result[j];
    }
}

PASS(fill_from, {
    const REAL *values, *active, *coarse;
    REAL *out;
    struct Weights weights;
    int64_t ny, nx, fy, fx;
})
{
    const int64_t ny = given->ny, nx = given->nx, cells = NAME(cells_of)(nx, given->fx);
    /* mixed: cyclic buffer of the previous, the current and the next row */
    REAL *mixed = scratch, *result = mixed + 3 * nx, *row = result + nx;
    for (int64_t i = first - 1; i <= last; i++) {
        const int64_t at = i < 0 ? ny - 1 : i == ny ? 0 : i;
        const REAL *values = given->values + at * nx, *active = given->active + at * nx;
        REAL *next = mixed + (i + 1) % 3 * nx;
        NAME(unfold)(given->coarse + at / given->fy * cells, nx, given->fx, 1, result);
        VECTOR
        for (int64_t j = 0; j < nx; j++)
            next[j] = values[j] + (active[j] == 0 ? result[j] : (REAL)0);
        if (i <= first)
            continue;
        /* now both neighbours of the previous row are known */
        const REAL *own = given->values + (i - 1) * nx, *own_active = given->active + (i - 1) * nx;
        REAL *out = given->out + (i - 1) * nx;
        NAME(around)(mixed + (i + 2) % 3 * nx, mixed + i % 3 * nx, next, &given->weights, row, result, nx);
        VECTOR
        for (int64_t j = 0; j < nx; j++)
            out[j] = own[j] + (own_active[j] == 0 ? result[j] : (REAL)0);
    }
}

PASS(empty_neighbours, { const REAL *field, *empty; REAL *out; struct Weights weights; int64_t ny, nx; })
{
    const int64_t ny = given->ny, nx = given->nx;
    REAL *gaps = scratch, *row = gaps + 3 * nx; /* of the previous, the current and the next row */
    for (int64_t i = first; i < last; i++) {
        for (int64_t k = 0; k < 3; k++) {
            const int64_t start = wrap(i + k - 1, ny) * nx;
            const REAL *field = given->field + start, *empty = given->empty + start;
            VECTOR
            for (int64_t j = 0; j < nx; j++)
                gaps[k * nx + j] = field[j] * empty[j];
        }
        NAME(around)(gaps, gaps + nx, gaps + 2 * nx, &given->weights, row, given->out + i * nx, nx);
    }
}

PASS(gather, { const REAL *field, *empty; REAL *out; int64_t ny, nx, fy, fx; })
{
    const int64_t cells = NAME(cells_of)(given->nx, given->fx);
    REAL *columns = scratch;
    for (int64_t block = first; block < last; block++) {
        memset(columns, 0, (size_t)given->nx * sizeof(REAL));
        for (int64_t i = block * given->fy; i < SMALLER((block + 1) * given->fy, given->ny); i++) {
            const REAL *field = given->field + i * given->nx, *empty = given->empty + i * given->nx;
            VECTOR
            for (int64_t j = 0; j < given->nx; j++)
                columns[j] += field[j] * empty[j];
        }
        NAME(fold)(columns, given->nx, given->fx, 1, given->out + block * cells);
    }
}

PASS(empty_from, {
    const REAL *field, *active;
    REAL *passed, *coarse;
    struct Weights weights;
    int64_t ny, nx, fy, fx;
})
{
    const int64_t ny = given->ny, nx = given->nx, cells = NAME(cells_of)(nx, given->fx);
    const int64_t start = first * given->fy, end = SMALLER(last * given->fy, ny);
    REAL *gaps = scratch, *columns = gaps + 3 * nx, *row = columns + nx;
    for (int64_t i = start - 1; i <= end; i++) {
        const int64_t at = i < 0 ? ny - 1 : i == ny ? 0 : i;
        const REAL *field = given->field + at * nx, *active = given->active + at * nx;
        REAL *next = gaps + (i + 1) % 3 * nx;
        VECTOR
        for (int64_t j = 0; j < nx; j++)
            next[j] = active[j] == 0 ? field[j] : (REAL)0;
        if (i <= start)
            continue;
        /* now both neighbours of the previous row are known */
        const REAL *own_active = given->active + (i - 1) * nx;
        REAL *passed = given->passed + (i - 1) * nx;
        NAME(around)(gaps + (i + 2) % 3 * nx, gaps + i % 3 * nx, next, &given->weights, row, passed, nx);
        if ((i - 1) % given->fy == 0)
            memset(columns, 0, (size_t)nx * sizeof(REAL));
        VECTOR
        for (int64_t j = 0; j < nx; j++)
            columns[j] += own_active[j] == 0 ? passed[j] : (REAL)0;
        if (i % given->fy == 0 || i == ny)
            NAME(fold)(columns, nx, given->fx, 1, given->coarse + (i - 1) / given->fy * cells);
    }
}

PASS(spread, { REAL *field; const REAL *gain, *coarse; int64_t ny, nx, fy, fx; })
{
    const int64_t cells = NAME(cells_of)(given->nx, given->fx);
    const REAL share = (REAL)1 / (REAL)(given->fy * given->fx);
    REAL *row = scratch;
    for (int64_t block = first; block < last; block++) {
        NAME(unfold)(given->coarse + block * cells, given->nx, given->fx, share, row);
        for (int64_t i = block * given->fy; i < SMALLER((block + 1) * given->fy, given->ny); i++) {
            REAL *field = given->field + i * given->nx;
            const REAL *gain = given->gain + i * given->nx;
            VECTOR
            for (int64_t j = 0; j < given->nx; j++)
                field[j] = gain[j] * (field[j] + row[j]);
        }
    }
}

PASS(finish_restriction, { REAL *field; const REAL *passed, *coarse, *active; int64_t ny, nx, fy, fx; })
{
    const int64_t cells = NAME(cells_of)(given->nx, given->fx);
    const REAL share = (REAL)1 / (REAL)(given->fy * given->fx);
    REAL *row = scratch;
    double total = 0;
    for (int64_t block = first; block < last; block++) {
        NAME(unfold)(given->coarse + block * cells, given->nx, given->fx, share, row);
        for (int64_t i = block * given->fy; i < SMALLER((block + 1) * given->fy, given->ny); i++) {
            REAL *field = given->field + i * given->nx;
            const REAL *passed = given->passed + i * given->nx, *active = given->active + i * given->nx;
            SUM(total)
            for (int64_t j = 0; j < given->nx; j++) {
                const REAL value = field[j] + (passed[j] + row[j]);
                const REAL kept = active[j] == 0 ? (REAL)0 : value;
                field[j] = kept;
                total += kept;
            }
        }
    }
    found->sums[0] = total;
}

/* ---- the small grids of a hierarchy, all in one pass ---- */

/* Fields of `count` grids, one grid after another; `table`: ny, nx, fy, fx, start and arrangement of each. `whole`:
   whether the first of them is the first of the hierarchy, which weighs its cells by the share of contact and is given
   means without their gain. */
struct NAME(Small) {
    REAL *empty, *gain, *means, *work;
    const int64_t *table;
    const REAL *weights;
    int64_t count, whole;
};

/* One of them. */
struct NAME(Grid) {
    int64_t ny, nx, fy, fx, cells, arrangement;
    REAL *empty, *gain, *means, *work;
    struct Weights weights;
};

static struct NAME(Grid) NAME(grid)(const struct NAME(Small) *small, int64_t number)
{
    const int64_t *row = small->table + 6 * number, start = row[4];
    const REAL *weights = small->weights + 3 * number;
    return (struct NAME(Grid)){row[0], row[1], row[2], row[3], row[0] * row[1], row[5],
                               small->empty + start, small->gain + start, small->means + start, small->work + start,
                               {weights[0], weights[1], weights[2]}};
}

/* Return the sum of `field` over the sum of the weights, 1 - `empty`. */
static REAL NAME(mean_over_contact)(const REAL *field, const REAL *empty, int64_t cells)
{
    REAL total = 0, weight = 0;
    for (int64_t j = 0; j < cells; j++) {
        total += field[j];
        weight += 1 - empty[j];
    }
    return weight > 0 ? total / weight : 0;
}

PASS(weigh_small, { struct NAME(Small) small; })
{
    (void)first, (void)last;
    for (int64_t number = 0; number < given->small.count; number++) {
        const struct NAME(Grid) grid = NAME(grid)(&given->small, number);
        const REAL *parts = number || !given->small.whole ? grid.empty : grid.work;
        struct NAME(weigh) weigh = {parts, grid.work, grid.empty, grid.gain, NULL, NULL,
                                    grid.ny, grid.nx, grid.fy * grid.fx, grid.arrangement, 1, 1};
        if (number + 1 < given->small.count) {
            const struct NAME(Grid) coarse = NAME(grid)(&given->small, number + 1);
            weigh.next_parts = coarse.empty;
            weigh.next_share = coarse.work;
            weigh.fy = coarse.fy;
            weigh.fx = coarse.fx;
        }
        NAME(work_weigh)(&weigh, 0, (grid.ny + weigh.fy - 1) / weigh.fy, scratch, found);
    }
}

PASS(prolong_small, { REAL *one, *other; struct NAME(Small) small; int64_t sweeps; })
{
    (void)first, (void)last;
    const int64_t coarsest = given->small.count - 1;
    for (int64_t number = 0; number <= coarsest; number++) {
        const struct NAME(Grid) grid = NAME(grid)(&given->small, number);
        VECTOR
        for (int64_t j = 0; j < (number || given->small.whole ? grid.cells : 0); j++)
            grid.means[j] *= grid.gain[j];
        if (number == coarsest)
            break;
        const struct NAME(Grid) coarse = NAME(grid)(&given->small, number + 1);
        const struct NAME(block_mean) mean = {grid.means, coarse.means, grid.ny, grid.nx, coarse.fy, coarse.fx};
        NAME(work_block_mean)(&mean, 0, coarse.ny, scratch, found);
    }
    for (int64_t number = coarsest; number >= 0; number--) {
        const struct NAME(Grid) grid = NAME(grid)(&given->small, number);
        REAL *mixed = grid.work;
        if (number == coarsest) {
            const REAL far = NAME(mean_over_contact)(grid.means, grid.empty, grid.cells);
            for (int64_t j = 0; j < grid.cells; j++)
                mixed[j] = grid.means[j] + grid.empty[j] * far;
            for (int64_t sweep = 1; sweep < given->sweeps; sweep++) {
                REAL *swept = sweep % 2 ? given->one : given->other;
                const struct NAME(fill) fill = {grid.means, grid.empty, mixed, swept,
                                                grid.weights, grid.ny, grid.nx};
                NAME(work_fill)(&fill, 0, grid.ny, scratch, found);
                mixed = swept;
            }
        } else {
            const struct NAME(Grid) coarse = NAME(grid)(&given->small, number + 1);
            const struct NAME(mix) mix = {grid.means, grid.empty, coarse.means, mixed,
                                          grid.ny, grid.nx, coarse.fy, coarse.fx};
            NAME(work_mix)(&mix, 0, coarse.ny, scratch, found);
        }
        const struct NAME(neighbours) neighbours = {mixed, grid.means, grid.weights, grid.ny, grid.nx};
        NAME(work_neighbours)(&neighbours, 0, grid.ny, scratch, found);
    }
}

PASS(restrict_small, { REAL *one, *other; struct NAME(Small) small; int64_t sweeps; })
{
    (void)first, (void)last;
    const int64_t coarsest = given->small.count - 1;
    for (int64_t number = 0; number <= coarsest; number++) {
        const struct NAME(Grid) grid = NAME(grid)(&given->small, number);
        const struct NAME(neighbours) neighbours = {grid.means, grid.work, grid.weights, grid.ny, grid.nx};
        NAME(work_neighbours)(&neighbours, 0, grid.ny, scratch, found);
        if (number < coarsest) {
            const struct NAME(Grid) coarse = NAME(grid)(&given->small, number + 1);
            const struct NAME(gather) gather = {grid.work, grid.empty, coarse.means, grid.ny, grid.nx, coarse.fy, coarse.fx};
            NAME(work_gather)(&gather, 0, coarse.ny, scratch, found);
            continue;
        }
        REAL *passed = given->one;
        memcpy(passed, grid.work, (size_t)grid.cells * sizeof(REAL));
        for (int64_t sweep = 1; sweep < given->sweeps; sweep++) {
            REAL *swept = sweep % 2 ? given->other : given->one;
            const struct NAME(empty_neighbours) again = {passed, grid.empty, swept, grid.weights, grid.ny, grid.nx};
            NAME(work_empty_neighbours)(&again, 0, grid.ny, scratch, found);
            for (int64_t j = 0; j < grid.cells; j++)
                grid.work[j] += swept[j];
            passed = swept;
        }
        for (int64_t j = 0; j < grid.cells; j++)
            passed[j] *= grid.empty[j];
        const REAL far = NAME(mean_over_contact)(passed, grid.empty, grid.cells);
        for (int64_t j = 0; j < grid.cells; j++)
            grid.work[j] = (grid.work[j] + far) * grid.gain[j];
    }
    for (int64_t number = coarsest - 1; number >= 0; number--) {
        const struct NAME(Grid) grid = NAME(grid)(&given->small, number);
        const struct NAME(Grid) coarse = NAME(grid)(&given->small, number + 1);
        const struct NAME(spread) spread = {grid.work, grid.gain, coarse.work, grid.ny, grid.nx, coarse.fy, coarse.fx};
        NAME(work_spread)(&spread, 0, coarse.ny, scratch, found);
    }
}

/* ---- prolongation of a pressure to a finer grid ---- */

PASS(continue_square, { const REAL *coarse; REAL *square; int64_t ny, nx; })
{
    const int64_t ny = given->ny, nx = given->nx, width = nx + 4; /* two columns beyond each end */
    REAL *rows = scratch, *total = rows + 5 * width, *count = total + nx;
    for (int64_t i = first; i < last; i++) {
        REAL *square = given->square + i * nx;
        const REAL *own = rows + 2 * width + 2;
        for (int64_t e = -2; e <= 2; e++) {
            const REAL *from = given->coarse + wrap(i + e, ny) * nx;
            REAL *row = rows + (e + 2) * width;
            memcpy(row + 2, from, (size_t)nx * sizeof(REAL));
            for (int64_t k = 0; k < 2; k++) {
                row[k] = from[wrap(k - 2, nx)];
                row[nx + 2 + k] = from[wrap(nx + k, nx)];
            }
        }
        memset(total, 0, (size_t)(2 * nx) * sizeof(REAL));
        for (int64_t ey = -1; ey <= 1; ey++)
            for (int64_t ex = -1; ex <= 1; ex++) {
                const REAL *near = own + ey * width + ex, *far = own + 2 * (ey * width + ex);
                VECTOR
                for (int64_t j = 0; j < nx; j++) { /* the cell itself is not near where its count matters */
                    const REAL one = near[j] * near[j], two = far[j] * far[j];
                    const REAL guess = far[j] > 0 ? 2 * one - two : -one;
                    total[j] += near[j] > 0 ? guess : 0;
                    count[j] += near[j] > 0 ? (REAL)1 : 0;
                }
            }
        VECTOR
        for (int64_t j = 0; j < nx; j++) {
            const REAL beyond = SMALLER(total[j], 0) / LARGER(count[j], 1);
            square[j] = own[j] > 0 ? own[j] * own[j] : beyond;
        }
    }
}

/* Limit the `count` parts of a cell, `stride` apart, to the cap; the other parts carry the remaining `load`. */
static void NAME(hold)(REAL *parts, int64_t count, int64_t stride, REAL load, REAL cap)
{
    for (int64_t beyond = 1; beyond > 0;) {
        REAL rest = load, others = 0;
        int64_t below = 0;
        for (int64_t k = 0; k < count * stride; k += stride)
            if (parts[k] < cap) {
                others += parts[k];
                below++;
            } else {
                parts[k] = cap;
                rest -= cap;
            }
        beyond = 0;
        for (int64_t k = 0; k < count * stride; k += stride)
            if (parts[k] < cap) {
                parts[k] = others > 0 ? parts[k] * (LARGER(rest, 0) / others) : LARGER(rest, 0) / (REAL)below;
                beyond += parts[k] > cap;
            }
    }
}

PASS(refine, {
    const REAL *coarse, *square, *heights;
    REAL *out;
    struct Weights weights;
    double stiffness, cap;
    int64_t ny, nx, fy, fx;
})
{
    const int64_t ny = given->ny, nx = given->nx, fy = given->fy, fx = given->fx, width = nx * fx, rows = ny * fy;
    const int64_t count = fy * fx, most = SMALLER(nx, 128); /* cells at a time, a few of whose parts fit the cache */
    const REAL stiffness = (REAL)given->stiffness, cap = (REAL)given->cap;
    REAL *detail = scratch, *row = detail + fy * width, *parts = row + width + 2, *mixed = parts + count * most;
    REAL *total = mixed + most + 2, *above = total + most, *level = above + most;
    memset(given->out + first * fy * width, 0, (size_t)((last - first) * fy * width) * sizeof(REAL));
    for (int64_t i = first; i < last; i++) {
        const REAL *own = given->square + i * nx;
        for (int64_t ky = 0; ky < fy; ky++) {
            const int64_t at = i * fy + ky;
            const REAL *here = given->heights + at * width;
            REAL *above_mean = detail + ky * width;
            NAME(around)(given->heights + before(at, rows) * width, here, given->heights + after(at, rows) * width,
                         &given->weights, row, above_mean, width);
            VECTOR
            for (int64_t j = 0; j < width; j++)
                above_mean[j] = stiffness * (here[j] - above_mean[j]);
        }
        for (int64_t start = 0; start < nx; start += most) {
            const int64_t cells = SMALLER(most, nx - start);
            const REAL *pressure = given->coarse + i * nx + start;
            int32_t touched = 0;
            SUM(touched)
            for (int64_t j = 0; j < cells; j++)
                touched += pressure[j] > 0;
            if (!touched)
                continue;
            memset(total, 0, (size_t)cells * sizeof(REAL));
            for (int64_t ky = 0; ky < fy; ky++) {
                const REAL at_y = ((REAL)ky + (REAL)0.5) / (REAL)fy - (REAL)0.5, share_y = at_y > 0 ? at_y : -at_y;
                const REAL *beside = given->square + (at_y > 0 ? after(i, ny) : before(i, ny)) * nx;
                for (int64_t j = 0; j < cells + 2; j += cells + 1) {
                    const int64_t at = wrap(start + j - 1, nx);
                    mixed[j] = (1 - share_y) * own[at] + share_y * beside[at];
                }
                VECTOR
                for (int64_t j = 0; j < cells; j++)
                    mixed[j + 1] = (1 - share_y) * own[start + j] + share_y * beside[start + j];
                for (int64_t kx = 0; kx < fx; kx++) {
                    const REAL at_x = ((REAL)kx + (REAL)0.5) / (REAL)fx - (REAL)0.5, share_x = at_x > 0 ? at_x : -at_x;
                    const REAL *next = mixed + (at_x > 0 ? 2 : 0);
                    REAL *part = parts + (ky * fx + kx) * most;
                    VECTOR
                    for (int64_t j = 0; j < cells; j++) {
                        const REAL value = (1 - share_x) * mixed[j + 1] + share_x * next[j];
                        part[j] = ROOT(LARGER(value, 0));
                        total[j] += part[j];
                    }
                }
            }
            for (int64_t k = 0; k < count; k++) {
                const REAL *above_mean = detail + k / fx * width + start * fx + k % fx;
                REAL *part = parts + k * most;
                VECTOR
                for (int64_t j = 0; j < cells; j++)
                    part[j] = part[j] * ((REAL)count * pressure[j] / (total[j] > 0 ? total[j] : 1)) + above_mean[j * fx];
            }
            /* subtract a level from the parts of every cell and clip them at zero, such that its load remains */
            for (int64_t j = 0; j < cells; j++)
                level[j] = -INFINITY;
            for (int64_t round = 0; round < count; round++) { /* each excludes the lowest parts */
                memset(total, 0, (size_t)cells * sizeof(REAL));
                memset(above, 0, (size_t)cells * sizeof(REAL));
                for (int64_t k = 0; k < count; k++) {
                    const REAL *part = parts + k * most;
                    VECTOR
                    for (int64_t j = 0; j < cells; j++) {
                        total[j] += part[j] > level[j] ? part[j] : 0;
                        above[j] += part[j] > level[j] ? (REAL)1 : 0;
                    }
                }
                int32_t changed = 0;
                SUM(changed)
                for (int64_t j = 0; j < cells; j++) {
                    const REAL found = (total[j] - (REAL)count * pressure[j]) / LARGER(above[j], 1);
                    const REAL raised = above[j] > 0 ? found : level[j];
                    changed += raised != level[j];
                    level[j] = raised;
                }
                if (!changed)
                    break;
            }
            memset(total, 0, (size_t)cells * sizeof(REAL));
            for (int64_t k = 0; k < count; k++) {
                REAL *part = parts + k * most;
                VECTOR
                for (int64_t j = 0; j < cells; j++) {
                    const REAL rest = part[j] - level[j];
                    part[j] = rest > (REAL)NEGLIGIBLE_LOAD * ((REAL)count * pressure[j]) ? rest : 0;
                    total[j] += part[j];
                }
            }
            for (int64_t k = 0; k < count; k++) {
                REAL *part = parts + k * most;
                VECTOR
                for (int64_t j = 0; j < cells; j++) { /* equal parts where rounding leaves no load */
                    const REAL scaled = part[j] * ((REAL)count * pressure[j] / (total[j] > 0 ? total[j] : 1));
                    part[j] = total[j] > 0 ? scaled : pressure[j];
                }
            }
            for (int64_t j = 0; cap < INFINITY && j < cells; j++) {
                NAME(hold)(parts + j, count, most, (REAL)count * pressure[j], cap);
                for (int64_t k = 0; pressure[j] >= cap && k < count; k++)
                    parts[k * most + j] = cap; /* exactly */
            }
            for (int64_t k = 0; k < count; k++) {
                const REAL *part = parts + k * most;
                REAL *out = given->out + (i * fy + k / fx) * width + start * fx + k % fx;
                VECTOR
                for (int64_t j = 0; j < cells; j++)
                    out[j * fx] = pressure[j] > 0 ? part[j] : 0;
            }
        }
    }
}

/* Sort two points of each of the medians that are computed at a time. */
static inline void NAME(sort)(REAL *lower, REAL *upper)
{
    VECTOR
    for (int64_t k = 0; k < MEDIANS; k++) {
        const REAL a = lower[k], b = upper[k];
        lower[k] = SMALLER(a, b);
        upper[k] = LARGER(b, a);
    }
}

/* The median of 5 x 5 points, from the inner points of the field to `out`: of more than half of them the smallest and the
   largest are not the median, and leave their place to the next point until three remain. */
PASS(medians, { const REAL *field; REAL *out; int64_t ny, nx; })
{
    const int64_t nx = given->nx, width = nx - 4;
    REAL points[25][MEDIANS];
    memset(points, 0, sizeof points);
    for (int64_t i = first; i < last; i++)
        for (int64_t start = 0; start < width; start += MEDIANS) {
            const int64_t medians = SMALLER(MEDIANS, width - start);
            for (int64_t k = 0; k < 25; k++)
                memcpy(points[k], given->field + (i + k / 5) * nx + start + k % 5, (size_t)medians * sizeof(REAL));
            for (int64_t count = 14; count > 2; count--) { /* points[0] to points[count - 1] are left */
                for (int64_t k = 0; k < count / 2; k++)
                    NAME(sort)(points[k], points[count - 1 - k]);
                for (int64_t k = 1; k < (count + 1) / 2; k++)
                    NAME(sort)(points[0], points[k]);
                for (int64_t k = count / 2; k < count - 1; k++)
                    NAME(sort)(points[k], points[count - 1]);
                if (count > 3)
                    memcpy(points[0], points[28 - count], sizeof points[0]);
            }
            memcpy(given->out + i * width + start, points[1], (size_t)medians * sizeof(REAL));
        }
}
