"""Extend a residual from the contact set over the gaps between, and the transpose of doing so.

The operator restricted to the contact set C has an exact inverse: extend the residual over the rest of the
surface such that the elastic energy of the extension is least, apply G^-1 to that, and keep the values on C
(the Schur complement of G^-1). The extension of least energy decays from a contact as a displacement does,
neither at once nor never. It is imitated here from coarse to fine: on every grid of a pyramid an empty cell
takes the mean of its eight neighbours, weighted by the inverse cube of the distance, the decay of G^-1 in
space. A cell that is in contact in part counts by the root of that share, a linear size: the displacement
beside an isolated contact goes with its size over the distance, so that it reaches as far as it should.

With W for the extension, W^T G^-1 W is nowhere less than the exact inverse, and measured to be at most 1.2
times it for patches and scattered points on square pixels, three times it where pixels are far longer than
wide: that is why few iterations suffice.
"""

import numpy as np

# Ratio of the pitches above which the lines along the finer axis are taken as contacts of their own.
ELONGATED = 3.0
SMALLEST = 4  # cells along an axis below which the pyramid is not continued
MOST_SWEEPS = 16  # on the coarsest grid, which is not small where the number of cells has large prime factors


class Extension:
    """The linear map W from fields that are zero outside C to fields without gaps, on one grid.

    `kernels`: `roughcontact.kernels` or its compiled twin. Grid by grid of the pyramid, finest first,
    it holds the empty share of every cell, which `complete` brings up to date when C changes, and room to
    work in.
    """

    def __init__(self, like, lengths: tuple[float, float], kernels):
        self.kernels = kernels
        self.empty, self.weights, self.factors, self.rooms = [], [], [], []
        self.collapsed = None  # the grid, if any, on which every line along the finer axis is one cell
        xp, shape = like.__array_namespace__(), like.shape
        while True:
            pitches = [length / n for length, n in zip(lengths, shape, strict=True)]
            self.weights.append(stencil(pitches, shape))
            self.empty.append(xp.empty(shape, dtype=like.dtype))
            self.rooms.append([xp.empty(shape, dtype=like.dtype) for _ in range(2 if self.factors else 1)])
            factors = coarsening(pitches, shape)
            if factors == (1, 1) and self.collapsed is None:
                factors = collapse(pitches, shape)
                self.collapsed = len(self.empty) if factors != (1, 1) else None
            if factors == (1, 1):
                break
            self.factors.append(factors)
            shape = tuple(n // f for n, f in zip(shape, factors, strict=True))
        self.sweeps = min(MOST_SWEEPS, max(shape))
        self._gain = [None] * len(self.empty)
        self.last_rooms = [xp.empty(shape, dtype=like.dtype) for _ in range(2)]

    def complete(self) -> None:
        """Bring the empty shares of the coarser grids up to date with `empty[0]`, 1 outside C and 0 on it."""
        xp, share = self.empty[0].__array_namespace__(), None
        for level, factors in enumerate(self.factors, start=1):
            means = self.rooms[level][0]
            self.kernels.block_mean(self.empty[0] if share is None else share, factors, means)
            share = 1 - means if share is None else means  # of contact, in every cell
            touched = share > 0
            # every line of a collapsed grid that is in contact at all counts as one full cell
            weight = xp.astype(touched, share.dtype) if level == self.collapsed else xp.sqrt(share)
            self.empty[level][...] = 1 - weight
            self._gain[level] = weight / xp.where(touched, share, xp.ones_like(share))
            share = weight if level == self.collapsed else share

    def extend(self, values, out) -> None:
        """Put W values into `out`; both of shape (ny, nx)."""
        kernels, rooms = self.kernels, self.rooms
        means = [values]
        for level, factors in enumerate(self.factors, start=1):
            kernels.block_mean(means[-1], factors, rooms[level][0])
            if level == self.collapsed:
                rooms[level][0] *= self._gain[level]
            means.append(rooms[level][0])
        for level in range(1, len(means)):
            if level != self.collapsed:
                means[level] *= self._gain[level]
        mixed = self._sweep(means[-1])
        for level in range(len(self.factors), 0, -1):
            filled = rooms[level][1]
            if level == self.collapsed:
                filled[...] = mixed
            else:
                kernels.neighbours(mixed, self.weights[level], filled)
            mixed = rooms[level - 1][0]  # the room of the means, which are needed no more
            kernels.mix(means[level - 1], self.empty[level - 1], filled, self.factors[level - 1], mixed)
        kernels.fill(values, self.empty[0], mixed, self.weights[0], out)

    def _sweep(self, means):
        """Return the coarsest grid's mixed field, of which the neighbours' means are taken once more."""
        mixed, other = means, self.last_rooms
        for sweep in range(1, self.sweeps):
            self.kernels.fill(means, self.empty[-1], mixed, self.weights[-1], other[sweep % 2])
            mixed = other[sweep % 2]
        return mixed

    def transpose(self, field, values) -> tuple[float, float]:
        """Put W^T field, zero outside C, into `field`; return its sum and that of field x `values`."""
        kernels, rooms, last = self.kernels, self.rooms, len(self.factors)
        kernels.empty_neighbours(field, self.empty[0], self.weights[0], rooms[0][0])
        for level, factors in enumerate(self.factors, start=1):
            kernels.gather(rooms[level - 1][0], self.empty[level - 1], factors, rooms[level][1])
            if level == self.collapsed:
                rooms[level][0][...] = rooms[level][1]
            else:
                kernels.neighbours(rooms[level][1], self.weights[level], rooms[level][0])
        passed, other = rooms[last][0], self.last_rooms
        for sweep in range(1, self.sweeps):
            kernels.empty_neighbours(passed, self.empty[-1], self.weights[-1], other[sweep % 2])
            passed = other[sweep % 2]
            rooms[last][0] += passed
        for level in range(1, last + 1):
            if level != self.collapsed:
                rooms[level][0] *= self._gain[level]
        for level in range(last, 0, -1):
            if level == self.collapsed:
                rooms[level][0] *= self._gain[level]
            fy, fx = self.factors[level - 1]
            kernels.spread(rooms[level - 1][0], rooms[level][0], (fy, fx), 1 / (fy * fx))
        return kernels.conclude(field, rooms[0][0], values, self.empty[0])


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


def stencil(pitches, shape) -> tuple[float, float, float]:
    """Return the weights of a neighbour across y, across x, and diagonal; those of all eight sum to 1."""
    dy, dx = pitches
    weights = np.array([dy**-3.0, dx**-3.0, np.hypot(dy, dx) ** -3.0])
    weights *= [shape[0] > 1, shape[1] > 1, min(shape) > 1]
    weights /= 2 * weights[0] + 2 * weights[1] + 4 * weights[2]
    return tuple(float(weight) for weight in weights)
