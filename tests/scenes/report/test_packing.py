"""Numbers survive being packed."""

import base64

import numpy as np
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays

from scenes.report.packing import STEPS, pack_indices, pack_numbers

NUMBERS = arrays(np.float64, st.integers(1, 30), elements=st.floats(-100, 100))


def unpacked(packed):
    steps = np.frombuffer(base64.b64decode(packed["uint16"]), "<u2")
    return packed["low"] + packed["step"] * steps


@given(values=NUMBERS)
def test_numbers_come_back_to_a_step_of_their_range(values):
    assert np.abs(unpacked(pack_numbers(values)) - values).max() <= np.ptp(values) / STEPS + 1e-9


def test_whole_numbers_come_back():
    values = np.array([[0, 1, 2], [70_000, 3, 4]])
    assert np.frombuffer(base64.b64decode(pack_indices(values)["uint32"]), "<u4").tolist() == values.ravel().tolist()
