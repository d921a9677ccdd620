"""Letters of fonts as profiles."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import argil
import numpy as np
import pytest
from fonts import Polygon, font


def test_letters_are_as_large_as_they_say() -> None:
    letters = argil.text(None, "Hello, world!", width=4)
    (x0, y0), (x1, y1) = letters.bounds
    assert (x1 - x0, -x0) == pytest.approx((4, 2), abs=0.08)
    assert argil.measure_text(None, "Hello, world!", width=4) == pytest.approx((x1 - x0, y1 - y0), abs=0.08)
    # An o has a hole, and is upright and not mirrored: L is heavier below and at the left.
    ring = argil.text(None, "o", height=1).extrude(0.2)
    assert ring.distance([(0, 0, 0)])[0] > 0.1
    angle = argil.text(None, "L", height=1)
    center = angle.extrude(0.2).center_of_mass()
    assert center[0] < -0.05 and center[1] < -0.05
    assert angle.distance(np.array([(-0.9 * 0.5 * argil.measure_text(None, "L")[0], 0.3)]))[0] < 0.05


def test_fonts_of_the_system_have_letters() -> None:
    from argil._outlines import _FOLDERS

    fonts = [path for folder in _FOLDERS for path in Path(folder).expanduser().rglob("*.ttf")]
    if not fonts:
        pytest.skip("no font is installed")
    own = argil.text(str(fonts[0]), "o", height=1)
    assert (own.bounds[1][1] - own.bounds[0][1]) == pytest.approx(1, abs=0.04)
    assert own.extrude(0.2).mesh(0.05).is_watertight


def _square(half: int, clockwise: bool = True) -> Polygon:
    low, high = 500 - half, 500 + half
    corners = [(low, low), (low, high), (high, high), (high, low)]
    return corners if clockwise else corners[::-1]


def _bar(x: tuple[int, int], y: tuple[int, int]) -> Polygon:
    return [(x[0], y[0]), (x[0], y[1]), (x[1], y[1]), (x[1], y[0])]


# Letters as fonts draw them, with their areas in ems.
LETTERS: dict[str, tuple[list[Polygon], float]] = {
    "c in a ring": ([_square(400), _square(300, False), _square(100)], 0.64 - 0.36 + 0.04),
    "r in a ring": (
        [_square(500), _square(450, False), _square(300), _square(100, False)],
        1 - 0.81 + 0.36 - 0.04,
    ),
    "nested six deep": ([_square(75 * (6 - i), i % 2 == 0) for i in range(6)], 0.15**2 * (36 - 25 + 16 - 9 + 4 - 1)),
    "a stroke across a hole": ([_square(400), _square(300, False), _bar((100, 900), (450, 550))], 0.28 + 0.06),
    "strokes that cross": ([_bar((100, 900), (450, 550)), _bar((450, 550), (100, 900))], 0.15),
    "strokes that overlap": ([_bar((100, 600), (0, 500)), _bar((400, 900), (0, 500))], 0.4),
    "counterclockwise": ([_square(400, False), _square(300), _square(100, False)], 0.64 - 0.36 + 0.04),
}


def _area(profile: Any, half: float) -> float:
    ticks = (np.arange(400) + 0.5) / 400 * 2 * half - half
    points = np.stack(np.meshgrid(ticks, ticks), axis=-1).reshape(-1, 2)
    return float((profile.distance(points) < 0).mean()) * (2 * half) ** 2


def test_letters_keep_islands_and_crossing_strokes(tmp_path: Path) -> None:
    path = tmp_path / "polygons.ttf"
    names = dict(zip("ABCDEFG", LETTERS, strict=True))
    path.write_bytes(font({letter: LETTERS[name][0] for letter, name in names.items()}))
    for letter, name in names.items():
        polygons, area = LETTERS[name]
        xs, ys = zip(*(point for polygon in polygons for point in polygon), strict=True)
        size = (max(xs) - min(xs)) / 1000, (max(ys) - min(ys)) / 1000
        profile = argil.text(str(path), letter, width=size[0])
        assert argil.measure_text(str(path), letter, width=size[0]) == pytest.approx(size, abs=1e-4), name
        assert _area(profile, 0.6) == pytest.approx(area, abs=0.012), name
