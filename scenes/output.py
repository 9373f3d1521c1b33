"""An output folder whose files appear whole or not at all."""

import json
import shutil
import tempfile
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import numpy as np

from planner.errors import InputError


@contextmanager
def output_folder(folder: Path) -> Iterator[Path]:
    """Yield a scratch folder; its files are moved into `folder` when the block ends without an error.

    The scratch folder lies beside the final one, so that moving is a rename. Older files of the same names are
    replaced, others are left alone.

    Raises:
        InputError: if the folder cannot be made or written.
    """
    folder = Path(folder).absolute()
    try:
        if folder.exists() and not folder.is_dir():
            raise NotADirectoryError
        folder.mkdir(parents=True, exist_ok=True)
        scratch = Path(tempfile.mkdtemp(prefix=".unfinished-", dir=folder))
    except OSError as error:
        reason = "a file of that name is in the way" if isinstance(error, NotADirectoryError) else error.strerror
        raise InputError(
            f"--out: cannot write into {folder} ({reason}); name a folder that can be created and written."
        ) from error
    try:
        yield scratch
        for path in sorted(scratch.iterdir()):
            path.replace(folder / path.name)
    except OSError as error:
        if error.errno is None:
            raise
        raise InputError(
            f"--out: writing into {folder} failed ({error.strerror}); make room or name another folder."
        ) from error
    finally:
        shutil.rmtree(scratch, ignore_errors=True)


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
