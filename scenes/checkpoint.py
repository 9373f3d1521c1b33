"""What an interrupted inverse design goes on from: the fields of its last stage, and which inputs they belong to."""

import hashlib
import json
from dataclasses import asdict, fields, replace
from importlib.metadata import version
from pathlib import Path
from zipfile import BadZipFile

import numpy as np

from planner.calibration import Calibration
from planner.errors import InputError
from planner.target import Target
from scenes.whole_file import whole_file
from twin.inverse import Field, InverseOptions

NAMES = tuple(part.name for part in fields(Field))


def inputs_digest(target: Target, calibration: Calibration, options: InverseOptions) -> str:
    """Return the digest of all that decides what a search finds but for its budget of time, as `sha256:...`."""
    settings = asdict(replace(options, budget_s=None))
    record = calibration.record.model_dump_json()
    content = json.dumps([version("lce-twin"), target.digest, record, settings], sort_keys=True, default=str)
    return f"sha256:{hashlib.sha256(content.encode()).hexdigest()}"


def save_checkpoint(path: Path, field: Field, inputs: str) -> None:
    """Write fields and the digest of their inputs into an .npz, whole or not at all."""
    with whole_file(path) as scratch, scratch.open("wb") as file:
        np.savez_compressed(file, **{name: getattr(field, name) for name in NAMES}, inputs=inputs)


def load_checkpoint(path: Path, inputs: str) -> Field:
    """Read fields that `save_checkpoint` wrote.

    Args:
        path: the .npz file.
        inputs: digest of the inputs that the search goes on with.

    Raises:
        InputError: if there is none, it cannot be read, or it belongs to other inputs.
    """
    if not path.is_file():
        raise InputError(
            f"--resume: there is no {path}: no search for this --out was interrupted after its first stage; leave "
            "--resume out to start anew."
        )
    try:
        with path.open("rb") as file, np.load(file) as archive:
            found = {name: archive[name] for name in (*NAMES, "inputs")}
    except (OSError, ValueError, KeyError, EOFError, BadZipFile) as error:
        raise InputError(f"--resume: {path} cannot be read ({error}); leave --resume out to start anew.") from error
    if str(found["inputs"]) != inputs:
        raise InputError(
            f"--resume: {path} belongs to another target, calibration or setting; repeat the command as it was, or "
            "leave --resume out to start anew."
        )
    return Field(**{name: found[name] if found[name].ndim else found[name].item() for name in NAMES})
