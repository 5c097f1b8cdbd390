"""Memory kept from one solve to the next."""

import os
import sys
import threading

import numpy as np
import pytest

import roughcontact as rc
from roughcontact.kernels.memory import MIN_BYTES, Store, store
from roughcontact.surface.synthetic import self_affine_surface

MANY = 2 * MIN_BYTES


def test_an_array_takes_the_memory_that_another_has_left():
    store = Store()
    array = store.empty((MANY // 8,), np.float64)
    address = array.ctypes.data
    neighbour = store.empty((MANY,), np.uint8)
    assert neighbour.ctypes.data >= address + MANY
    del array
    assert store.bytes_in_use() == MANY
    larger = store.empty((2 * MANY,), np.uint8)
    assert larger.ctypes.data >= neighbour.ctypes.data + MANY
    second_array = store.empty((2, MANY // 8), np.float32)
    assert second_array.ctypes.data == address
    assert store.bytes_in_use() == 4 * MANY
    assert second_array.shape == (2, MANY // 8)
    assert second_array.dtype == np.float32
    assert second_array.flags.writeable


def test_rooms_that_touch_are_one_room():
    store = Store()
    arrays = [store.empty((MANY,), np.uint8) for _ in range(5)]
    start = arrays[1].ctypes.data
    for number in (2, 1, 3):
        arrays[number] = None
    assert store.empty((3 * MANY,), np.uint8).ctypes.data == start
    assert store.bytes_in_use() == 2 * MANY


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
    assert store.bytes_in_use() == MANY
    store.empty((2, MANY // 16), np.float64)[...] = 2.0
    assert (np.asarray(view).view(np.float64) == 1.0).all()
    del view
    assert store.bytes_in_use() == 0


def test_small_arrays_and_those_without_room_lie_elsewhere():
    store = Store(limit=4 * MANY)
    arrays = [store.empty((size,), np.uint8) for size in (MIN_BYTES - 8, 4 * MANY + 8)]
    assert store.bytes_in_use() == 0
    arrays += [store.empty((size,), np.uint8) for size in (3 * MANY, 2 * MANY, MANY)]
    assert store.bytes_in_use() == 4 * MANY
    assert [array.size for array in arrays] == [MIN_BYTES - 8, 4 * MANY + 8, 3 * MANY, 2 * MANY, MANY]
    del arrays
    assert store.bytes_in_use() == 0


@pytest.mark.skipif(
    not sys.platform.startswith("linux"), reason="Linux alone wipes what it gets back at once"
)
@pytest.mark.parametrize("also_held", [False, True])
@pytest.mark.parametrize("above_the_limit", [False, True])
def test_memory_is_given_back_by_clear_and_by_an_array_above_the_limit(also_held, above_the_limit):
    store = Store(limit=4 * MANY)

    def used():
        array = store.empty((2 * MANY,), np.uint8)
        result = array.any()
        array[:] = 1
        return result

    array = store.empty((MANY,), np.uint8) if also_held else None
    assert not used()
    assert used()  # nobody wipes what is kept
    if above_the_limit:
        store.empty((4 * MANY + 1,), np.uint8)
    else:
        store.clear()
    assert not used()
    del array


def test_a_clear_leaves_arrays_alone():
    store = Store(limit=4 * MANY)
    gone, array = store.empty((MANY,), np.uint8), store.empty((MANY,), np.uint8)
    array[:] = 7
    del gone
    store.clear()
    assert (array == 7).all()
    assert store.bytes_in_use() == MANY


@pytest.mark.skipif(not hasattr(os, "fork"), reason="no processes are forked here")
def test_a_forked_process_has_a_copy_of_its_own():
    store = Store()
    array = store.empty((MANY,), np.uint8)
    array[:] = 1
    child = os.fork()
    if not child:
        array[:] = 2
        os._exit(0 if (array == 2).all() else 1)
    assert os.waitpid(child, 0)[1] == 0
    assert (array == 1).all()


def test_who_finds_the_store_in_use_does_without():
    store, results = Store(), []
    with store._turn:
        worker = threading.Thread(target=lambda: results.append(store.empty((MANY,), np.uint8)))
        worker.start()
        worker.join()
    assert results[0].size == MANY
    assert store.bytes_in_use() == 0


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

    first_solution = solve(3e6)
    pressure, gap = first_solution.pressure.values.copy(), first_solution.gap.values.copy()
    store.clear()
    assert (solve(3e6).pressure.values == pressure).all()
    bytes_before = store.bytes_in_use()
    # a solve works on two pressures in turn: the last one may be either
    addresses = [solve(load).pressure.values.ctypes.data for load in 3 * (5e6, 5e6, 4e6)]
    assert len(set(addresses)) <= 2
    assert store.bytes_in_use() == bytes_before
    assert (first_solution.pressure.values == pressure).all()
    assert (first_solution.gap.values == gap).all()
