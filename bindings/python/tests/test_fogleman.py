"""Values against fogleman/sdf itself, at a million points for each of its shapes and operators."""

from __future__ import annotations

from pathlib import Path
from types import ModuleType

import argil
import cases
import numpy as np
import pytest

COUNT = 1_000_000


def points(count: int = COUNT) -> np.ndarray:
    return np.random.default_rng(3).uniform(-1.5, 1.5, (count, 3))


def theirs(fogleman: ModuleType, make: cases.Make, at: np.ndarray) -> np.ndarray:
    return np.concatenate([make(fogleman)(part).reshape(-1) for part in np.array_split(at, 20)])


@pytest.mark.parametrize("name", [*cases.SHAPES, *cases.OPERATORS])
def test_distances_are_theirs(fogleman: ModuleType, name: str) -> None:
    make = (cases.SHAPES | cases.OPERATORS)[name]
    at = points()
    expected, found = theirs(fogleman, make, at), make(argil).distance(at)
    # Single precision, and a root of squares near 0.
    assert np.abs(found - expected).max() < 2e-5, np.abs(found - expected).max()


@pytest.mark.parametrize("name", [*cases.SURFACES, *cases.DEFORMATIONS])
def test_surfaces_are_theirs(fogleman: ModuleType, name: str) -> None:
    make = (cases.SURFACES | cases.DEFORMATIONS)[name]
    at = points()
    expected, found = theirs(fogleman, make, at), make(argil).distance(at)
    differs = (expected < 0) != (found < 0)
    # Where signs differ, both are nearly 0.
    assert np.abs(expected[differs]).max(initial=0) < 1e-3
    assert np.abs(found[differs]).max(initial=0) < 1e-3
    assert differs.mean() < 1e-4
    assert (expected < 0).any() and (expected > 0).any()


@pytest.mark.parametrize("name", argil.ease.__all__)
def test_easing_functions_are_theirs(fogleman: ModuleType, name: str) -> None:
    t = np.linspace(0, 1, 1001)
    expected, found = getattr(fogleman.ease, name)(t), getattr(argil.ease, name)(t)
    assert np.abs(np.asarray(found) - expected).max() < 1e-9


RECORDED = np.load(Path(__file__).with_name("fogleman.npz"))


@pytest.mark.parametrize("name", [*cases.SHAPES, *cases.OPERATORS])
def test_distances_are_those_recorded(name: str) -> None:
    found = (cases.SHAPES | cases.OPERATORS)[name](argil).distance(RECORDED["points"])
    assert np.abs(found - RECORDED[name]).max() < 2e-5


@pytest.mark.parametrize("name", [*cases.SURFACES, *cases.DEFORMATIONS])
def test_surfaces_are_those_recorded(name: str) -> None:
    expected = RECORDED[name]
    found = (cases.SURFACES | cases.DEFORMATIONS)[name](argil).distance(RECORDED["points"])
    clear = np.abs(expected) > 1e-3
    assert np.array_equal((expected < 0)[clear], (found < 0)[clear])
