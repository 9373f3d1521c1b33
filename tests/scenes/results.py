"""What a coarse prediction is asked for and leaves behind."""

import json

COARSE = ("--mesh-mm", "1.5", "--device", "cpu")


def names(folder):
    return {path.name for path in folder.iterdir()}


def result_of(folder):
    return json.loads((folder / "result.json").read_text())
