"""Memory kept from one solve to the next."""

import gc
import threading
import tracemalloc

import numpy as np
import pytest

import roughcontact as rc
from roughcontact.memory import SMALLEST, Store, store
from roughcontact.synthetic import self_affine_surface

MANY = 2 * SMALLEST


def test_an_array_takes_the_memory_that_another_of_its_size_has_left():
    store = Store()
    first = store.empty((MANY // 8,), np.float64)
    address = first.ctypes.data
    del first
    assert store.kept() == MANY
    other_size = store.empty((MANY,), np.float32)
    assert other_size.ctypes.data != address
    assert store.kept() == MANY
    second = store.empty((2, MANY // 8), np.float32)
    assert second.ctypes.data == address
    assert store.kept() == 0
    assert second.shape == (2, MANY // 8)
    assert second.dtype == np.float32
    assert second.flags.writeable


@pytest.mark.parametrize(
    "look_at",
    [lambda a: a[1:], lambda a: a.reshape(-1)[::2], lambda a: a.view(np.int64), memoryview, np.asarray],
    ids=["slice", "strides", "other type", "buffer", "itself"],
)
def test_memory_that_a_view_uses_is_not_lent_again(look_at):
    store = Store()
    array = store.empty((2, MANY // 16), np.float64)
    array[...] = 1.0
    view = look_at(array)
    del array
    assert store.kept() == 0
    store.empty((2, MANY // 16), np.float64)[...] = 2.0
    assert (np.asarray(view).view(np.float64) == 1.0).all()
    del view
    assert store.kept() == 2 * MANY


def test_small_arrays_and_those_above_the_limit_are_not_kept():
    store = Store(limit=4 * MANY)
    for size in (SMALLEST - 8, 4 * MANY + 8):
        store.empty((size // 8,), np.float64)
        assert store.kept() == 0


def test_an_array_above_the_limit_gives_back_what_is_kept():
    store = Store(limit=2 * SMALLEST)
    array = store.empty((SMALLEST,), np.uint8)
    del array
    assert store.kept() == SMALLEST
    store.empty((2 * SMALLEST + 1,), np.uint8)
    assert store.kept() == 0


def test_no_more_is_kept_than_the_limit_leaves():
    store = Store(limit=4 * MANY)
    held = [store.empty((MANY + 8 * k,), np.uint8) for k in range(3)]
    while held:
        del held[0]
    assert store.kept() == 3 * MANY + 24
    large = store.empty((2 * MANY,), np.uint8)  # what came back first makes room
    assert store.kept() == MANY + 16
    del large
    store.clear()
    assert store.kept() == 0


def test_who_finds_the_store_in_use_does_without():
    store = Store()
    store.empty((MANY,), np.uint8)
    found = []
    with store._turn:
        worker = threading.Thread(target=lambda: found.append(store.empty((MANY,), np.uint8)))
        worker.start()
        worker.join()
    assert found[0].size == MANY
    assert store.kept() == MANY
    found.clear()
    assert store.kept() == MANY  # that array was never the store's


def test_threads_never_share_the_memory_of_an_array():
    store, clashes = Store(), []

    def work(number):
        for _ in range(500):
            array = store.empty((MANY // 8,), np.float64)
            array[...] = number
            if not (array == number).all():
                clashes.append(number)

    workers = [threading.Thread(target=work, args=(number,)) for number in range(4)]
    for worker in workers:
        worker.start()
    for worker in workers:
        worker.join()
    assert not clashes


def test_the_next_solve_takes_up_the_memory_of_the_last_and_leaves_its_result_alone():
    band = {"hurst": 0.8, "shortest": 8e-6, "longest": 64e-6}
    height = self_affine_surface((256, 256), 1e-6, **band, rms_gradient=0.1, seed=1)

    def solve(load):
        return rc.solve_contact(height, contact_modulus=1e9, mean_pressure=load)

    def peak_of(solve_once):
        gc.collect()
        tracemalloc.start()
        try:
            solve_once()
            return tracemalloc.get_traced_memory()[1]
        finally:
            tracemalloc.stop()

    first = solve(3e6)
    pressure, gap = first.pressure.values.copy(), first.gap.values.copy()
    store.clear()
    fresh, kept = peak_of(lambda: solve(3e6)), peak_of(lambda: solve(3e6))
    assert kept < 0.5 * fresh
    assert (solve(3e6).pressure.values == pressure).all()
    solve(5e6)
    assert (first.pressure.values == pressure).all()
    assert (first.gap.values == gap).all()
