"""Performance of the machine at the time of the measurements: the rate of its matrix product."""

from __future__ import annotations

import ctypes
import subprocess
import sys
import time
from pathlib import Path

import numpy as np

from qsmpm_bench.measure import BenchError

ROW_MAJOR, NO_TRANSPOSE = 101, 111


def blas_of(program: Path) -> str:
    """The OpenBLAS library with which a program is linked."""
    text = subprocess.run(["ldd", str(program)], capture_output=True, text=True, check=False).stdout
    for line in text.splitlines():
        if "openblas" in line and "=>" in line:
            return line.split("=>")[1].split()[0]
    raise BenchError(f"{program} is not linked with OpenBLAS")


def dgemm_rate(library: str, n: int = 1500, turns: int = 5) -> float:
    """GF/s of dgemm with one thread, the best of several repetitions."""
    blas = ctypes.CDLL(library)
    blas.openblas_set_num_threads(1)
    pointer = ctypes.POINTER(ctypes.c_double)
    a, b, c = (np.full((n, n), 1.0 + k) for k in range(3))
    pointers = [m.ctypes.data_as(pointer) for m in (a, b, c)]
    one = ctypes.c_double(1.0)
    best = 0.0
    for _ in range(turns):
        started = time.process_time()
        blas.cblas_dgemm(ROW_MAJOR, NO_TRANSPOSE, NO_TRANSPOSE, n, n, n, one, pointers[0], n, pointers[1], n, one,
                         pointers[2], n)
        best = max(best, 2.0 * n**3 / (time.process_time() - started) * 1e-9)
    return best


if __name__ == "__main__":
    print(dgemm_rate(sys.argv[1]))
