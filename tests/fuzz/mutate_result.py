"""Results of comparisons, and what stands in them, with something in a file or in the folder changed."""

from __future__ import annotations

import json
import os
import shutil
import tomllib
from pathlib import Path
from typing import Any

import h5py
import numpy as np
import pandas as pd

from fuzz import generate_toml
from fuzz.hostile import Rng, chance, mutate_bytes, mutate_tree, name, pick, value


def label(rng: Rng) -> str:
    """A name that HDF5 and Parquet can hold."""
    return name(rng).replace("\x00", "").encode("utf-8", "replace").decode()


def change_netcdf(rng: Rng, path: Path) -> None:
    """One change to a NetCDF file's variables, axes or attributes."""
    with h5py.File(path, "r+") as file:
        keys = sorted(file)
        if not keys:
            return
        key = pick(rng, keys)
        how = int(rng.integers(8))
        if how == 0:
            del file[key]
        elif how == 1:
            file.move(key, label(rng).strip("/.") or "x")
        elif how == 2:
            attributes = dict(file[key].attrs)
            shape = tuple(max(0, n + int(rng.integers(-2, 3))) for n in file[key].shape)
            del file[key]
            made = file.create_dataset(key, data=np.zeros(shape))
            for attribute, item in attributes.items():
                if attribute not in ("DIMENSION_LIST", "REFERENCE_LIST", "CLASS", "NAME"):
                    made.attrs[attribute] = item
        elif how == 3:
            del file[key]
            kind: Any = pick(rng, [np.int8, "S3", h5py.string_dtype(), np.complex128, np.bool_, np.float16])
            file.create_dataset(key, shape=(3,), dtype=kind)
        elif how == 4:
            del file[key]  # a terabyte of nothing, which takes no room on disk
            file.create_dataset(key, shape=(10**6, 10**6), dtype="f8", chunks=(1000, 1000), compression="gzip")
        elif how == 5 and file[key].dtype.kind == "f" and file[key].size:
            values = file[key][...].reshape(-1)
            values[int(rng.integers(values.size))] = pick(rng, [np.nan, np.inf, -1e300, 1e6])
            file[key][...] = values.reshape(file[key].shape)
        elif how == 6 and file[key].dtype.kind == "O" and file[key].size:
            values = file[key][...].reshape(-1)
            values[int(rng.integers(values.size))] = label(rng).encode()
            file[key][...] = values.reshape(file[key].shape)
        else:
            holder = pick(rng, [file, file[key]])
            attribute = pick(rng, [*sorted(holder.attrs), "extra"])
            holder.attrs[attribute] = pick(rng, ["", "days since 1999-13-45", np.nan, 10**9, label(rng)])


def change_parquet(rng: Rng, path: Path) -> None:
    """One change to a table's columns or rows."""
    frame = pd.read_parquet(path)
    column = pick(rng, list(frame.columns))
    how = int(rng.integers(6))
    if how == 0:
        frame = frame.drop(columns=[column])
    elif how == 1:
        frame = frame.rename(columns={column: label(rng)})
    elif how == 2:
        frame[column] = pick(rng, ["text", 1, None, np.nan, True, "\x1b[31m"])
    elif how == 3:
        frame = frame.iloc[: int(rng.integers(len(frame) + 1))]
    elif how == 4:
        frame = pd.concat([frame, frame])
    else:
        frame[column] = [[1.0, 2.0]] * len(frame)
    frame.to_parquet(path)


def change_file(rng: Rng, path: Path, corpus: list[Path]) -> None:
    """One change to a file of a result, of a sort that fits it."""
    other = pick(rng, corpus) / path.name
    how = rng.random()
    if how < 0.2:
        path.write_bytes(mutate_bytes(rng, path.read_bytes(), other.read_bytes()))
    elif how < 0.25:
        path.write_bytes(pick(rng, [b"", b"{}", b"[]", b"null", b"PAR1PAR1", b"\x89HDF\r\n\x1a\n", rng.bytes(100)]))
    elif how < 0.3:
        path.unlink()
        target = pick(rng, ["/dev/zero", "/dev/null", "nowhere", path.name, "."])
        if chance(rng, 0.5):
            os.symlink(target, path)
        elif chance(rng, 0.5):
            path.mkdir()
    elif how < 0.35:
        shutil.copyfile(other, path)
    elif path.suffix == ".nc":
        change_netcdf(rng, path)
    elif path.suffix == ".parquet":
        change_parquet(rng, path)
    elif path.suffix == ".json":
        tree = json.loads(path.read_text(encoding="utf-8"))
        mutate_tree(rng, tree)
        path.write_text(json.dumps(tree), encoding="utf-8")
    elif path.suffix == ".toml":
        tree = tomllib.loads(path.read_text(encoding="utf-8"))
        if chance(rng, 0.3):
            pick(rng, list(tree["controllers"].values()))["law"] = "canary:Law"
        else:
            mutate_tree(rng, tree)
        generate_toml.shorten(tree)
        path.write_text(generate_toml.toml(tree), encoding="utf-8", errors="surrogatepass")


def make(rng: Rng, folder: Path, corpus: list[Path]) -> list[str]:
    """Put a result into the folder; the command that is to read it.

    Args:
        rng: Where all chance comes from.
        folder: An empty folder, which will be the working directory.
        corpus: Sound results.
    """
    result = folder / "res"
    shutil.copytree(pick(rng, corpus), result)
    files = [path for path in sorted(result.iterdir()) if path.suffix in (".nc", ".parquet", ".json", ".toml")]
    for path in rng.permutation(np.array(files, dtype=object))[: int(rng.choice([0, 1, 1, 1, 1, 2, 3]))]:
        change_file(rng, path, corpus)
    generate_toml.companions(rng, result)
    generate_toml.canary(rng, folder, result)
    how = rng.random()
    if how < 0.4:
        return ["view", "res", "--html", "page.html"]
    if how < 0.75:
        return ["report", "res"]
    words = ["verify", str(pick(rng, ["two_link", "ur5"])), "--mbar", "0.01", "--samples", "64"]
    words += ["--along", str(pick(rng, ["res/experiment.toml", "res/experiment.toml", "res", "res/motion.csv"]))]
    words += ["--tube", str(value(rng))] if chance(rng, 0.1) else []
    return [*words, *(["--json"] if chance(rng, 0.7) else [])]
