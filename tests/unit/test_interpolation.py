"""The interpolation over the gaps, its transpose, and how near it comes to the inverse of the operator."""

from functools import partial

import numpy as np
import pytest
from known_surfaces import self_affine
from option_pairs import every_pair
from scipy.linalg import eigh

from roughcontact.contact.coarsening import halving_factors, hierarchy, stencil, whole_factors
from roughcontact.contact.elasticity.influence import Elasticity
from roughcontact.contact.elasticity.media import elastic_medium
from roughcontact.contact.elasticity.medium import HALF_SPACES
from roughcontact.contact.grid import Grid
from roughcontact.contact.interpolation import Interpolation
from roughcontact.kernels import array_api, compiled
from roughcontact.kernels.compiled import Compiled

# shape and pitches: square, odd, prime, pixels longer than wide (with and without lines that become one
# cell), profiles, two rows
GRIDS = [
    ((16, 16), (1.0, 1.0)),
    ((27, 45), (1.0, 1.0)),
    ((23, 31), (1.0, 1.0)),
    ((24, 40), (2.0, 1.0)),
    ((16, 24), (1.0, 30.0)),
    ((24, 16), (1000.0, 1.0)),
    ((11, 13), (1.0, 50.0)),
    ((1, 64), (1.0, 1.0)),
    ((37, 1), (1.0, 1.0)),
    ((2, 48), (1.0, 1.0)),
    ((30, 2), (1.0, 40.0)),
]
COLLAPSED = [
    ((16, 24), (1.0, 30.0)),
    ((24, 16), (1000.0, 1.0)),
    ((11, 13), (1.0, 50.0)),
    ((30, 2), (1.0, 40.0)),
]
SOFT, STIFF = ({"youngs_modulus": modulus, "poissons_ratio": 0.3} for modulus in (1.0, 100.0))
# two pixels thick: the finest grids bend
BODIES = {
    "half-space": HALF_SPACES,
    "film": elastic_medium([SOFT | {"layers": [STIFF | {"thickness": 2.0}]}]),
}
ENGINES = {"plain": array_api, "one thread": Compiled(1), "two threads": Compiled(2)}


def make(shape, pitches, contact, engine=array_api, dtype=float, medium=HALF_SPACES):
    """Return the interpolation P from the contact set `contact` (ny, nx) and P as a function."""
    lengths = tuple(n * d for n, d in zip(shape, pitches, strict=True))
    interpolation = Interpolation(np.empty(shape), np.dtype(dtype).name, lengths, engine, medium)
    interpolation.set_active(contact.astype(dtype))

    def prolong(values):
        out = np.full(shape, np.nan, dtype=dtype)
        interpolation.prolong(values, out)
        return out

    return interpolation, prolong


def scattered(shape, share, seed=0):
    """Return a contact set of single points, at least one of them."""
    contact = np.random.default_rng([seed, *shape]).random(shape) < share
    contact.flat[contact.size // 2] = True
    return contact


def patches(shape, share, *, shortest=8.0, seed=0):
    """Return the `share` highest points of a self-affine map, a contact set as surfaces make it."""
    height = self_affine(shape, 1.0, (shortest, min(shape) / 2), rms_gradient=1, seed=seed)
    return height.values > np.quantile(height.values, 1 - share)


@pytest.mark.parametrize(
    ("grid", "share", "engine", "dtype", "body"),
    every_pair(GRIDS, [0.05, 0.4, 0.9, 1.0], list(ENGINES), ["float32", "float64"], list(BODIES)),
    ids=str,
)
def test_the_transpose_is_the_transpose_and_the_contact_keeps_its_values(grid, share, engine, dtype, body):
    shape, pitches = grid
    rng = np.random.default_rng(1)
    contact = scattered(shape, share)
    interpolation, prolong = make(shape, pitches, contact, ENGINES[engine], dtype, BODIES[body])
    values = np.where(contact, rng.standard_normal(shape), 0).astype(dtype)
    field = rng.standard_normal(shape).astype(dtype)
    extended = prolong(values)
    np.testing.assert_array_equal(extended[contact], values[contact])
    transposed = field.copy()
    total = interpolation.restrict(transposed, np.full(shape, np.nan, dtype))
    assert not transposed[~contact].any()
    rounding = 16 * float(np.finfo(dtype).eps)
    scale = float(np.linalg.norm(extended) * np.linalg.norm(field))
    inner = np.vdot(extended.astype(float), field.astype(float))
    assert np.vdot(values.astype(float), transposed.astype(float)) == pytest.approx(
        inner, rel=0, abs=rounding * scale
    )
    assert total == pytest.approx(
        transposed.sum(dtype=float), rel=0, abs=rounding * float(np.abs(transposed).sum(dtype=float))
    )
    # what leaves the contact is handed on by the same transpose
    handed_on, projected = np.zeros(shape, dtype), np.where(contact, 0, field).astype(dtype)
    transposed = projected.copy()
    interpolation.restrict(transposed, np.full(shape, np.nan, dtype))
    interpolation.redistribute(projected, handed_on, np.inf, np.full(shape, np.nan, dtype))
    np.testing.assert_allclose(handed_on, transposed, rtol=0, atol=rounding * scale)


@pytest.mark.parametrize("body", BODIES)
@pytest.mark.parametrize(("shape", "pitches"), GRIDS)
def test_the_interpolation_is_linear_and_between_the_values(shape, pitches, body):
    rng = np.random.default_rng(2)
    contact = scattered(shape, 0.2)
    _, prolong = make(shape, pitches, contact, medium=BODIES[body])
    a, b = (np.where(contact, rng.standard_normal(shape), 0) for _ in range(2))
    np.testing.assert_allclose(prolong(2 * a - 3 * b), 2 * prolong(a) - 3 * prolong(b), rtol=0, atol=1e-13)
    # positive weights that sum to one; next to lines that do not touch, to less
    reach = prolong(contact.astype(float))
    assert reach.min() >= 0
    assert reach.max() <= 1 + 1e-14
    if (shape, pitches) not in COLLAPSED:
        assert reach.min() >= 1 - 1e-14


def test_the_weights_are_the_inverse_cube_of_the_distance():
    across_y, across_x, diagonal = stencil((2.0, 3.0), (8, 8))
    assert across_y / across_x == pytest.approx((3 / 2) ** 3)
    assert diagonal / across_x == pytest.approx(3**3 / 13**1.5)
    assert 2 * across_y + 2 * across_x + 4 * diagonal == pytest.approx(1)
    assert stencil((2.0, 3.0), (1, 8)) == pytest.approx((0, 0.5, 0))
    assert stencil((2.0, 3.0), (8, 1)) == pytest.approx((0.5, 0, 0))


def test_grids_of_the_hierarchy():
    any_of_three = partial(whole_factors, divisors=(2, 3, 5), smallest=4)
    assert any_of_three((1.0, 1.0), (12, 45)) == (2, 3)
    assert any_of_three((1.0, 1.0), (7, 25)) == (1, 5)  # 7 is prime
    assert any_of_three((1.0, 1.0), (6, 4)) == (1, 1)  # 3 cells would be too few
    assert any_of_three((2.0, 1.0), (64, 64)) == (1, 2)  # the finer axis alone
    assert any_of_three((1.0, 1.0), (1, 64)) == (1, 2)
    assert whole_factors((1.0, 1.0), (12, 64), divisors=(4, 2, 3), smallest=4) == (2, 4)
    assert halving_factors((1.0, 1.0), (12, 45)) == ((2, 2), False)
    assert halving_factors((1.0, 1.0), (1, 45)) == ((1, 2), False)
    assert halving_factors((2.0, 1.0), (64, 64)) == ((1, 2), False)
    assert halving_factors((1.0, 2.9), (4, 8)) == ((2, 1), False)
    assert halving_factors((1.0, 3.1), (5, 8)) == ((2, 1), False)  # the line is long yet
    assert halving_factors((1.0, 3.1), (4, 6)) == ((4, 1), True)
    assert halving_factors((3.1, 1.0), (8, 3)) == ((1, 3), True)
    assert halving_factors((3.1, 1.0), (1, 6)) == ((1, 2), False)

    def shapes(shape, lengths):
        return [grid.shape for grid in hierarchy(shape, lengths)]

    assert shapes((12, 24), (1.0, 2.0)) == [(6, 12), (3, 6), (2, 3)]
    assert shapes((7, 11), (7.0, 11.0)) == [(4, 6), (2, 3)]
    assert shapes((5, 40), (5.0, 40.0)) == [(3, 20), (2, 10), (1, 5), (1, 3)]
    lines = hierarchy((8, 6), (1.0, 24.0))
    assert [grid.shape for grid in lines] == [(4, 6), (1, 6), (1, 3)]
    assert [grid.collapses_lines for grid in lines] == [False, True, False]
    assert [grid.pitches for grid in lines] == [(0.25, 4.0), (1.0, 4.0), (1.0, 8.0)]
    assert hierarchy((4, 4), (1.0, 1.0)) == ()


def test_small_grids_in_one_call_equal_those_one_by_one(monkeypatch):
    """Where the compiled kernels take the coarser grids together: nowhere, below the first, everywhere."""
    rng = np.random.default_rng(5)
    contact = scattered((48, 80), 0.2)
    values, field = (
        np.where(contact, rng.standard_normal(contact.shape), 0),
        rng.standard_normal(contact.shape),
    )
    results = []
    for cells in (0, 12 * 20, 24 * 40):
        monkeypatch.setitem(compiled.SMALL_GRID, "one thread", cells)
        interpolation, prolong = make(contact.shape, (1.0, 1.0), contact, Compiled(1))
        back = field.copy()
        interpolation.restrict(back, np.empty_like(back))
        results.append((interpolation._small.first if interpolation._small else None, prolong(values), back))
    assert [first_small for first_small, _, _ in results] == [None, 1, 0]
    for _, prolonged, back in results[1:]:
        np.testing.assert_allclose(prolonged, results[0][1], rtol=0, atol=1e-14)
        np.testing.assert_allclose(back, results[0][2], rtol=0, atol=1e-13)


@pytest.mark.parametrize(("shape", "pitches"), COLLAPSED)
def test_what_is_constant_along_lines_stays_so(shape, pitches):
    rng = np.random.default_rng(3)
    contact = scattered(shape, 0.3)
    finer = int(np.argmin(pitches))
    contact.swapaxes(finer, 0)[0] = True  # every line touches
    interpolation, prolong = make(shape, pitches, contact)
    last = [grid.line_gain is not None for grid in interpolation.grids].index(True)
    lines = np.broadcast_to(np.expand_dims(rng.uniform(-1, 1, shape[1 - finer]), finer), shape)
    # all that lines take from each other are the neighbours' weights across, grid by grid of the hierarchy
    weights = [interpolation.weights, *(grid.weights for grid in interpolation.grids[:last])]
    rounding = sum(2 * weight[1 - finer] + 4 * weight[2] for weight in weights)
    values = prolong(np.where(contact, lines, 0))
    assert rounding < 0.2
    np.testing.assert_allclose(values, lines, rtol=0, atol=2 * rounding)


def in_dense_form(grid, contact):
    """Return the matrices of G and of M = P^T G^-1 P on the pressures of mean zero on `contact`."""
    unit = np.zeros((contact.sum(), *contact.shape))
    unit[:, contact] = np.eye(len(unit))
    operator = np.array([grid.halfspace.displacement(field)[contact] for field in unit])
    inverse = np.array([grid.precondition_on(contact, field)[contact] for field in unit])
    np.testing.assert_allclose(inverse, inverse.T, rtol=0, atol=1e-12 * np.abs(inverse).max())
    basis = np.linalg.svd(np.ones((1, len(unit))))[2][1:]
    return basis @ operator @ basis.T, basis @ inverse @ basis.T


@pytest.mark.parametrize(
    ("shape", "pitches", "share"),
    # larger dense matrices would take most of the time of this file: threads of BLAS wait for one another
    [(*grid, share) for grid in GRIDS for share in (0.05, 0.3, 0.8) if share * np.prod(grid[0]) < 160],
)
def test_nowhere_less_than_the_inverse_on_small_grids(shape, pitches, share):
    """All eigenvalues of P^T G^-1 P C G C, by dense matrices."""
    contact = scattered(shape, share)
    contact.flat[0] = True
    grid = Grid(np.zeros(shape), tuple(n * d for n, d in zip(shape, pitches, strict=True)))
    operator, inverse = in_dense_form(grid, contact)
    values = eigh(inverse, np.linalg.inv(operator), eigvals_only=True)
    assert values[0] >= 1 - 1e-10
    elongated = max(pitches) > 3 * min(pitches)
    assert values[-1] <= (3.0 if elongated else 1.4)


def extreme_eigenvalues(grid, contact, *, dtype=float, steps=40):
    """Return the least and the largest eigenvalue of P^T G^-1 P C G C on the pressures of mean zero.

    The coefficients of preconditioned conjugate gradients make a tridiagonal matrix whose extreme
    eigenvalues are soon those of the product (Golub and Van Loan 2013, Matrix Computations, section 11.3).
    """

    def centred(field):
        return np.where(contact, field - field[contact].mean(dtype=float).astype(field.dtype), 0)

    residual = centred(np.random.default_rng(4).standard_normal(contact.shape).astype(dtype))
    product = centred(grid.precondition_on(contact, residual))
    direction, rz = product, np.vdot(residual, product)
    initial_rz, lengths, ratios = rz, [], []
    while len(lengths) < steps and rz > 1e3 * np.finfo(dtype).eps ** 2 * initial_rz:
        displaced = centred(grid.halfspace.displacement(direction))
        lengths.append(float(rz / np.vdot(direction, displaced)))
        residual = residual - dtype(lengths[-1]) * displaced
        product = centred(grid.precondition_on(contact, residual))
        previous_rz, rz = rz, np.vdot(residual, product)
        ratios.append(float(rz / previous_rz))
        direction = product + rz / previous_rz * direction
    lengths, ratios = np.array(lengths), np.array(ratios)[:-1]
    diagonal = 1 / lengths + np.concatenate([[0], ratios / lengths[:-1]])
    off_diagonal = np.sqrt(ratios) / lengths[:-1]
    values = np.linalg.eigvalsh(np.diag(diagonal) + np.diag(off_diagonal, 1) + np.diag(off_diagonal, -1))
    return values[0], values[-1]


def test_the_measure_of_eigenvalues_agrees_with_the_dense_one():
    shape = (20, 25)
    grid, contact = Grid(np.zeros(shape), (1.0, 1.25)), scattered(shape, 0.2)
    operator, inverse = in_dense_form(grid, contact)
    dense = eigh(inverse, np.linalg.inv(operator), eigvals_only=True)
    low, high = extreme_eigenvalues(grid, contact)
    # from within; those that lie close together are not told apart
    assert dense[-1] - 1e-3 <= high <= dense[-1] + 1e-12
    assert dense[0] - 1e-12 <= low <= dense[0] + 2e-3


@pytest.mark.parametrize("share", [0.003, 0.03, 0.1, 0.3, 0.5, 0.8, 0.97])
@pytest.mark.parametrize(
    ("make_contact", "largest"), [(patches, 1.1), (scattered, 1.1)], ids=["patches", "single points"]
)
def test_hardly_more_than_the_inverse(make_contact, largest, share):
    shape = (128, 128)
    low, high = extreme_eigenvalues(Grid(np.zeros(shape), (1.0, 1.0)), make_contact(shape, share))
    assert low >= 1 - 1e-10
    assert high <= largest


@pytest.mark.parametrize("share", [0.03, 0.1, 0.3])
def test_a_film_that_bends_doubles_the_inverse_at_most(share):
    """Without the sweeps over the cells that bend the ratio is 3.5 to 3.9."""
    shape = (128, 128)
    grid = Grid(np.zeros(shape), (128.0, 128.0), Elasticity(medium=BODIES["film"]))
    low, high = extreme_eigenvalues(grid, patches(shape, share))
    assert low >= 1 - 1e-10
    assert high <= 2.1


@pytest.mark.parametrize("share", [0.02, 0.3, 0.8])
@pytest.mark.parametrize("size", [64, 125, 211, 256, 512])
def test_patches_need_no_more_steps_on_finer_grids(size, share):
    """With pixels ever finer beside the patches the largest eigenvalue stays, for primes, too."""
    shape = (size, size)
    contact = patches(shape, share, shortest=size / 16)
    _, high = extreme_eigenvalues(Grid(np.zeros(shape), (1.0, 1.0)), contact, steps=20)
    assert high <= 1.15


def test_single_precision_keeps_the_bounds():
    shape = (128, 128)
    contact = patches(shape, 0.1)
    low, high = extreme_eigenvalues(Grid(np.zeros(shape), (1.0, 1.0)), contact, dtype=np.float32)
    assert low >= 1 - 1e-5
    assert high <= 1.4


@pytest.mark.parametrize(("share", "largest"), [(0.01, 1.6), (0.1, 1.6), (0.5, 1.6)])
def test_hardly_more_than_the_inverse_under_a_profile(share, largest):
    shape = (1, 4096)
    low, high = extreme_eigenvalues(Grid(np.zeros(shape), (1.0, 4096.0)), scattered(shape, share))
    assert low >= 1 - 1e-10
    assert high <= largest
