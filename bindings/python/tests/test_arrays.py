"""Arrays of all shapes, strides and types, and what is no array."""

from __future__ import annotations

from typing import Any

import argil
import hypothesis.extra.numpy as npst
import hypothesis.strategies as st
import numpy as np
import pytest
from hypothesis import given, settings

SOLID = argil.sphere(1) - argil.box(1.2)


@settings(max_examples=150, deadline=None)
@given(
    npst.arrays(
        st.sampled_from([np.float16, np.float32, np.float64, np.int8, np.int32, np.uint64, np.bool_, ">f4", ">f8"]),
        npst.array_shapes(min_dims=0, max_dims=4, min_side=0, max_side=5),
    )
)
def test_arrays_give_distances_or_a_clear_error(array: np.ndarray[Any, Any]) -> None:
    fits = array.ndim == 2 and array.shape[1] == 3 or array.shape == (0,)
    if not fits:
        with pytest.raises(ValueError, match=r"points: expected shape \(N, 3\)"):
            SOLID.distance(array)
        return
    found = SOLID.distance(array)
    assert found.shape == (len(array),) and found.dtype == np.float32
    with np.errstate(all="ignore"):
        plain = np.ascontiguousarray(array.astype(np.float64)).reshape(-1, 3)
    same = SOLID.distance(plain)
    assert np.array_equal(found, same, equal_nan=True)
    assert SOLID.gradient(array).shape == (len(found), 3)


@settings(max_examples=100, deadline=None)
@given(st.integers(0, 40), st.integers(1, 3), st.integers(-3, 3).filter(bool), st.booleans(), st.booleans())
def test_strides_do_not_matter(count: int, step: int, way: int, fortran: bool, single: bool) -> None:
    kind = np.float32 if single else np.float64
    base = np.random.default_rng(count).normal(size=(count * step * 3 + 3, 6)).astype(kind)
    if fortran:
        base = np.asfortranarray(base)
    view = base[::step, ::2][::way][:count]
    assert np.array_equal(SOLID.distance(view), SOLID.distance(np.array(view, order="C")))


def test_nothing_else_is_taken_for_points() -> None:
    for wrong in ("abc", [["a", "b", "c"]], np.array([[None, 1, 2]], dtype=object), np.zeros((2, 3), complex)):
        with pytest.raises((TypeError, ValueError)):
            SOLID.distance(wrong)
    with pytest.raises(ValueError, match="shape"):
        SOLID.distance(np.zeros((3, 2)))


def test_points_that_are_no_numbers_have_far_distances_and_harm_nothing() -> None:
    at = np.array([[np.nan, 0, 0], [np.inf, 0, 0], [0, -np.inf, 0], [1e30, 0, 0], [2, 0, 0]])
    found = SOLID.distance(at)
    assert found[-1] == pytest.approx(1, abs=1e-5)
    assert np.isnan(found[0]) and np.all(found[1:4] > 1e6) and np.isnan(SOLID.gradient(at)[0]).all()
    near, distance = SOLID.closest_point(at[:1])
    assert np.isnan(near).all() and np.isnan(distance).all()
    assert np.isinf(SOLID.cast_rays(at[:1], at[-1:])[0]).all()
    assert np.isinf(SOLID.cast_rays([(0, 0, 5)], [(0, 0, 0)])[0]).all()


def test_arrays_are_read_where_they_are() -> None:
    at = np.zeros((100, 3), dtype=np.float32)
    kept = at.copy()
    at.setflags(write=False)
    SOLID.distance(at)
    assert np.array_equal(at, kept)
    from argil._arrays import as_points

    assert as_points("points", at) is at
    strided = np.zeros((100, 6))[:, ::2]
    assert as_points("points", strided).flags.c_contiguous


def test_dlpack_goes_both_ways() -> None:
    class Tensor:
        """What offers DLPack and nothing else."""

        def __init__(self, array: np.ndarray[Any, Any]) -> None:
            self.array = array

        def __dlpack__(self, **options: Any) -> Any:
            return self.array.__dlpack__(**options)

        def __dlpack_device__(self) -> Any:
            return self.array.__dlpack_device__()

    at = np.random.default_rng(1).normal(size=(50, 3)).astype(np.float32)
    assert np.array_equal(SOLID.distance(Tensor(at)), SOLID.distance(at))  # type: ignore[arg-type]
    out = SOLID.distance(at)
    assert np.shares_memory(np.from_dlpack(out), out)
    mesh = argil.sphere(1).mesh(0.2)
    assert np.from_dlpack(mesh.vertices).shape == mesh.vertices.shape


def test_other_functions_refuse_arrays_that_do_not_fit_together() -> None:
    with pytest.raises(ValueError, match="2 origins and 3 directions"):
        SOLID.cast_rays(np.zeros((2, 3)), np.ones((3, 3)))
    with pytest.raises(ValueError, match="index"):
        argil.Mesh.from_arrays(np.zeros((3, 3)), [[0, 1, 7]])
    with pytest.raises(ValueError, match="integers"):
        argil.Mesh.from_arrays(np.zeros((3, 3)), [[0.0, 1.0, 2.0]])
