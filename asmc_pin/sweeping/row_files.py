"""The rows of a sweep on disk: one shard a block, each written whole; all of them in one file when it is complete."""

from __future__ import annotations

import re
from collections.abc import Iterator
from pathlib import Path

import pyarrow as pa
import pyarrow.parquet as pq

from asmc_pin.disk.files import whole_file, write_whole
from asmc_pin.errors import ResultError
from asmc_pin.sweeping.sweep_plan import KEY, SweepPlan
from asmc_pin.words.interface import option_words

SHARDS, ROWS = "rows", "rows.parquet"
ROW_GROUP = 65_536
"""Rows of a group in ``rows.parquet``, whatever the blocks were."""

_NAME = re.compile(r"(\d{9})-(\d{9})\.parquet")


def shard_path(folder: Path, block: range) -> Path:
    """Where the rows of a block lie: named by the first and the last of its trials."""
    return folder / SHARDS / f"{block[0]:09d}-{block[-1]:09d}.parquet"


def write_shard(folder: Path, block: range, content: bytes) -> None:
    """Write the rows of a block, whole or not at all."""
    write_whole(shard_path(folder, block), content)


def shards_there(folder: Path) -> dict[Path, str | None]:
    """Files of rows that lie in a folder, and the key of the sweep that each belongs to; None for a damaged one."""
    try:
        files = sorted(path for path in (folder / SHARDS).iterdir() if _NAME.fullmatch(path.name))
    except OSError:
        return {}
    return {path: key_of(path) for path in files}


def key_of(path: Path) -> str | None:
    """The key in a file of rows; None where it is damaged or has none."""
    try:
        found = (pq.read_schema(path).metadata or {}).get(KEY)
    except (OSError, ValueError, pa.ArrowException):
        return None
    return None if found is None else found.decode("ascii", "replace")


def missing_blocks(plan: SweepPlan, folder: Path) -> list[range]:
    """Blocks whose rows are not there yet; what is there and belongs to no block of this sweep is removed."""
    there = shards_there(folder)
    wanted = {shard_path(folder, block): block for block in plan.blocks}
    for path, key in there.items():
        if path not in wanted or key != plan.key:
            path.unlink(missing_ok=True)
    return [block for path, block in wanted.items() if there.get(path) != plan.key]


def read_shards(plan: SweepPlan, folder: Path) -> Iterator[pa.Table]:
    """The rows of each block, in order.

    Raises:
        ResultError: a shard is damaged, or by now that of another sweep.
    """
    for block in plan.blocks:
        path = shard_path(folder, block)
        try:
            table = pq.read_table(path, page_checksum_verification=True, use_threads=False)
        except (OSError, ValueError, pa.ArrowException) as error:
            path.unlink(missing_ok=True)
            raise ResultError(
                path, f"{path} is damaged ({error}), and was removed; start again, and it is computed anew"
            ) from None
        if (table.schema.metadata or {}).get(KEY) != plan.key.encode():
            raise ResultError(
                path,
                f"{path} has rows of another sweep, which was run in the same folder at the same time; give each a "
                f"folder of its own with {option_words('out')}, and start again",
            )
        yield table


def write_rows(plan: SweepPlan, folder: Path) -> Iterator[pa.Table]:
    """Write ``rows.parquet`` from the shards, a group of rows at a time; yields each block's rows as they go by.

    The file is there when the iteration is over.
    """
    with whole_file(folder / ROWS) as file, pq.ParquetWriter(file, plan.schema, write_page_checksum=True) as writer:
        waiting = plan.schema.empty_table()
        for table in read_shards(plan, folder):
            yield table
            waiting = pa.concat_tables([waiting, table])
            while len(waiting) >= ROW_GROUP:
                writer.write_table(waiting.slice(0, ROW_GROUP).combine_chunks(), row_group_size=ROW_GROUP)
                waiting = waiting.slice(ROW_GROUP)
        if len(waiting):
            writer.write_table(waiting.combine_chunks(), row_group_size=ROW_GROUP)
