"""Shared by all tests: scenes and renderers, made once, under Vulkan's validation layers."""

import os
from pathlib import Path

os.environ.setdefault("LATELIGHT_VALIDATION", "1")

import numpy as np
import pytest

pytest.register_assert_rewrite("model_checks", "usd_stages")

import latelight


def pytest_collection_modifyitems(items):
    """Keeps every Nth test, where `./dev test` runs them in part (tests/in_part)."""
    items[:] = items[int(os.environ.get("GTEST_SHARD_INDEX", 0)) :: int(os.environ.get("GTEST_TOTAL_SHARDS", 1))]


DEVICE = os.environ.get("LATELIGHT_TEST_DEVICE", "cpu")


@pytest.fixture(scope="session")
def boxes():
    return latelight.Scene("builtin:boxes")


@pytest.fixture(scope="session")
def renderer(boxes):
    return latelight.Renderer(boxes, DEVICE)


@pytest.fixture(autouse=True)
def no_validation_messages(renderer):
    yield
    assert renderer.validation_messages() == []


@pytest.fixture
def device():
    return DEVICE


@pytest.fixture
def model():
    """The path of a model of the machine's; skips aloud where there is none."""

    def find(name):
        for folder in ("../shared/models", "../../shared/models"):
            path = Path(__file__).parents[2] / folder / name
            if path.exists():
                return str(path)
        pytest.skip(f"there is no model {name}")

    return find


@pytest.fixture
def square():
    """Arrays of a square two meters wide that faces +Z, its texture upright."""
    return {
        "positions": np.array([[-1, -1, 0], [1, -1, 0], [1, 1, 0], [-1, 1, 0]], np.float32),
        "normals": np.tile(np.array([0, 0, 1], np.float32), (4, 1)),
        "uv": np.array([[0, 1], [1, 1], [1, 0], [0, 0]], np.float32),
        "indices": np.array([[0, 1, 2], [0, 2, 3]]),
    }


@pytest.fixture
def stage():
    """An empty stage of USD, in centimeters with Z up."""
    Usd, UsdGeom = pytest.importorskip("pxr.Usd"), pytest.importorskip("pxr.UsdGeom")
    made = Usd.Stage.CreateInMemory()
    UsdGeom.SetStageUpAxis(made, UsdGeom.Tokens.z)
    UsdGeom.SetStageMetersPerUnit(made, 0.01)
    return made
