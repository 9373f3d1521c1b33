from dataclasses import fields, replace

import numpy as np
import pytest

from planner.calibration import load_calibration
from planner.errors import InputError
from scenes.checkpoint import inputs_digest, load_checkpoint, save_checkpoint
from scenes.targets import sphere_cap
from twin.inverse import Field, InverseOptions


def test_what_was_saved_is_loaded(tmp_path, field):
    path = tmp_path / "checkpoint.npz"
    save_checkpoint(path, field, "sha256:a")
    save_checkpoint(path, replace(field, stage="middle"), "sha256:a")
    found = load_checkpoint(path, "sha256:a")
    assert found.stage == "middle"
    for part in fields(Field):
        if part.name != "stage":
            value = getattr(found, part.name)
            assert type(value) is type(getattr(field, part.name))
            assert np.array_equal(value, getattr(field, part.name))
    assert list(tmp_path.iterdir()) == [path]


def test_a_checkpoint_that_cannot_be_used_is_refused(tmp_path, field):
    path = tmp_path / "checkpoint.npz"
    with pytest.raises(InputError, match="there is no"):
        load_checkpoint(path, "sha256:a")
    save_checkpoint(path, field, "sha256:a")
    with pytest.raises(InputError, match="belongs to another target, calibration or setting"):
        load_checkpoint(path, "sha256:b")
    whole = path.read_bytes()
    for content in (b"", b"scrambled", whole[: len(whole) // 2]):
        path.write_bytes(content)
        with pytest.raises(InputError, match="cannot be read"):
            load_checkpoint(path, "sha256:a")
    np.savez(path, stage="coarse")
    with pytest.raises(InputError, match="cannot be read"):
        load_checkpoint(path, "sha256:a")


def test_the_digest_follows_all_inputs_but_the_budget():
    target, calibration, options = sphere_cap(radius_mm=16, edge_radius_mm=10), load_calibration(), InverseOptions()
    digest = inputs_digest(target, calibration, options)
    assert inputs_digest(target, load_calibration(), replace(options, budget_s=9.0)) == digest
    others = [
        inputs_digest(sphere_cap(radius_mm=16, edge_radius_mm=10.5), calibration, options),
        inputs_digest(target, calibration, replace(options, seed=1)),
        inputs_digest(target, calibration, replace(options, heated=replace(options.heated, temperature_c=120.0))),
    ]
    assert len({digest, *others}) == 4
