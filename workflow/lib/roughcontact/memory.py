"""Memory that one solve leaves and the next one takes up again.

The system hands memory out page by page, each wiped at its first touch: fresh arrays for every solve cost a
tenth of its time on one thread and a quarter on two, which wait for each other there. Here the memory of an
array goes back to a store when the array and all views of it are gone.
"""

import weakref
from collections import deque
from math import prod
from threading import Lock

import numpy as np

# Bytes that a store lends and keeps together: beyond that it keeps nothing. Maps up to 1024 x 1024 points fit
# whole, and the peak of larger ones is as if nothing was kept.
LIMIT = 128 * 2**20
SMALLEST = 2**16  # bytes: below that the memory allocator of the process keeps arrays itself


class Store:
    """Blocks of memory, lent to arrays; up to `limit` bytes."""

    def __init__(self, limit: int = LIMIT):
        self.limit = limit
        self._free = []  # blocks, the one that came back first in front
        self._returned = deque()  # blocks that came back since the last call
        self._lent = 0
        self._turn = Lock()

    def empty(self, shape, dtype) -> np.ndarray:
        """Return a new array, its content undefined."""
        dtype = np.dtype(dtype)
        size = prod(shape) * dtype.itemsize
        # never waits: whoever finds another thread here (one that a fork has left behind, too) does without
        if size < SMALLEST or not self._turn.acquire(blocking=False):
            return np.empty(shape, dtype)
        try:
            if size > self.limit:  # where memory is short nothing is kept
                self._take_back()
                self._free.clear()
                return np.empty(shape, dtype)
            block = self._take(size)
        finally:
            self._turn.release()
        # a view holds on to the array at the end of its chain of bases: this one, because its base is none
        array = np.frombuffer(memoryview(block), dtype)
        weakref.finalize(array, self._returned.append, block).atexit = False
        return array.reshape(shape)

    def kept(self) -> int:
        """Return the bytes that no array uses."""
        return sum(block.size for block in (*self._free, *self._returned))

    def clear(self) -> None:
        """Give back to the system what no array uses."""
        with self._turn:
            self._take_back()
            self._free.clear()

    def _take(self, size):
        self._take_back()
        for number in reversed(range(len(self._free))):  # what was used last is most likely in the cache
            if self._free[number].size == size:
                block = self._free.pop(number)
                break
        else:
            while self._free and self._lent + size + sum(block.size for block in self._free) > self.limit:
                del self._free[0]
            block = np.empty(size, np.uint8)
        self._lent += size
        return block

    def _take_back(self):
        while self._returned:
            block = self._returned.popleft()
            self._lent -= block.size
            self._free.append(block)


store = Store()
