/* All passes for one kind of processor, LEVEL, in every precision that the solver uses: f is single, d double. */

#define NAME(pass) JOIN(pass, TYPES, LEVEL)
#define INNER_NAME(pass) JOIN(pass, LETTER, LEVEL)

#define TYPES f
#include "passes.h"
#include "transforms.h"
#define TYPES d
#include "passes.h"
#include "transforms.h"

#define TYPES ff
#define OUTER float
#define LETTER f
#include "mixed.h"
#define TYPES df
#define OUTER double
#define LETTER f
#include "mixed.h"
#define TYPES dd
#define OUTER double
#define LETTER d
#include "mixed.h"
#define TYPES fd
#define OUTER float
#define LETTER d
#include "mixed.h"

#define TYPES fff
#define STATE float
#define OUT float
#define LETTER f
#include "advance.h"
#define TYPES ffd
#define STATE float
#define OUT double
#define LETTER f
#include "advance.h"
#define TYPES dfd
#define STATE double
#define OUT double
#define LETTER f
#include "advance.h"
#define TYPES ddd
#define STATE double
#define OUT double
#define LETTER d
#include "advance.h"
#define TYPES fdd
#define STATE float
#define OUT double
#define LETTER d
#include "advance.h"

static const struct Entry JOIN(table, of, LEVEL)[] = {
#define ENTRY(pass, types) {#pass "_" #types, JOIN(run_##pass, types, LEVEL), sizeof(struct JOIN(pass, types, LEVEL))},
#define OF_ONE(pass) ENTRY(pass, f) ENTRY(pass, d)
#define OF_TWO(pass) ENTRY(pass, ff) ENTRY(pass, df) ENTRY(pass, dd) ENTRY(pass, fd)
    OF_ONE(multiply) OF_ONE(divide) OF_ONE(slope_power) OF_ONE(extent) OF_ONE(rescale) OF_ONE(restore_units)
    OF_ONE(inverse_root) OF_ONE(product) OF_ONE(block_mean) OF_ONE(weigh) OF_ONE(mix) OF_ONE(neighbours) OF_ONE(fill)
    OF_ONE(fill_from) OF_ONE(empty_neighbours) OF_ONE(gather) OF_ONE(empty_from) OF_ONE(spread)
    OF_ONE(finish_restriction) OF_ONE(weigh_small) OF_ONE(prolong_small) OF_ONE(restrict_small) OF_ONE(continue_square)
    OF_ONE(refine) OF_ONE(rows_forward) OF_ONE(rows_backward) OF_ONE(columns) OF_ONE(percolates) OF_ONE(medians)
    OF_TWO(make_dimensionless) OF_TWO(measure) OF_TWO(masked_residual) OF_TWO(predict_active)
    OF_TWO(redistribute) OF_TWO(project) OF_TWO(project_residual)
    ENTRY(advance, fff) ENTRY(advance, ffd) ENTRY(advance, fdd) ENTRY(advance, dfd) ENTRY(advance, ddd)
    {NULL, NULL, 0}
#undef OF_TWO
#undef OF_ONE
#undef ENTRY
};

#undef NAME
#undef INNER_NAME
#undef LEVEL
#undef LANE_BYTES
