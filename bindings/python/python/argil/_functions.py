"""Python functions as solids.

A function of points becomes a brush by sampling: between samples, its distances are interpolated. What the sampling assumes is
told by `repr` and by `SampledSDF3.sampling`.
"""

from __future__ import annotations

import functools
import warnings
from collections.abc import Callable
from typing import TYPE_CHECKING, Any, NamedTuple, ParamSpec, TypeVar, overload

from . import _native, _output, _sdf2, _sdf3
from ._arrays import as_points
from ._numbers import ENDLESS, modified
from ._sdf2 import SDF2
from ._sdf3 import SDF3, Box

if TYPE_CHECKING:
    import numpy as np
    from numpy.typing import ArrayLike, NDArray

F = TypeVar("F", bound=Callable[..., Any])
P = ParamSpec("P")


class SamplingWarning(UserWarning):
    """A function was sampled that is steeper than stated, so that its distances are not bounds."""


class Sampling(NamedTuple):
    """How a function became a brush."""

    #: The box outside of which the solid is cut off.
    bounds: Box
    #: Samples along the longest side of the box.
    resolution: int
    #: The distance between samples. Details that are smaller are lost.
    spacing: float
    #: The slope by which the function's values were divided, so that they are bounds of the distance.
    lipschitz: float
    #: Whether that slope was measured between samples, and not stated.
    is_measured: bool


def _values(function: Callable[[Any], Any], points: NDArray[Any]) -> NDArray[np.float64]:
    import numpy as np

    found = np.asarray(function(points), dtype=np.float64).reshape(-1)
    if len(found) != len(points):
        raise ValueError(f"the function returned {len(found)} values for {len(points)} points: expected one distance per point")
    return np.ascontiguousarray(found)


def _estimated_bounds(function: Callable[[Any], Any], axes: int) -> Box:
    """Shrinks a box around the places where the function is nearer to 0 than the box's parts are large."""
    import numpy as np

    count = 16 if axes == 3 else 64
    low, high = np.full(3, -1e4), np.full(3, 1e4)
    low[axes:], high[axes:] = -1.0, 1.0
    for _ in range(40):
        places = [np.linspace(low[i], high[i], count) for i in range(axes)]
        step = np.array([p[1] - p[0] for p in places])
        points = np.stack(np.meshgrid(*places, indexing="ij"), axis=-1).reshape(-1, axes)
        values = _values(function, points).reshape([count] * axes)
        slopes = [np.abs(np.diff(values, axis=axis)).max() / step[axis] for axis in range(axes)]
        steepest = max(1.0, float(np.nanmax(slopes)) if np.isfinite(slopes).any() else 1.0)
        near = np.argwhere(np.abs(values) <= 1.1 * steepest * np.linalg.norm(step) / 2)
        if not len(near):
            break
        first, last = near.min(axis=0), near.max(axis=0)
        if np.any((first == 0) & (low[:axes] <= -9e3)) or np.any((last == count - 1) & (high[:axes] >= 9e3)):
            if np.abs(low[:axes]).max() > 9e3 and near.size and (last - first).max() >= count - 2:
                raise ValueError("the function has no end that could be found: pass bounds=((x0, y0, z0), (x1, y1, z1))")
        new_low, new_high = low.copy(), high.copy()
        new_low[:axes] = low[:axes] + (first - 0.5) * step
        new_high[:axes] = low[:axes] + (last + 0.5) * step
        shrunk = np.prod(new_high[:axes] - new_low[:axes]) / np.prod(high[:axes] - low[:axes])
        low, high = new_low, new_high
        if shrunk > 0.8:
            break
    return tuple(map(float, low)), tuple(map(float, high))  # type: ignore[return-value]


def _measured_slope(function: Callable[[Any], Any], bounds: Box, axes: int) -> float:
    """Returns the largest slope between neighbors of a coarse grid, and at a small step from each."""
    import numpy as np

    count = 24 if axes == 3 else 128
    low, high = (np.array(corner[:axes]) for corner in bounds)
    places = [np.linspace(low[i], high[i], count) for i in range(axes)]
    points = np.stack(np.meshgrid(*places, indexing="ij"), axis=-1).reshape(-1, axes)
    values = _values(function, points)
    step = 1e-4 * float((high - low).max())
    squares = np.zeros(len(points))
    for axis in range(axes):
        moved = points.copy()
        moved[:, axis] += step
        squares += ((_values(function, moved) - values) / step) ** 2
    finite = squares[np.isfinite(squares)]
    return float(np.sqrt(finite.max())) if len(finite) else 1.0


class _Sampled:
    """What sampled solids of two and three dimensions have in common."""

    _function: Callable[[Any], Any]
    _axes: int
    _options: tuple[Box | None, int, float | None]
    _sampling: Sampling | None
    _lazy_node: _native.Node | None

    def _take(self, function: Callable[[Any], Any], axes: int, bounds: Any, resolution: int, lipschitz: float | None) -> None:
        if not callable(function):
            raise TypeError(f"expected a function of points, not {function!r}")
        if bounds is not None and axes == 2:
            bounds = [[*corner, side] for corner, side in zip(bounds, (-1.0, 1.0), strict=True)]
        self._function = function
        self._axes = axes
        box = _output.checked_box(bounds)
        self._options = (None if box is None else (tuple(box[0]), tuple(box[1])), int(resolution), lipschitz)  # type: ignore[assignment]
        self._sampling = None

    @property
    def _node(self) -> _native.Node:
        if self._lazy_node is None:
            self._lazy_node, self._sampling = self._sampled()
        return self._lazy_node

    def _sampled(self) -> tuple[_native.Node, Sampling]:
        function, axes = self._function, self._axes
        bounds, resolution, stated = self._options
        box = bounds or _estimated_bounds(function, axes)
        measured = _measured_slope(function, box, axes)
        slope = stated if stated is not None else max(1.0, 1.05 * measured)
        if axes == 2:
            # A thin layer, which the profile is the section of.
            size = max(box[1][0] - box[0][0], box[1][1] - box[0][1])
            thin = 4.0 * size / max(resolution, 1)
            (x0, y0, _), (x1, y1, _) = box
            # Python's y is the profile's, which lies in the scene's x-y plane.
            sampled_box: Any = ((x0, -thin, y0), (x1, thin, y1))

            def call(points: Any) -> Any:
                return _values(function, points[:, [0, 2]])
        else:
            sampled_box = box

            def call(points: Any) -> Any:
                return _values(function, points)

        node, spacing, steepest = _native.sample_function(call, sampled_box, resolution, slope, None)
        # Between samples, a function of slope 1 is up to √3 steep.
        if measured > 1.01 * slope or steepest > 1.8:
            steep = max(measured, steepest * slope / 3**0.5)
            warnings.warn(
                f"the function is {steep:.3g} steep where it was looked at, and not {slope:.3g}: "
                "pass a larger lipschitz= to keep its distances bounds",
                SamplingWarning,
                stacklevel=4,
            )
        if axes == 2:
            node = modified(node, "extrude", half_depth=ENDLESS)
        return node, Sampling(box, resolution, spacing, slope, stated is None)

    @property
    def sampling(self) -> Sampling:
        """How the function became a brush. It is sampled when it is first combined or asked."""
        _ = self._node
        assert self._sampling is not None
        return self._sampling


class SampledSDF3(_Sampled, SDF3):
    """A solid by a Python function of points: see `sdf3`."""

    __slots__ = ("_axes", "_function", "_options", "_sampling")

    def __init__(
        self,
        function: Callable[[Any], Any],
        *,
        bounds: Box | None = None,
        resolution: int = 128,
        lipschitz: float | None = None,
    ) -> None:
        SDF3.__init__(self, None)
        self._take(function, 3, bounds, resolution, lipschitz)

    def _of(self, node: _native.Node) -> SDF3:  # type: ignore[override]
        return SDF3(node)

    def __call__(self, points: ArrayLike) -> NDArray[np.float64]:
        """Returns the function's own values, of shape (N, 1)."""
        return _values(self._function, as_points("points", points)).reshape(-1, 1)

    def __repr__(self) -> str:
        if self._sampling is None:
            return "<argil.SDF3 of a Python function, not sampled yet>"
        own = self._sampling
        how = "measured" if own.is_measured else "stated"
        return (
            f"<argil.SDF3 of a Python function, sampled every {own.spacing:.4g} ({own.resolution} along the longest side), "
            f"slope {own.lipschitz:.3g} {how}>"
        )


class SampledSDF2(_Sampled, SDF2):
    """A profile by a Python function of points: see `sdf2`."""

    __slots__ = ("_axes", "_function", "_options", "_sampling")

    def __init__(
        self,
        function: Callable[[Any], Any],
        *,
        bounds: Any = None,
        resolution: int = 256,
        lipschitz: float | None = None,
    ) -> None:
        SDF2.__init__(self, None)
        self._take(function, 2, bounds, resolution, lipschitz)

    def _of(self, node: _native.Node) -> SDF2:  # type: ignore[override]
        return SDF2(node)

    def __call__(self, points: ArrayLike) -> NDArray[np.float64]:
        """Returns the function's own values, of shape (N, 1)."""
        return _values(self._function, as_points("points", points, 2)).reshape(-1, 1)

    def __repr__(self) -> str:
        if self._sampling is None:
            return "<argil.SDF2 of a Python function, not sampled yet>"
        own = self._sampling
        return f"<argil.SDF2 of a Python function, sampled every {own.spacing:.4g}>"


def _maker(kind: type, function: Any, options: dict[str, Any]) -> Any:
    def decorate(make: Callable[..., Any]) -> Callable[..., Any]:
        @functools.wraps(make)
        def wrapper(*arguments: Any, **named: Any) -> Any:
            made = make(*arguments, **named)
            return made if isinstance(made, (SDF2, SDF3)) else kind(made, **options)

        return wrapper

    return decorate if function is None else decorate(function)


@overload
def sdf3(function: Callable[P, Any]) -> Callable[P, SDF3]: ...


@overload
def sdf3(
    *, bounds: Box | None = None, resolution: int = 128, lipschitz: float | None = None
) -> Callable[[Callable[P, Any]], Callable[P, SDF3]]: ...


def sdf3(
    function: Callable[..., Any] | None = None,
    *,
    bounds: Box | None = None,
    resolution: int = 128,
    lipschitz: float | None = None,
) -> Any:
    """Turns a function that returns a function of points into a function that returns solids.

    The inner function takes an array (N, 3) and returns N signed distances, or values nowhere farther from 0. It is sampled
    when the solid is first combined or asked: within `bounds`, or a box that is found by looking for small values; with
    `resolution` samples along its longest side, from 16 to 512. Values are divided by `lipschitz`, the largest slope of the
    function, which is measured if it is not stated: between the places that are looked at, it may be steeper.

    >>> import numpy as np
    >>> from argil import sdf3, SDF3
    >>> @sdf3(bounds=((-1, -1, -1), (1, 1, 1)), lipschitz=1)
    ... def ball(radius):
    ...     return lambda p: np.linalg.norm(p, axis=1) - radius
    >>> round(ball(0.5).volume(), 2)
    0.52
    """
    return _maker(SampledSDF3, function, {"bounds": bounds, "resolution": resolution, "lipschitz": lipschitz})


@overload
def sdf2(function: Callable[P, Any]) -> Callable[P, SDF2]: ...


@overload
def sdf2(
    *, bounds: Any = None, resolution: int = 256, lipschitz: float | None = None
) -> Callable[[Callable[P, Any]], Callable[P, SDF2]]: ...


def sdf2(
    function: Callable[..., Any] | None = None,
    *,
    bounds: Any = None,
    resolution: int = 256,
    lipschitz: float | None = None,
) -> Any:
    """Turns a function that returns a function of points (N, 2) into a function that returns profiles. See `sdf3`."""
    return _maker(SampledSDF2, function, {"bounds": bounds, "resolution": resolution, "lipschitz": lipschitz})


def _operator(kind: type, known: dict[str, Any], function: F, options: dict[str, Any]) -> Any:
    made = _maker(kind, function, options)
    known[function.__name__] = made
    return made


def op3(function: F) -> F:
    """Adds an operator of solids: a function of a solid that returns a function of points. It becomes a method, too.

    The solid is called with arrays (N, 3) and returns (N, 1), as in fogleman/sdf. The result is sampled: see `sdf3`.
    """
    return _operator(SampledSDF3, _sdf3._operators, function, {})


def op2(function: F) -> F:
    """Adds an operator of profiles. See `op3`."""
    return _operator(SampledSDF2, _sdf2._operators, function, {})


def op23(function: F) -> F:
    """Adds an operator that makes a solid of a profile. See `op3`."""
    return _operator(SampledSDF3, _sdf2._operators, function, {})


def op32(function: F) -> F:
    """Adds an operator that makes a profile of a solid. See `op3`."""
    return _operator(SampledSDF2, _sdf3._operators, function, {})
