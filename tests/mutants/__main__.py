"""``python -m mutants``: see `campaign`."""

import os

# Before anything is imported: plain Python for compiled code, and no pool of threads that a fork would lose.
os.environ |= {"NUMBA_DISABLE_JIT": "1", "OMP_NUM_THREADS": "1", "OPENBLAS_NUM_THREADS": "1", "MPLBACKEND": "Agg"}

from mutants.campaign import main

main()
