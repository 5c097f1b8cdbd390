"""Navier's equations of a layered body under a pressure wave, solved directly with hundreds of digits.

Independent of `contact.elasticity.layers`: one linear system of all interfaces, the exponential of each
layer by its power series, the base by the condition that nothing grows with the depth.
"""

from decimal import Decimal, localcontext

import numpy as np

Matrix = list[list[Decimal]]


def random_layers(
    rng: np.random.Generator, fewest: int, most_layers: int
) -> list[tuple[float, float, float]]:
    """Return thickness, modulus and Poisson's ratio of so many layers, over three and four decades."""
    return [
        (
            float(10 ** rng.uniform(-2, 1)),
            float(10 ** rng.uniform(-2, 2)),
            float(rng.choice([0.0, 0.33, 0.5])),
        )
        for _ in range(rng.integers(fewest, most_layers + 1))
    ]


def system(youngs_modulus: float, poissons_ratio: float) -> Matrix:
    """Return A of y' = A y along the depth s = q z, y = (u, w, shear, normal traction); tractions over q.

    Displacements u sin(qx), w cos(qx); Hooke's law gives the first two rows, equilibrium the others.
    """
    e, nu = Decimal(youngs_modulus), Decimal(poissons_ratio)
    mu = e / (2 * (1 + nu))
    compressibility = (1 - 2 * nu) / (2 * mu * (1 - nu))  # 1/(lambda + 2 mu)
    lateral = nu / (1 - nu)  # lambda/(lambda + 2 mu)
    zero, unit_value = Decimal(0), Decimal(1)
    return [
        [zero, unit_value, 1 / mu, zero],
        [-lateral, zero, zero, compressibility],
        [2 * mu / (1 - nu), zero, zero, lateral],  # 4 mu (lambda + mu)/(lambda + 2 mu)
        [zero, zero, -unit_value, zero],
    ]


def times(a: Matrix, right: Matrix) -> Matrix:
    return [
        [sum(a * b for a, b in zip(row, column, strict=True)) for column in zip(*right, strict=True)]
        for row in a
    ]


def exponential(matrix: Matrix, x: Decimal) -> Matrix:
    """Return exp(matrix x): its power series for a part of x, squared again and again."""
    halvings = max(0, int(x).bit_length() + 4)
    part = [[a * x / 2**halvings for a in row] for row in matrix]
    identity = [[Decimal(int(i == j)) for j in range(4)] for i in range(4)]
    total, term, number = identity, identity, 0
    while any(abs(a) > Decimal(10) ** -(2000) for row in term for a in row) and number < 400:
        number += 1
        term = [[a / number for a in row] for row in times(term, part)]
        total = [[a + b for a, b in zip(*rows, strict=True)] for rows in zip(total, term, strict=True)]
    for _ in range(halvings):
        total = times(total, total)
    return total


def solve(matrix: Matrix, right: list[Decimal]) -> list[Decimal]:
    """Return the solution of a linear system by Gauss' elimination with pivoting."""
    rows = [[*row, value] for row, value in zip(matrix, right, strict=True)]
    size = len(rows)
    for i in range(size):
        pivot = max(range(i, size), key=lambda j: abs(rows[j][i]))
        rows[i], rows[pivot] = rows[pivot], rows[i]
        for j in range(i + 1, size):
            share = rows[j][i] / rows[i][i]
            rows[j] = [a - share * b for a, b in zip(rows[j], rows[i], strict=True)]
    solution = [Decimal(0)] * size
    for i in reversed(range(size)):
        remainder = sum(rows[i][j] * solution[j] for j in range(i + 1, size))
        solution[i] = (rows[i][size] - remainder) / rows[i][i]
    return solution


def states(
    q: float,
    layers: list[tuple[float, float, float]],
    base: tuple[float, float] | None,
    *,
    digits: int | None = None,
) -> list[list[float]]:
    """Return y at the surface and below each layer, under a unit pressure wave of wavenumber q.

    `layers` are (thickness, E, nu) from the surface inwards, `base` (E, nu), None for a rigid one.
    """
    depth = sum(q * layer[0] for layer in layers)
    with localcontext() as context:
        context.prec = digits or int(60 + depth)
        parts = [exponential(system(e, nu), Decimal(q) * Decimal(t)) for t, e, nu in layers]
        size = 4 * (len(parts) + 1)
        matrix = [[Decimal(0)] * size for _ in range(size)]
        right = [Decimal(0)] * size
        matrix[0][2] = matrix[1][3] = Decimal(1)  # no shear, and -1 of normal traction
        right[1] = -1 / Decimal(q)
        for number, part in enumerate(parts):
            for i in range(4):
                row = 2 + 4 * number + i
                for j in range(4):
                    matrix[row][4 * number + j] = part[i][j]
                matrix[row][4 * (number + 1) + i] = Decimal(-1)
        if base is None:
            matrix[-2][-4] = matrix[-1][-3] = Decimal(1)  # no displacement
        else:  # nothing grows: (A + 1)^2 y = 0, of which two rows are independent
            plus = [[a + int(i == j) for j, a in enumerate(row)] for i, row in enumerate(system(*base))]
            square = times(plus, plus)
            matrix[-2][-4:], matrix[-1][-4:] = square[0], square[1]
        solution = [float(value) for value in solve(matrix, right)]
    return [solution[start : start + 4] for start in range(0, size, 4)]


def surface_compliance(
    q: float, layers: list[tuple[float, float, float]], base: tuple[float, float] | None
) -> float:
    """Return S(q), the displacement of the surface per pressure."""
    return states(q, layers, base)[0][1]
