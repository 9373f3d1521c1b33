"""An output folder whose files appear whole or not at all."""

import errno
import json
import shutil
import tempfile
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from pathlib import Path
from typing import Any

import numpy as np

from planner.errors import InputError

UNWRITABLE = frozenset(
    (errno.EACCES, errno.EDQUOT, errno.EFBIG, errno.EIO, errno.ENAMETOOLONG, errno.ENOSPC, errno.EPERM, errno.EROFS)
)
"""What the system says where the user must make room or choose another folder; anything else is a bug."""


@contextmanager
def output_folder(folder: Path) -> Iterator[Path]:
    """Yield a scratch folder; its files are moved into `folder` when the block ends without an error.

    The scratch folder lies inside the final one, so that moving is a rename. Older files of the same names are
    replaced, others are left alone. After an error `folder` is as it was before, absent if it was absent.

    Raises:
        InputError: if the folder cannot be made or written.
    """
    folder = Path(folder).absolute()
    made = [path for path in (folder, *folder.parents) if not path.exists()]
    try:
        folder.mkdir(parents=True, exist_ok=True)
        scratch = Path(tempfile.mkdtemp(prefix=".unfinished-", dir=folder))
    except OSError as error:
        _remove_empty(made)
        in_the_way = isinstance(error, NotADirectoryError | FileExistsError)
        reason = "a file of that name is in the way" if in_the_way else error.strerror
        raise InputError(
            f"--out: cannot write into {folder} ({reason}); name a folder that can be created and written."
        ) from error
    try:
        yield scratch
        _move(scratch, folder)
    except BaseException as error:
        shutil.rmtree(scratch, ignore_errors=True)
        _remove_empty(made)
        if isinstance(error, OSError) and error.errno in UNWRITABLE:
            raise InputError(
                f"--out: writing into {folder} failed ({error.strerror}); make room or name another folder."
            ) from error
        raise
    scratch.rmdir()


def _move(scratch: Path, folder: Path) -> None:
    """Rename all files from `scratch` into `folder`, or none if a folder is in the way of one."""
    paths = sorted(scratch.iterdir())
    blocked = [path.name for path in paths if (folder / path.name).is_dir()]
    if blocked:
        raise InputError(
            f"--out: {folder} has folders named {', '.join(blocked)} where files of these names are to be written; "
            "name another folder."
        )
    for path in paths:
        path.replace(folder / path.name)


def _remove_empty(folders: list[Path]) -> None:
    """Remove the folders, innermost first, that hold nothing."""
    with suppress(OSError):
        for path in folders:
            path.rmdir()


def write_json(path: Path, content: dict[str, Any]) -> None:
    """Write a dictionary as indented JSON; NaN and infinity become null, since JSON has neither."""
    path.write_text(json.dumps(_plain(content), indent=2, allow_nan=False) + "\n", encoding="utf-8")


def _plain(value: Any) -> Any:
    if isinstance(value, dict):
        return {str(key): _plain(item) for key, item in value.items()}
    if isinstance(value, list | tuple | np.ndarray):
        return [_plain(item) for item in value]
    if isinstance(value, np.generic):
        value = value.item()
    if isinstance(value, float) and not np.isfinite(value):
        return None
    return value
