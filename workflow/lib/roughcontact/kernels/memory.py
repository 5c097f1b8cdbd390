"""Memory that one solve leaves and the next one takes up again.

The system hands memory out page by page, each wiped at its first touch: with fresh arrays a solve takes a
fifth to a third longer (256 to 1024 points a side; CPU time), and two threads wait for each other there. Here
arrays lie side by side in one range of pages, and their memory is lent again when an array and all views of
it are gone. What is simpler was measured: such a range for each solve, given back after it, costs 3 to 10 %,
and twice the time of the solve where the system has no large pages at hand; lists of arrays by size take as
long as this, and 68 bytes a point instead of 41.
"""

import mmap
import weakref
from bisect import insort
from collections import deque
from contextlib import suppress
from math import prod
from threading import Lock

import numpy as np
from numpy.typing import DTypeLike

# Bytes of a store: maps up to 2048 x 2048 points fit whole, and a larger map puts elsewhere what does not.
LIMIT = 256 * 2**20
SMALLEST = 2**16  # bytes: below that the memory allocator of the process keeps arrays itself


class Store:
    """Memory for arrays; the system gives what has been used of it, and no more.

    Parameters
    ----------
    limit : int
        bytes.
    """

    def __init__(self, limit: int = LIMIT):
        self.limit = limit
        self._pages: mmap.mmap | None = None
        # (start, end) of every range that no array uses, in order, none beside the next
        self._free: list[tuple[int, int]] = []
        # by the id of a weak reference to each array: that reference, and its range
        self._lent: dict[int, tuple[weakref.ref, tuple[int, int]]] = {}
        self._returned: deque[tuple[int, int]] = deque()  # ranges that came back since the last call
        self._turn = Lock()

    def empty(self, shape: tuple[int, ...], dtype: DTypeLike) -> np.ndarray:
        """Return a new array, its content undefined.

        Parameters
        ----------
        shape : tuple of int
        dtype : dtype

        Returns
        -------
        array
        """
        dtype = np.dtype(dtype)
        size = prod(shape) * dtype.itemsize
        # never waits: whoever finds another thread here (one that a fork has left behind, too) does without
        if size < SMALLEST or not self._turn.acquire(blocking=False):
            return np.empty(shape, dtype)
        try:
            if size > self.limit:  # where memory is short nothing is kept
                self._give_back()
                return np.empty(shape, dtype)
            found, pages = self._take(size), self._pages
            if found is None or pages is None:
                return np.empty(shape, dtype)
        finally:
            self._turn.release()
        # a view holds on to the last array in its chain of bases: this one, because its base is none
        array = np.frombuffer(pages, dtype, prod(shape), found[0])
        reference = weakref.ref(array, self._end)
        self._lent[id(reference)] = reference, found
        return array.reshape(shape)

    def _end(self, reference: weakref.ref) -> None:
        self._returned.append(self._lent.pop(id(reference))[1])

    def lent(self) -> int:
        """Return the bytes that arrays use, in whole pages.

        Returns
        -------
        int
        """
        with self._turn:
            self._take_back()
            return self._size() - sum(end - start for start, end in self._free)

    def clear(self) -> None:
        """Give back to the system what no array uses."""
        with self._turn:
            self._give_back()

    def _size(self) -> int:
        return 0 if self._pages is None else len(self._pages)

    def _take(self, size: int) -> tuple[int, int] | None:
        """Take the first free range of `size` bytes or more from the list; None if there is none."""
        self._take_back()
        if self._pages is None:
            self._pages = _new_pages(self.limit)
            self._free = [(0, len(self._pages))]
        size = _in_whole_pages(size)
        for number, (start, end) in enumerate(self._free):
            if end - start >= size:
                self._free[number : number + 1] = [(start + size, end)] if end - start > size else []
                return start, start + size
        return None

    def _take_back(self) -> None:
        while self._returned:
            insort(self._free, self._returned.popleft())
        ranges, self._free = self._free, []
        for start, end in ranges:
            touching = self._free and self._free[-1][1] == start
            self._free.append((self._free.pop()[0] if touching else start, end))

    def _give_back(self) -> None:
        self._take_back()
        if self._free == [(0, self._size())]:
            self._pages, self._free = None, []
        elif self._pages is not None and hasattr(mmap, "MADV_DONTNEED"):  # not on Windows
            for start, end in self._free:
                self._pages.madvise(mmap.MADV_DONTNEED, start, end - start)


def _new_pages(size: int) -> mmap.mmap:
    """Return `size` bytes, in whole pages, of which a child process that is forked gets a copy of its own."""
    private = {"flags": mmap.MAP_PRIVATE | mmap.MAP_ANONYMOUS} if hasattr(mmap, "MAP_PRIVATE") else {}
    pages = mmap.mmap(-1, _in_whole_pages(size), **private)
    if hasattr(mmap, "MADV_HUGEPAGE"):  # Linux: one fault for 512 pages, in kernels that are built for it
        with suppress(OSError):
            pages.madvise(mmap.MADV_HUGEPAGE)
    return pages


def _in_whole_pages(size: int) -> int:
    return -(-size // mmap.PAGESIZE) * mmap.PAGESIZE


store = Store()
