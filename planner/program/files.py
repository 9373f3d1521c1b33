"""Programs as files: read, checked and written whole or not at all."""

import json
import os
import tempfile
from pathlib import Path
from typing import Any

from pydantic import ValidationError

from planner.errors import InputError
from planner.program.program import Program
from planner.program.sentences import validation_sentences

PROGRAM_FILE = "program.json"
SCHEMA_VERSION = Program.model_fields["schema_version"].default


def load_program(path: str | Path) -> Program:
    """Read a Program from a file, or from a plan's folder that holds `program.json`.

    Raises InputError with every problem found: unreadable file, wrong version, unknown or missing field,
    wrong digest, or parts that contradict each other.
    """
    path = Path(path)
    if path.is_dir():
        path = path / PROGRAM_FILE
    document = _read_json(path)
    version = document.get("schema_version")
    if version != SCHEMA_VERSION:
        # Told alone: the rest of a file of another version would only give findings that mislead.
        raise InputError(
            f"{path}: schema_version is {version!r}, allowed is {SCHEMA_VERSION!r}; plan again with this software"
        )
    found = document.pop("digest", None)
    try:
        program = Program.model_validate_json(json.dumps(document), strict=True)
    except ValidationError as error:
        raise InputError(validation_sentences(error, str(path))) from None
    except InputError as error:
        raise InputError([f"{path}: {problem}" for problem in error.problems]) from None
    if found != program.digest:
        raise InputError(
            f"{path}: digest is {found!r} but the content gives {program.digest!r}: the file was "
            "changed after it was written; plan again, or rewrite it with save_program if the change is meant"
        )
    return program


def save_program(program: Program, path: str | Path) -> Path:
    """Write a Program with its digest; a crash leaves the old file or the new one, never half of it.

    Returns the file's path. Raises InputError when the place cannot be written.
    """
    path = Path(path)
    document = {**program.model_dump(mode="json"), "digest": program.digest}
    text = json.dumps(document, separators=(",", ":"), ensure_ascii=False) + "\n"
    partial: str | None = None
    try:
        with tempfile.NamedTemporaryFile(
            "w", encoding="utf-8", dir=path.parent, prefix=f".{path.name}.", delete=False
        ) as file:
            partial = file.name
            file.write(text)
            file.flush()
            os.fsync(file.fileno())
        Path(partial).chmod(0o644)
        Path(partial).replace(path)
    except OSError as error:
        if partial is not None:
            Path(partial).unlink(missing_ok=True)
        raise InputError(
            f"{path}: the program cannot be written ({error.strerror or error}); choose a folder that "
            "exists, is writable and has room"
        ) from None
    return path


def program_schema() -> dict[str, Any]:
    """Return the JSON schema of a program file."""
    schema = Program.model_json_schema(mode="serialization")
    schema["$schema"] = "https://json-schema.org/draft/2020-12/schema"
    schema["properties"]["digest"] = {
        "type": "string",
        "pattern": "^sha256:[0-9a-f]{64}$",
        "description": Program.digest.__doc__ or "",
    }
    schema["required"] = [*schema["required"], "digest"]
    return schema


def _read_json(path: Path) -> dict[str, Any]:
    try:
        document = json.loads(path.read_text(encoding="utf-8"))
    except FileNotFoundError:
        raise InputError(f"{path}: no such file; give a program.json or the folder of a plan") from None
    except OSError as error:
        raise InputError(f"{path}: cannot be read ({error.strerror or error}); check the file") from None
    except (ValueError, RecursionError) as error:
        raise InputError(f"{path}: not valid JSON ({error}); give a program.json written by `lce plan`") from None
    if not isinstance(document, dict):
        raise InputError(f"{path}: holds a JSON {type(document).__name__}, allowed is one object; give a program.json")
    return document
