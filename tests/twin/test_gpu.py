"""The same kernels on a CUDA device; run with `pytest -m gpu` where there is one."""

import numpy as np
import pytest
import warp as wp
from films import azimuthal, ellipse, film

from twin.cycle import rigid_distance_mm
from twin.predict import PredictOptions, heat_film
from twin.shell import Shell

pytestmark = pytest.mark.gpu


@pytest.fixture(autouse=True)
def _device():
    wp.init()
    if not wp.is_cuda_available():
        pytest.skip("no CUDA device is present")


def test_energy_gradient_and_hessian_agree_with_the_cpu():
    made = film(ellipse(12.0, 9.0), 0.5, contraction=0.2, direction=azimuthal)
    state = np.column_stack((made.flat_mm, 0.2 * np.sin(made.flat_mm[:, 0])))
    results = []
    for device in ("cpu", "cuda"):
        shell = Shell(made, device=device)
        shell.set_activation(0.8)
        results.append(shell.hessian(state))
    for on_cpu, on_gpu in zip(*results, strict=True):
        np.testing.assert_allclose(on_gpu, on_cpu, rtol=1e-9, atol=1e-9 * np.abs(on_cpu).max())


@pytest.mark.parametrize("support", ["free", "plate"])
def test_shape_agrees_with_the_cpu(support):
    made = film(ellipse(12.0, 9.0), 0.6, contraction=0.15, direction=azimuthal)
    shapes = [heat_film(made, PredictOptions(support=support, device=device)) for device in ("cpu", "cuda")]
    assert shapes[1].device.startswith("cuda")
    assert rigid_distance_mm(shapes[0].hot_mm, shapes[1].hot_mm) < 1e-4
