"""A result's folder on disk: written whole, read within bounds, with where it came from.

Takes rollouts of an experiment; gives NetCDF, Parquet and TOML, and back. Never imports code that a result names.
"""
