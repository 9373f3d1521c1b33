"""The force on the film: friction, lag and noise against closed forms."""

from math import exp

import numpy as np
import pytest

from rig.transport import SimulatedTransport, VirtualClock
from rig.virtual.new_era import VirtualPump
from rig.virtual.post import PostQuality, VirtualPost

PERFECT = PostQuality(friction_g=0.0, lag_s=0.0, noise_g=0.0)


def post(water_g, quality: PostQuality, seed: int = 0) -> VirtualPost:
    return VirtualPost(water_g, np.random.default_rng(seed), quality=quality)


def test_a_perfect_post_presses_with_its_water() -> None:
    made = post(lambda now_s: 0.1 * now_s, PERFECT)
    assert [made.force_g(t) for t in (0.0, 1.0, 50.0)] == [0.0, 0.1, 5.0]


def test_loading_and_unloading_differ_by_twice_the_friction() -> None:
    quality = PostQuality(friction_g=0.25, lag_s=0.0, noise_g=0.0)
    made = post(lambda now_s: now_s if now_s < 6 else 12 - now_s, quality)
    force = [made.force_g(0.5 * k) for k in range(24)]
    assert force[8] == pytest.approx(4.0 - 0.25)
    assert force[16] == pytest.approx(4.0 + 0.25)


def test_the_force_follows_a_step_with_its_lag() -> None:
    made = post(lambda now_s: 0.0 if now_s == 0 else 2.0, PostQuality(friction_g=0.0, lag_s=0.5, noise_g=0.0))
    for k in range(1, 50):
        assert made.force_g(0.1 * k) == pytest.approx(2 * (1 - exp(-0.1 * k / 0.5)))


def test_noise_has_its_size_and_memory_and_its_seed() -> None:
    quality = PostQuality(friction_g=0.0, lag_s=0.0, noise_g=0.05, noise_time_s=0.1)
    made, again = (post(lambda _: 3.0, quality, seed=7) for _ in range(2))
    force = np.array([made.force_g(0.02 * k) for k in range(20_000)])
    assert force.std() == pytest.approx(0.05, rel=0.1)
    off = force - force.mean()
    assert (off[5:] * off[:-5]).mean() / off.var() == pytest.approx(exp(-1), abs=0.06)  # 5 looks are 0.1 s
    assert [again.force_g(0.02 * k) for k in range(50)] == list(force[:50])


def test_a_post_cannot_pull() -> None:
    made = post(lambda _: 0.0, PostQuality(noise_g=1.0))
    assert min(made.force_g(0.1 * k) for k in range(200)) == 0.0


def test_the_pumps_water_reaches_the_film() -> None:
    pump, clock = VirtualPump(diameter_mm=15.9), VirtualClock()
    line = SimulatedTransport(pump, clock)
    pump.alarm = None
    made = VirtualPost(pump.water_ml, np.random.default_rng(0), quality=PERFECT)
    for word in (b"PHN1\r", b"FUNRAT\r", b"RAT6.0MM\r", b"VOL1.0\r", b"DIRINF\r", b"RUN\r"):
        line.write(word)
        line.read(1.0)
    started_s = clock.now_s()
    clock.sleep(5.0)
    # 0.1 mL/s behind a lag of 0.3 s; it was started an answer ago
    assert made.force_g(clock.now_s()) == pytest.approx(0.5 - 0.03, abs=0.005)
    assert made.force_g(started_s + 60.0) == pytest.approx(1.0, abs=0.001)
    assert made.mean_force_g(started_s + 60.0, started_s + 70.0) == pytest.approx(1.0, abs=0.001)
