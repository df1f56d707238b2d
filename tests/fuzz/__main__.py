"""``python -m fuzz``: see `campaign`."""

import os

# Every input runs in a fork, which a pool of threads would not survive; and the forks share the machine.
os.environ |= {"OMP_NUM_THREADS": "1", "OPENBLAS_NUM_THREADS": "1", "MPLBACKEND": "Agg"}

from fuzz.campaign import main

main()
