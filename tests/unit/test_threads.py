"""Threads: of the job, of a caller, and of a process that was forked. In processes of their own."""

import subprocess
import sys

PROGRAM = """
import os, sys
from concurrent.futures import ThreadPoolExecutor
import roughcontact as rc
from roughcontact.surface.synthetic import self_affine_surface

band = {"hurst": 0.8, "shortest": 8e-6, "longest": 64e-6}
height = self_affine_surface((256, 256), 1e-6, **band, rms_gradient=0.1, seed=1)

def solve(_=0):
    return rc.solve_contact(height, contact_modulus=1e9, mean_pressure=3e6, threads=2).pressure.values

with ThreadPoolExecutor(3) as pool:  # the first solves of all are at the same time
    together = list(pool.map(solve, range(6)))
alone = solve()
assert all((found == alone).all() for found in together)
child = os.fork()
if child == 0:
    os._exit(0 if abs(solve() - alone).max() < 1e-3 * alone.max() else 1)
assert os.waitpid(child, 0)[1] == 0
assert (solve() == alone).all()
print("held")
"""


def test_threads_of_a_caller_and_a_forked_process_solve_the_same():
    command = [sys.executable, "-c", PROGRAM]
    process = subprocess.run(command, capture_output=True, text=True, timeout=300, check=False)
    assert process.stdout == "held\n", process.stderr
