"""Connected regions of a periodic map, and those that percolate through the period."""

import numpy as np

_BLOCK = 2**20  # points counted at a time


def connected_regions(inside: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Return region numbers (ny, nx; 0 outside) of a periodic map and which percolate (regions + 1, 2: y, x).

    Points are connected over shared edges and over the seams; a region percolates along each axis in which it
    meets itself in another periodic image.
    """
    labels, roots, around = _joined_over_seams(inside)
    roots_of_regions, number = np.unique(roots, return_inverse=True)
    return number[labels], around[roots_of_regions]


def region_sizes(inside: np.ndarray) -> np.ndarray:
    """Return the number of points of each connected region (`connected_regions`) of a periodic map."""
    labels, roots, _ = _joined_over_seams(inside)
    sizes = np.zeros(roots.size, int)
    for rows in np.array_split(labels, -(-labels.size // _BLOCK)):
        counts = np.bincount(rows.ravel())
        sizes[: counts.size] += counts
    sizes[0] = 0  # outside all regions
    total = np.bincount(roots, sizes).astype(int)
    return total[total > 0]


def percolates(inside: np.ndarray) -> tuple[bool, bool]:
    """Return whether any region (`connected_regions`) of a periodic map percolates along y, and along x."""
    along_y, along_x = _joined_over_seams(inside)[2].T
    return bool(along_y.any()), bool(along_x.any())


def _joined_over_seams(inside: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Return labels (ny, nx) that ignore seams, the root of each label, and whether roots percolate."""
    from scipy.ndimage import label

    labels, count = label(inside)
    # label at a seam -> another label of its region, and its periodic image relative to that one
    above: dict[int, tuple[int, int, int]] = {}
    around = np.zeros((count + 1, 2), bool)

    def root_of(name: int) -> tuple[int, int, int]:
        """Return the root of a label, and the periodic image of the label relative to the root."""
        root, y, x = name, 0, 0
        while root in above:
            root, more_y, more_x = above[root]
            y, x = y + more_y, x + more_x
        if root != name:
            above[name] = root, y, x  # path compression
        return root, y, x

    for axis, last, start in ((0, labels[-1], labels[0]), (1, labels[:, -1], labels[:, 0])):
        adjacent = (last > 0) & (start > 0)
        for a, b in np.unique(np.stack([last[adjacent], start[adjacent]], axis=1), axis=0).tolist():
            (root, y, x), (neighbour, other_y, other_x) = root_of(a), root_of(b)
            # the seam connects `a` with the next periodic image of `b`
            offset = y - other_y + (axis == 0), x - other_x + (axis == 1)
            if root == neighbour:
                around[root] |= np.array(offset) != 0
            else:
                above[neighbour] = root, *offset
                around[root] |= around[neighbour]
    roots = np.arange(count + 1)
    for name in list(above):
        roots[name] = root_of(name)[0]
    return labels, roots, around
