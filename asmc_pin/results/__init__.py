"""A result's folder on disk: written whole, read within bounds, with where it came from.

In come rollouts of an experiment, out go NetCDF, Parquet and TOML, and back. Never imports code that a result names.
"""
