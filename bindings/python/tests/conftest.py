"""What the tests share."""

from __future__ import annotations

import importlib
import os
import sys
from pathlib import Path
from types import ModuleType

import numpy as np
import pytest


@pytest.fixture
def rng() -> np.random.Generator:
    return np.random.default_rng(7)


@pytest.fixture(scope="session")
def fogleman() -> ModuleType:
    """fogleman/sdf itself, whose folder ARGIL_FOGLEMAN names: the tests that compare with it are skipped without."""
    folder = os.environ.get("ARGIL_FOGLEMAN")
    if not folder or not (Path(folder) / "sdf" / "d3.py").exists():
        pytest.skip("ARGIL_FOGLEMAN names no folder with fogleman/sdf")
    sys.path.insert(0, folder)
    try:
        return importlib.import_module("sdf")
    finally:
        sys.path.remove(folder)
