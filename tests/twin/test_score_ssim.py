import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from twin.score.ssim import ssim_eq4, ssim_eq4_inside, ssim_eq4_map, ssim_eq4_own_scale, ssim_gauss


def literal_eq4(reference, sample, window=9):
    """Eq. 4, one pair of windows after the other, one pixel after the other."""
    total, count = 0.0, 0
    rows, columns = reference.shape
    for i in range(rows - window + 1):
        for j in range(columns - window + 1):
            r = [float(v) for v in reference[i : i + window, j : j + window].ravel()]
            s = [float(v) for v in sample[i : i + window, j : j + window].ravel()]
            if all(v == 0 for v in r) or all(v == 0 for v in s):
                continue
            if len(set(r)) == 1 and len(set(s)) == 1:
                continue
            n = len(r)
            mu_r, mu_s = sum(r) / n, sum(s) / n
            var_r = sum((v - mu_r) ** 2 for v in r) / n
            var_s = sum((v - mu_s) ** 2 for v in s) / n
            cov = sum((a - mu_r) * (b - mu_s) for a, b in zip(r, s, strict=True)) / n
            total += (2 * mu_r * mu_s) * (2 * cov) / ((mu_r**2 + mu_s**2) * (var_r + var_s))
            count += 1
    return total / count if count else 0.0


def blob(rng, shape):
    """A surface of random heights on a random disc, with a constant patch, on background."""
    rows, columns = np.indices(shape)
    centre = rng.uniform(0.3, 0.7, 2) * shape
    inside = np.hypot(rows - centre[0], columns - centre[1]) < rng.uniform(5, 12)
    image = np.where(inside, rng.uniform(1, 255, shape), 0.0)
    image[2:12, 2:12] = 7.3
    return image


@given(seed=st.integers(0, 10_000), window=st.sampled_from([3, 9]))
@settings(max_examples=12, deadline=None)
def test_agrees_with_the_loop_by_loop_transcription(seed, window):
    rng = np.random.default_rng(seed)
    reference, sample = blob(rng, (24, 20)), blob(rng, (24, 20))
    assert ssim_eq4(reference, sample, window) == pytest.approx(literal_eq4(reference, sample, window), abs=1e-10)


def test_smooth_images_of_tiny_relief_agree_too():
    y, x = np.mgrid[0:20, 0:18] / 1e4
    reference, sample = 200 + np.sin(900 * x + y) * 1e-3, 180 + np.cos(700 * y - x) * 1e-3
    assert ssim_eq4(reference, sample) == pytest.approx(literal_eq4(reference, sample), abs=1e-10)


def test_one_window_by_hand():
    # r = (1, 3, 1, 3): mean 2, variance 1; s = 2 r: mean 4, variance 4; covariance 2.
    reference = np.array([[1.0, 3.0], [1.0, 3.0]])
    expected = (2 * 2 * 4) * (2 * 2) / ((4 + 16) * (1 + 4))
    assert ssim_eq4(reference, 2 * reference, window=2) == pytest.approx(expected)
    assert expected == pytest.approx(0.64)


def test_own_scale_removes_gain_and_offset_by_hand():
    reference = np.array([[1.0, 3.0], [1.0, 3.0]])
    assert ssim_eq4_own_scale(reference, 10 + 2 * reference, window=2) == pytest.approx(1.0)
    # Stretched to (1, 255) and (255, 1): mean 128, variance 127^2, covariance -127^2.
    assert ssim_eq4_own_scale(reference, 4 - reference, window=2) == pytest.approx(-1.0)


def test_inside_counts_only_windows_without_background_by_hand():
    # Three windows of 2 x 2: the last one touches the sample's background and is left out.
    reference = np.array([[1.0, 3.0, 1.0, 3.0], [1.0, 3.0, 1.0, 3.0]])
    sample = np.array([[2.0, 6.0, 2.0, 6.0], [2.0, 6.0, 2.0, 0.0]])
    assert ssim_eq4_inside(reference, sample, window=2) == pytest.approx(0.64)
    # s = (2, 6, 2, 0): mean 2.5, variance 4.75; covariance = (1*2 + 3*6 + 1*2 + 3*0)/4 - 2*2.5 = 0.5.
    last = (2 * 2 * 2.5) * (2 * 0.5) / ((4 + 6.25) * (1 + 4.75))
    assert ssim_eq4(reference, sample, window=2) == pytest.approx((0.64 + 0.64 + last) / 3)


def test_gauss_by_hand_for_constant_images():
    # Constant images have no variance: SSIM = (2 a b + c1) / (a^2 + b^2 + c1), c1 = (0.01 * 255)^2.
    a, b, c1 = 100.0, 50.0, (0.01 * 255) ** 2
    value = ssim_gauss(np.full((20, 20), a), np.full((20, 20), b))
    assert value == pytest.approx((2 * a * b + c1) / (a * a + b * b + c1))


@pytest.mark.parametrize("variant", [ssim_eq4, ssim_eq4_inside, ssim_eq4_own_scale, ssim_gauss])
def test_an_image_against_itself_is_one(variant):
    image = blob(np.random.default_rng(1), (40, 40))
    assert variant(image, image) == pytest.approx(1.0, abs=1e-12)


def test_windows_with_one_empty_side_are_not_counted():
    reference, sample = np.zeros((10, 30)), np.zeros((10, 30))
    reference[:, :12] = np.random.default_rng(0).uniform(1, 2, (10, 12))
    sample[:, :12] = reference[:, :12]
    with_more_to_the_right = sample.copy()
    with_more_to_the_right[:, 25:] = 3.0
    assert ssim_eq4(reference, with_more_to_the_right) == pytest.approx(1.0)


def test_no_common_surface_gives_zero():
    assert ssim_eq4(np.zeros((12, 12)), np.ones((12, 12))) == 0.0


def test_map_has_the_windows_centred_and_the_same_mean():
    rng = np.random.default_rng(3)
    reference, sample = blob(rng, (30, 26)), blob(rng, (30, 26))
    image = ssim_eq4_map(reference, sample)
    assert image.shape == reference.shape
    assert np.nanmean(image) == pytest.approx(ssim_eq4(reference, sample))
    assert np.isnan(image[:4]).all()
    window = (slice(10, 19), slice(8, 17))
    assert image[14, 12] == pytest.approx(literal_eq4(reference[window], sample[window]))


def test_images_of_different_shape_are_refused():
    with pytest.raises(ValueError, match="one shape"):
        ssim_eq4(np.ones((12, 12)), np.ones((12, 13)))
