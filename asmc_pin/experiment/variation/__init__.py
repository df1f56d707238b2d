"""What varies from trial to trial: ``[sweep]``, by the paths of an experiment's keys (docs/sweeps.md).

Takes an experiment's tables; gives the tables of each trial, and every mistake in ``[sweep]``. May import what checks
an experiment, and the plant's random numbers; builds nothing.
"""
