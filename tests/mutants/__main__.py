"""``python -m mutants``: see `campaign`."""

import os

# Before anything is imported: forks would lose a pool of threads, and share the machine.
os.environ |= {"OMP_NUM_THREADS": "1", "OPENBLAS_NUM_THREADS": "1", "MPLBACKEND": "Agg"}

from mutants.campaign import main

main()
