"""Extend values from the contact set to the whole grid, and the transpose of doing so.

The preconditioner G^-1 restricted to the contact set C sees a residual that is zero outside C. The exact
inverse sees the extension of least energy instead (it is the Schur complement of G^-1 on C). Where pixels are
much longer than wide the difference decides: rows are then almost independent problems, coupled by their
loads alone, and a residual that is constant along a row must stay constant across its gaps. So values are
pulled into the gaps from means over ever longer blocks along the finer axis ("push and pull"), and smoothed
once there.
"""

import numpy as np

from roughcontact.contact.levels import block_sum, prolong

ELONGATED = 3.0  # ratio of the pitches from which the extension pays


class Extension:
    """The linear map W from values on C, given as a field that is zero elsewhere, to a field without gaps.

    `lengths` = (Ly, Lx). `extend` applies W, `transpose` its transpose, whose values outside C mean nothing.
    """

    def __init__(self, active: np.ndarray, lengths: tuple[float, float]):
        self.levels = []
        count = active.astype(np.float32)
        while True:
            pitch_y, pitch_x = (length / n for length, n in zip(lengths, count.shape, strict=True))
            along_x = pitch_x <= pitch_y
            n = count.shape[1 if along_x else 0]
            factor = next((f for f in (2, 3, 5) if n % f == 0), 1)
            factors = (1, factor) if along_x else (factor, 1)
            empty = count == 0
            mean = np.where(empty, 0, 1 / np.where(empty, 1, count))
            self.levels.append((empty, mean, factors, 1 if along_x else 0))
            if factor == 1 or not empty.any():
                break
            count = block_sum(count, factors)

    def extend(self, values: np.ndarray) -> np.ndarray:
        """Return W values, shape (ny, nx)."""
        sums = [values]
        for _, _, factors, _ in self.levels[:-1]:
            sums.append(block_sum(sums[-1], factors))
        field = sums[-1] * self.levels[-1][1]
        for total, (empty, mean, factors, axis) in zip(sums[-2::-1], self.levels[-2::-1], strict=True):
            field = np.where(empty, prolong(field, factors), total * mean)
            field = np.where(empty, _neighbours(field, axis), field)
        return field

    def transpose(self, field: np.ndarray) -> np.ndarray:
        """Return W^T field, shape (ny, nx), right on C."""
        kept = []
        for empty, mean, factors, axis in self.levels[:-1]:
            field = np.where(empty, 0, field) + _neighbours(np.where(empty, field, 0), axis)
            kept.append(np.where(empty, 0, field) * mean)
            field = block_sum(np.where(empty, field, 0), factors)
        total = field * self.levels[-1][1]
        for own, (_, _, factors, _) in zip(kept[::-1], self.levels[-2::-1], strict=True):
            total = own + prolong(total, factors)
        return total


def _neighbours(field, axis):
    """Return the mean of the two neighbours along an axis, over the periodic boundary."""
    return (np.roll(field, 1, axis) + np.roll(field, -1, axis)) * field.dtype.type(0.5)
