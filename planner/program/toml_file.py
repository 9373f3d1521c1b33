"""TOML files from outside as frozen models, or an error that names every problem."""

import json
import tomllib
from pathlib import Path
from typing import TypeVar

from pydantic import BaseModel, ValidationError

from planner.errors import InputError
from planner.program.sentences import validation_sentences

Model = TypeVar("Model", bound=BaseModel)


def read_toml(path: Path, model: type[Model], kind: str) -> Model:
    """Read a TOML file as a model, strictly.

    Args:
        path: file to read.
        model: what it must be.
        kind: what the user calls such a file, as `machine`.

    Raises:
        InputError: with every problem found: unreadable file, unknown or missing key, wrong value.
    """
    try:
        document = tomllib.loads(path.read_text(encoding="utf-8"))
    except FileNotFoundError:
        raise InputError(f"{path}: no such {kind} file; check the path") from None
    except OSError as error:
        raise InputError(f"{path}: cannot be read ({error.strerror or error}); check the file") from None
    except (ValueError, RecursionError) as error:
        raise InputError(f"{path}: not valid TOML ({error}); correct the line named") from None
    # Through JSON, because only there strict checking takes an array for a tuple; dates become text.
    text = json.dumps(document, default=str)
    try:
        return model.model_validate_json(text, strict=True)
    except ValidationError as error:
        raise InputError(validation_sentences(error, str(path), model)) from None
