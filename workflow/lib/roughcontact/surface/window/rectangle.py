"""The largest rectangle of a map without missing points."""

import numpy as np


def largest_rectangle(good: np.ndarray, sides: np.ndarray) -> tuple[int, int, int, int]:
    """Return row, column, height and width (points) of the good rectangle that holds the largest window.

    `sides[n]` is the side of the window that fits into n points. Each row widens the tallest columns of good
    points that end in it (Vandevoorde 1998, Dr. Dobb's Journal 23(4)). Of equal windows the larger rectangle
    counts, then the one nearest to the middle, so that a mirrored map has its window in the same position.
    """
    ny, nx = good.shape
    if good.all():
        return (0, 0, ny, nx) if sides[ny] * sides[nx] else (0, 0, 0, 0)
    columns = np.arange(nx)
    tall, x_left, right = np.zeros(nx, dtype=int), np.zeros(nx, dtype=int), np.full(nx, nx)
    best, best_area, best_rank = (0, 0, 0, 0), 0, (0.0, 0.0)
    for row in range(ny):
        row_good = good[row]
        # one past the last bad cell to the left, and the first bad cell to the right
        left_edge = np.maximum.accumulate(np.where(row_good, 0, columns + 1))
        to_right = np.minimum.accumulate(np.where(row_good, nx, columns)[::-1])[::-1]
        tall = np.where(row_good, tall + 1, 0)  # height of the column of good points that ends in this row
        x_left = np.where(row_good, np.maximum(x_left, left_edge), 0)
        right = np.where(row_good, np.minimum(right, to_right), nx)
        area = np.where(row_good, sides[tall] * sides[right - x_left], 0)
        largest = int(area.max())
        if largest < max(best_area, 1):
            continue
        equal = np.flatnonzero(area == largest)
        height, width, x0 = tall[equal], right[equal] - x_left[equal], x_left[equal]
        off_y, off_x = 2 * (row + 1) - height - ny, 2 * x0 + width - nx  # twice the distance to the middle
        distance = off_y.astype(float) ** 2 + off_x.astype(float) ** 2
        # of windows of equal area the one in the largest rectangle, then the one nearest to the middle
        top = np.lexsort((distance, -height * width))[0]
        rank = (float(-height[top] * width[top]), float(distance[top]))
        if largest > best_area or rank < best_rank:
            best_area, best_rank = largest, rank
            best = (row + 1 - int(height[top]), int(x0[top]), int(height[top]), int(width[top]))
    return best
