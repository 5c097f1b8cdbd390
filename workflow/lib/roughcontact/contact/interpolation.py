"""Extend a residual from the contact set over the gaps between, and the transpose of doing so.

The operator restricted to the contact set C has an exact inverse: extend the residual over the rest of the
surface such that the elastic energy of the extension is least, apply G^-1 to that, and keep the values on C
(the Schur complement of G^-1). The extension of least energy decays from a contact as a displacement does,
neither at once nor never. It is imitated here from coarse to fine: on every grid of a pyramid an empty cell
takes the mean of its eight neighbours, weighted by the inverse cube of the distance, the decay of G^-1 in
space. A cell that is in contact in part counts by the linear size of its contact: the displacement beside an
isolated contact goes with its size over the distance, so that it reaches as far as it should. The mean over
the parts of a cell is weighted by those sizes, too, and far from all contact stands the mean over all of it.

With W for the extension, W^T G^-1 W is nowhere less than the exact inverse, and measured to be at most 1.15
times it for patches and scattered points on square pixels, three times it where pixels are far longer than
wide: that is why few iterations suffice.
"""

from dataclasses import dataclass
from functools import lru_cache
from itertools import pairwise

import numpy as np

from roughcontact.kernels.arrays import empty

# Ratio of the pitches above which the lines along the finer axis are taken as contacts of their own.
ELONGATED = 3.0
SMALLEST = 4  # cells along an axis below which the pyramid is not continued
SCATTERED = 32  # cells along an axis up to which they hold contacts far apart, as those of rough surfaces do
MOST_SWEEPS = 16  # on the coarsest grid, which is not small where the number of cells has large prime factors


@dataclass
class Level:
    """One coarser grid of the pyramid: `factors` from the next finer one, and fields of its cells.

    `scattered`: its cells are few and large, and hold contacts far apart from each other.
    `empty` is the share of a cell that counts as gap; the mean of what its parts weigh x `gain` is what the
    cell weighs.
    Where lines have become cells, `line_gain` makes the mean over a line that over its contact.
    `means` and `room` are to work in.
    """

    factors: tuple[int, int]
    scattered: bool
    weights: tuple[float, float, float]
    empty: np.ndarray
    gain: np.ndarray
    means: np.ndarray
    room: np.ndarray
    line_gain: np.ndarray | None


class Extension:
    """The linear map W from fields that are zero outside C to fields without gaps, on one grid.

    `like` has the shape (ny, nx) of the fields, `choose` says what C is. `kernels`:
    `roughcontact.kernels.array_api` or its compiled twin.
    """

    def __init__(self, like, precision: str, lengths: tuple[float, float], kernels):
        self.kernels, xp = kernels, like.__array_namespace__()
        self.chosen = None
        self.weights = stencil(pitches_of(like.shape, lengths), like.shape)
        plan = pyramid(like.shape, lengths)
        ends = np.cumsum([0, *(int(np.prod(shape)) for shape, _, _ in plan)]).tolist()
        # the grids lie one after the other, so that all the small ones can be handed over at once
        stores = [empty(like, precision, (ends[-1],)) for _ in range(4)]
        self.levels = [
            Level(
                factors,
                max(shape) <= SCATTERED,
                stencil(pitches_of(shape, lengths), shape),
                *(xp.reshape(store[start:end], shape) for store in stores),
                empty(like, precision, shape) if collapsed else None,
            )
            for (shape, factors, collapsed), (start, end) in zip(plan, pairwise(ends), strict=True)
        ]
        last = plan[-1][0] if plan else tuple(like.shape)
        self.sweeps = min(MOST_SWEEPS, max(last))
        self._last_rooms = [empty(like, precision, last) for _ in range(2)]
        collapses = lines_apart(plan)
        cells = [end - start for start, end in pairwise(ends)]
        # grids from here on are small: they are passed over in one call
        self._first_small = sum(n > kernels.TAIL for n in cells) if not collapses else len(plan)
        self._small = None
        if self._first_small < len(plan):
            self._small = kernels.pack(self.levels, stores, ends, self._first_small)

    def choose(self, chosen) -> None:
        """Let C be the points where the field `chosen`, which is kept, is not zero."""
        kernels, xp, self.chosen = self.kernels, chosen.__array_namespace__(), chosen
        if self.levels:
            finest = self.levels[0]
            kernels.chosen_share(chosen, finest.factors, finest.means)
            finest.room[...] = finest.means
        # the share of contact in every cell comes into `room`, the mean weight of its parts into `means`
        for number, level in enumerate(self.levels):
            if number == self._first_small:
                kernels.weigh_small(self._small)
                break
            after = self.levels[number + 1] if number + 1 < len(self.levels) else None
            if level.line_gain is not None:
                # every line that is in contact at all counts as one full cell
                touched = xp.astype(level.means > 0, level.means.dtype)
                level.line_gain[...] = touched / xp.where(touched > 0, level.means, xp.ones_like(touched))
                level.means[...], level.room[...], level.gain[...] = touched, touched, touched
                level.empty[...] = 1 - touched
            if after is not None:
                kernels.block_mean(level.room, after.factors, after.room)
            if level.line_gain is None:
                cells = level.means, level.room, level.factors, level.scattered
                kernels.weigh(*cells, level.empty, level.gain)
            if after is not None:
                kernels.block_mean(level.means, after.factors, after.means)

    def extend(self, values, out) -> None:
        """Put W values into `out`; both of shape (ny, nx)."""
        kernels = self.kernels
        if not self.levels:
            empty = self._empty()
            kernels.fill(values, empty, self._sweep(values, empty, self.weights), self.weights, out)
            return
        coarse = self.levels[0]
        kernels.weighted_mean(values, coarse.factors, coarse.gain, coarse.means)
        kernels.fill_from(values, self.chosen, self._filled(0), coarse.factors, self.weights, out)

    def _filled(self, number):
        """Return what the cells of a level, given their `means`, tell the next finer grid's empty cells."""
        kernels, level = self.kernels, self.levels[number]
        if number == self._first_small:
            kernels.fill_small(self._small, self.sweeps, *self._last_rooms)
            return level.means
        if level.line_gain is not None:
            level.means *= level.line_gain
        if number + 1 == len(self.levels):
            mixed = self._sweep(level.means, level.empty, level.weights)
        else:
            after, mixed = self.levels[number + 1], level.room
            kernels.weighted_mean(level.means, after.factors, after.gain, after.means)
            kernels.mix(level.means, level.empty, self._filled(number + 1), after.factors, mixed)
        if level.line_gain is not None:
            return mixed
        kernels.neighbours(mixed, level.weights, level.means)
        return level.means

    def _sweep(self, means, empty, weights):
        """Return the coarsest grid's mixed field, of which the neighbours' means are taken once more."""
        mixed = means + empty * _mean_over_contact(means, empty)
        for sweep in range(1, self.sweeps):
            self.kernels.fill(means, empty, mixed, weights, self._last_rooms[sweep % 2])
            mixed = self._last_rooms[sweep % 2]
        return mixed

    def transpose(self, field, scratch) -> float:
        """Put W^T field, zero outside C, into `field`; return its sum.

        `scratch`, like `field`, is overwritten.
        """
        returned, factors = self._returned_from(field, scratch)
        return self.kernels.conclude(field, scratch, returned, factors, self.chosen)

    def give(self, taken, pressure, cap: float, scratch) -> tuple[float, float]:
        """Add W^T `taken`, which is zero on C, to the `pressure`.

        Returns how much of that then lies outside of 0 and the `cap`, and the sum of what lies between.
        """
        returned, factors = self._returned_from(taken, scratch)
        return self.kernels.receive(pressure, scratch, returned, factors, self.chosen, cap)

    def _returned_from(self, field, scratch) -> tuple:
        """Put what neighbours give back into `scratch`; return what the coarser grid does, and factors."""
        kernels = self.kernels
        if not self.levels:
            empty = self._empty()
            kernels.empty_neighbours(field, empty, self.weights, scratch)
            self._sweep_back(scratch, empty, self.weights)
            return scratch[:1, :1] * 0, field.shape
        coarse = self.levels[0]
        kernels.empty_from(field, self.chosen, self.weights, scratch, coarse.factors, coarse.means)
        return self._returned(0), coarse.factors

    def _returned(self, number):
        """Return the transpose of `_filled`: from what the level's `means` hold to what its means get."""
        kernels, level = self.kernels, self.levels[number]
        if number == self._first_small:
            kernels.return_small(self._small, self.sweeps, *self._last_rooms)
            return level.room
        if level.line_gain is not None:
            level.room[...] = level.means
        else:
            kernels.neighbours(level.means, level.weights, level.room)
        if number + 1 == len(self.levels):
            self._sweep_back(level.room, level.empty, level.weights)
            level.room *= level.gain
        else:
            after = self.levels[number + 1]
            kernels.gather(level.room, level.empty, after.factors, after.means)
            kernels.spread(level.room, level.gain, self._returned(number + 1), after.factors)
        if level.line_gain is not None:
            level.room *= level.line_gain
        return level.room

    def _empty(self):
        """Return 1 outside C and 0 on it, where there is no coarser grid."""
        xp = self.chosen.__array_namespace__()
        return xp.astype(self.chosen == 0, self.chosen.dtype)

    def _sweep_back(self, total, empty, weights):
        """Add to `total` what the transposes of the sweeps make of it."""
        passed = self._last_rooms[0]
        passed[...] = total
        for sweep in range(1, self.sweeps):
            self.kernels.empty_neighbours(passed, empty, weights, self._last_rooms[sweep % 2])
            passed = self._last_rooms[sweep % 2]
            total += passed
        total += _mean_over_contact(empty * passed, empty)


def _mean_over_contact(field, empty) -> float:
    """Return the sum of `field` over that of the weights, which `empty` leaves of 1."""
    xp = field.__array_namespace__()
    weight = float(xp.sum(1 - empty))
    return float(xp.sum(field)) / weight if weight > 0 else 0.0


@lru_cache(maxsize=64)
def pyramid(shape, lengths) -> tuple[tuple[tuple[int, int], tuple[int, int], bool], ...]:
    """Return the grids coarser than `shape`: (shape, factors from the finer one, lines have become cells)."""
    plan, collapsed = [], False
    while True:
        pitches = pitches_of(shape, lengths)
        factors, collapses = coarsening(pitches, shape), False
        if factors == (1, 1) and not collapsed:
            factors = collapse(pitches, shape)
            collapsed = collapses = factors != (1, 1)
        if factors == (1, 1):
            return tuple(plan)
        shape = tuple(n // f for n, f in zip(shape, factors, strict=True))
        plan.append((shape, factors, collapses))


def lines_apart(plan) -> bool:
    """Return whether lines become cells in the `plan` of a pyramid: they are contacts of their own."""
    return any(collapsed for _, _, collapsed in plan)


def pitches_of(shape, lengths) -> tuple[float, ...]:
    """Return the pitches (dy, dx) of a grid."""
    return tuple(length / n for length, n in zip(lengths, shape, strict=True))


def coarsening(pitches, shape, *, smallest: int = SMALLEST) -> tuple[int, int]:
    """Return the factors (fy, fx) to the next coarser grid; (1, 1) on the coarsest.

    An axis is halved (or divided by 3 or 5 where it is odd) while it keeps at least `smallest` cells. One
    whose pitch is finer is coarsened alone, until the cells are about square.
    """
    finest = min(p for p, n in zip(pitches, shape, strict=True) if n > 1)
    factors = []
    for n, p in zip(shape, pitches, strict=True):
        divisor = next((f for f in (2, 3, 5) if n % f == 0 and n // f >= smallest), 1)
        factors.append(divisor if p <= 1.5 * finest else 1)
    return factors[0], factors[1]


def collapse(pitches, shape) -> tuple[int, int]:
    """Return the factors that make one cell of every line along the finer axis, or (1, 1).

    Where pixels are far longer than wide, a line whose whole length is short against the distance to the next
    is a contact of its own, coupled to the others by its load alone: a residual that is constant along it
    must stay constant across its gaps. So its one cell takes the mean over its contact.
    """
    (ny, nx), (dy, dx) = shape, pitches
    if min(shape) == 1 or max(pitches) <= ELONGATED * min(pitches):
        return 1, 1
    return (ny, 1) if dy < dx else (1, nx)


@lru_cache(maxsize=64)
def stencil(pitches, shape) -> tuple[float, float, float]:
    """Return the weights of a neighbour across y, across x, and diagonal; those of all eight sum to 1."""
    dy, dx = pitches
    weights = np.array([dy**-3.0, dx**-3.0, np.hypot(dy, dx) ** -3.0])
    weights *= [shape[0] > 1, shape[1] > 1, min(shape) > 1]
    weights /= 2 * weights[0] + 2 * weights[1] + 4 * weights[2]
    return tuple(float(weight) for weight in weights)
