"""Mutants: small faults put into the package one at a time, each of which some test must notice. Run by `make mutants`.

`operators` says what faults there are (cosmic-ray's, and those it lacks), `draw` takes some by a seed, `judge` runs the
quick tests against each in a fork, `campaign` counts and compares with `equivalents.toml`. `targets.toml` says which
modules are mutated and which tests judge. Compiled code runs as plain Python here, so that a fault costs no compiling.
"""
