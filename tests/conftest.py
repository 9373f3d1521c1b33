"""Fixtures that every room's tests may use."""

import os
from pathlib import Path

import pytest
from hypothesis import settings

# numpy's threads help no matrix of these tests, and on busy cores they wait for each other most of the time
os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")

# the same examples each time: a failure in CI is one that can be repeated
settings.register_profile("repeatable", derandomize=True)
settings.load_profile("repeatable")

SHARED = Path(__file__).resolve().parents[2] / "shared"


@pytest.fixture(scope="session")
def shared_dir() -> Path:
    """Folder of reference data beside the project; the test is skipped where it is absent."""
    if not SHARED.is_dir():
        pytest.skip("the folder ../shared of reference data is absent")
    return SHARED


def pytest_addoption(parser: pytest.Parser) -> None:
    parser.addoption(
        "--regen", action="store_true", help="write the numbers found into the built-in cases instead of testing them"
    )


@pytest.fixture
def regen(request: pytest.FixtureRequest) -> bool:
    """Whether expected numbers are to be written anew instead of tested."""
    return request.config.getoption("--regen")
