"""Batches: the same shapes as one film after the other, whichever films share the launches."""

import threading
import time
from dataclasses import replace

import numpy as np
import pytest
import warp as wp
from films import azimuthal, ellipse, film, random_film, rectangle

from planner.errors import InputError, SolverError
from twin.batch import heat_films, run_together
from twin.batch.gathering import Gathering
from twin.equilibrium import rigid_distance_mm
from twin.film import Film
from twin.predict import PredictOptions, heat_film
from twin.shell import Loads, Shell
from twin.shell.device import open_device
from twin.shell.home import living_in
from twin.shell.rest import rest_state
from twin.shell.worlds import State, Want, Worlds
from twin.temperature import TemperatureGapModel

LOADS = Loads(weight=5.65e-5, plate_per_mm=1.0, plate_reach_mm=0.2)


def different_films(count: int, *, edge_mm: float = 1.5) -> list[Film]:
    """Ellipses that bend differently: contraction, director, thickness and modulus of each are its own."""
    made = film(ellipse(9.0, 6.0), edge_mm, contraction=0.15, direction=azimuthal)
    return [
        replace(
            made,
            contraction=made.contraction * (0.7 + 0.2 * number),
            director_rad=made.director_rad + 0.2 * number,
            layer_thickness_mm=made.layer_thickness_mm * (1.0 + 0.05 * number),
            modulus_ratio=np.array([1.0, 1.0, 1.0, 1.0 + 0.1 * number]),
        )
        for number in range(count)
    ]


def test_worlds_evaluated_in_one_launch_are_those_of_single_shells():
    rng = np.random.default_rng(0)
    shell, state = random_film(rng, loads=LOADS)
    worlds = Worlds(shell.film, loads=LOADS, device=open_device("cpu"), count=4, threads=3)
    films = {number: replace(shell.film, contraction=shell.film.contraction * 0.3 * number) for number in (0, 2, 3)}
    states = {
        number: State(
            vertices_mm=state + 0.01 * rng.normal(size=state.shape),
            rest=rest_state(made, 0.8),
            weight=np.full(len(state), 1e-5 * (1 + number)),
        )
        for number, made in films.items()
    }
    for want in (Want(), Want(order=1), Want(order=2), Want(order=2, clamp=True), Want(order=2, loaded=False)):
        found = worlds.evaluate(want, states)
        for number, made in films.items():
            alone = Shell(made, loads=replace(LOADS, weight=1e-5 * (1 + number)), device="cpu")
            alone.set_activation(0.8)
            shape = states[number].vertices_mm
            if want.order == 0:
                assert found[number].energy == alone.energy(shape)
            elif want.order == 1:
                np.testing.assert_array_equal(found[number].gradient, alone.gradient(shape)[1])
            elif want.loaded:
                np.testing.assert_array_equal(found[number].hessian, alone.hessian(shape, clamp=want.clamp)[2])
            else:
                np.testing.assert_array_equal(found[number].hessian, alone.elastic_hessian(shape))


@pytest.mark.parametrize(
    "options",
    [
        PredictOptions(support="free", device="cpu"),
        PredictOptions(device="cpu"),
        PredictOptions(device="cpu", temperature_field=TemperatureGapModel()),
    ],
    ids=["free", "plate", "gap model"],
)
def test_films_heated_together_are_those_heated_alone(options, monkeypatch):
    monkeypatch.setattr("twin.predict.COARSEST_TRIANGLES", 35)  # so that coarse and fine meshes mix
    films = different_films(4)
    assert len(films[0].triangles) > 4 * 35
    for together, made in zip(heat_films(films, options, lanes=3), films, strict=True):
        alone = heat_film(made, options)
        np.testing.assert_allclose(together.hot_mm, alone.hot_mm, atol=1e-6)
        assert together.energy_mj == pytest.approx(alone.energy_mj, rel=1e-9)
        assert together.stable
        assert together.film is made


def test_a_shape_does_not_depend_on_the_other_films():
    films = different_films(5)
    options = PredictOptions(device="cpu")
    all_of_them = heat_films(films, options, lanes=5)
    alone = heat_films(films[3:4], options)
    other_lane = heat_films(films[:1:-1], options, lanes=2)
    np.testing.assert_allclose(alone[0].hot_mm, all_of_them[3].hot_mm, atol=1e-9)
    np.testing.assert_allclose(other_lane[1].hot_mm, all_of_them[3].hot_mm, atol=1e-9)


def test_films_that_ask_while_the_device_is_busy_share_the_next_launch(monkeypatch):
    sizes, evaluate = [], Worlds.evaluate

    def slow(self, want, states):
        sizes.append(len(states))
        time.sleep(0.2)
        return evaluate(self, want, states)

    monkeypatch.setattr(Worlds, "evaluate", slow)
    gathering, energies = Gathering(lanes=4, servers=1), {}

    def ask(lane: int, made: Film) -> None:
        with living_in(lambda film, loads, device, threads: gathering.world(lane, film, loads, device)):
            shell = Shell(made, device="cpu")
        shell.set_activation(1.0)
        energies[lane] = shell.energy(np.column_stack((made.flat_mm, np.zeros(len(made.flat_mm)))))

    films = different_films(4)
    threads = [threading.Thread(target=ask, args=pair) for pair in enumerate(films)]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    assert sum(sizes) == 4
    assert max(sizes) > 1
    assert len(set(energies.values())) == 4


def test_results_come_in_the_order_of_the_jobs_and_progress_counts_them():
    shares = []
    jobs = [lambda number=number: time.sleep(0.02 * (3 - number)) or number for number in range(4)]
    assert run_together(jobs, lanes=4, progress=lambda stage, share: shares.append(share)) == [0, 1, 2, 3]
    assert shares == [0.25, 0.5, 0.75, 1.0]
    assert run_together([], device="cpu") == []


def test_errors_say_which_film(monkeypatch):
    films = different_films(3)

    def fail(made: Film, options: PredictOptions) -> None:
        if made is films[1]:
            raise SolverError("no equilibrium")

    monkeypatch.setattr("twin.batch.heating.heat_film", fail)
    with pytest.raises(SolverError, match="film 2 of 3: no equilibrium"):
        heat_films(films)
    with pytest.raises(InputError, match="number 2 has another mesh"):
        heat_films([films[0], film(rectangle(8.0, 8.0), 1.5)])
    with pytest.raises(InputError, match="lanes: found 0"):
        heat_films(films, lanes=0)


@pytest.mark.gpu
def test_films_heated_together_on_a_gpu_are_those_of_the_cpu():
    wp.init()
    if not wp.is_cuda_available():
        pytest.skip("no CUDA device is present")
    films = different_films(4)
    on_gpu, on_cpu = (heat_films(films, PredictOptions(device=device)) for device in ("cuda", "cpu"))
    for one, other in zip(on_gpu, on_cpu, strict=True):
        assert one.device.startswith("cuda")
        assert rigid_distance_mm(one.hot_mm, other.hot_mm) < 1e-4
