"""Bad input: exceptions of fitting classes with clear texts, and an interpreter that lives on."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Any

import argil
import numpy as np
import pytest
from argil import box, circle, cylinder, polygon, slab, sphere

NAN, INF = float("nan"), float("inf")


@pytest.mark.parametrize(
    ("call", "kind", "text"),
    [
        (lambda: sphere(-1), ValueError, "radius: -1"),
        (lambda: sphere(0), ValueError, "radius"),
        (lambda: sphere(NAN), ValueError, "radius: nan"),
        (lambda: sphere(INF), ValueError, "radius: inf"),
        (lambda: sphere("a"), TypeError, "radius"),
        (lambda: sphere(1, (1, 2)), ValueError, "center: expected 3 numbers, not 2"),
        (lambda: sphere(1, 5), TypeError, "center"),
        (lambda: box((1, 0, 1)), ValueError, "half_size"),
        (lambda: box(-1), ValueError, "half_size"),
        (lambda: argil.rounded_box(1, 2), ValueError, "rounding"),
        (lambda: argil.torus(1, -1), ValueError, "minor_radius"),
        (lambda: argil.plane((0, 0, 0)), ValueError, "no direction"),
        (lambda: slab(), ValueError, "at least one"),
        (lambda: slab(z0=1, z1=0), ValueError, "not below"),
        (lambda: argil.rounded_cone(1, 0.2, 0.1), ValueError, "height"),
        (lambda: argil.tetrahedron(-1), ValueError, "r: -1"),
        (lambda: sphere(1).scale(0), ValueError, "by: 0"),
        (lambda: sphere(1).scale((1, 2)), ValueError, "expected 3 numbers"),
        (lambda: sphere(1).translate((NAN, 0, 0)), ValueError, "nan"),
        (lambda: sphere(1).translate((1e9, 0, 0)), ValueError, "1000000000"),
        (lambda: sphere(1).rotate(1, (0, 0, 0)), ValueError, "no direction"),
        (lambda: sphere(1).circular_array(0), ValueError, "count"),
        (lambda: sphere(1).circular_array(2.5), ValueError, "count"),
        (lambda: sphere(1).repeat(-1), ValueError, "spacing"),
        (lambda: sphere(1).repeat(1, -1), ValueError, "count"),
        (lambda: sphere(1).repeat((1, 1, 1), (1, 1)), ValueError, "count"),
        (lambda: sphere(1).shell(0), ValueError, "half_thickness"),
        (lambda: sphere(1).blend(box(1), k=2), ValueError, "from 0 to 1"),
        (lambda: sphere(1).union(box(1), k=-1), ValueError, "k: -1"),
        (lambda: sphere(1).union(box(1), k=1, chamfer=1), ValueError, "exclude"),
        (lambda: sphere(1) | circle(1), TypeError, "SDF2"),
        (lambda: sphere(1) | 3, TypeError, "unsupported"),
        (lambda: sphere(1).bend_linear((0, 0, 0), (0, 0, 0), (1, 0, 0)), ValueError, "coincide"),
        (lambda: sphere(1).bend_linear((0, 0, 0), (1, 0, 0), (1, 0, 0), argil.ease.in_square), ValueError, "step"),
        (lambda: sphere(1).wrap_around(1, 1), ValueError, "coincide"),
        (lambda: cylinder(1).twist(1).mesh(0.1), argil.SceneError, "finite"),
        (lambda: polygon([(0, 0), (1, 0)]), ValueError, "enclose"),
        (lambda: argil.vesica(1, 2), ValueError, "d: 2"),
        (lambda: circle(1).extrude(0), ValueError, "half_depth"),
        (lambda: circle(1).extrude_to(circle(2), -1), ValueError, "h: -1"),
        (lambda: sphere(1).paint("nocolor"), ValueError, "nocolor"),
        (lambda: sphere(1).paint((2, 0, 0)), ValueError, "base_color"),
        (lambda: sphere(1).mesh(0), ValueError, "voxel_size"),
        (lambda: sphere(1).mesh(NAN), ValueError, "voxel_size"),
        (lambda: sphere(1).mesh(1e-9), ValueError, "voxel"),
        (lambda: sphere(1).mesh(100), ValueError, "voxel"),
        (lambda: sphere(1).mesh(samples=0), ValueError, "samples"),
        (lambda: sphere(1).mesh(samples=1e30), ValueError, "samples: 1e+30"),
        (lambda: sphere(1).mesh(0.1, method="abc"), ValueError, "dual contouring"),
        (lambda: sphere(1).mesh(0.1, bounds=((0, 0, 0), (0, 1, 1))), ValueError, "not below"),
        (lambda: sphere(1).mesh(0.1, bounds=3), ValueError, "bounds"),
        (lambda: sphere(1).mesh(0.1, max_triangles=1), ValueError, "max_triangles"),
        (lambda: sphere(1).mesh(0.1, progress=3), TypeError, "progress"),
        (lambda: cylinder(1).mesh(0.1), ValueError, "no end along z"),
        (lambda: argil.plane().mesh(0.1), ValueError, "no end along x and y and z"),
        (lambda: (sphere(1) & sphere(1, (5, 0, 0))).mesh(0.1), ValueError, "empty"),
        (lambda: (sphere(1) & sphere(1, (5, 0, 0))).bounds, ValueError, "empty"),
        (lambda: sphere(1).save("x.abc"), ValueError, "unknown extension"),
        (lambda: sphere(1).save("/nowhere/x.stl"), OSError, "nowhere"),
        (lambda: sphere(1).save("/nowhere/x.vdb"), OSError, "nowhere"),
        (lambda: sphere(1).save("/nowhere/x.json"), OSError, "nowhere"),
        (lambda: sphere(1).save("x.json", wrong=1), TypeError, "wrong"),
        (lambda: sphere(1).render((0, 5)), ValueError, "pixels"),
        (lambda: sphere(1).render((10**6, 10**6)), ValueError, "10000"),
        (lambda: sphere(1).render((8, 8), show="abc"), ValueError, "abc"),
        (lambda: sphere(1).render((8, 8), wrong=1), TypeError, "wrong"),
        (lambda: sphere(1).render((8, 8), camera=(0, 200, 1)), ValueError, "200"),
        (lambda: sphere(1).render((8, 8), samples=1000), ValueError, "1000"),
        (lambda: sphere(1).turntable("x.png"), ValueError, "gif"),
        (lambda: sphere(1).voxels(0), ValueError, "resolution"),
        (lambda: sphere(1).voxels(10**9), ValueError, "resolution"),
        (lambda: sphere(1).bricks(1), ValueError, "resolution"),
        (lambda: argil.load("/nowhere.json"), FileNotFoundError, "nowhere"),
        (lambda: argil.load("/nowhere.obj"), FileNotFoundError, "nowhere"),
        (lambda: argil.text("no such font", "A"), FileNotFoundError, "no such font"),
        (lambda: argil.text(None, "\t"), ValueError, "text"),
        (lambda: argil.image(np.zeros((4, 4))), ValueError, "one color"),
        (lambda: argil.image(np.zeros(4)), ValueError, "shape"),
        (lambda: sphere(1).nothing, AttributeError, "nothing"),
    ],
)
def test_bad_input_has_a_clear_exception(
    call: Callable[[], Any], kind: type[BaseException], text: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    with pytest.raises(kind) as raised:
        call()
    message = str(raised.value)
    assert text in message, message
    assert "internal error" not in message and "panick" not in message
    assert not list(tmp_path.iterdir()), "nothing is left behind"
    # The interpreter lives on.
    assert sphere(1).distance([(2, 0, 0)])[0] == pytest.approx(1)


def test_files_that_are_damaged_name_the_place(tmp_path: Path) -> None:
    scene = tmp_path / "scene.json"
    scene.write_text('{"argil": 1, "brushes": [{"shape": {"type": "sphere", "radius": -2}}]}')
    with pytest.raises(argil.SceneError, match=r"brushes\[0\]\.shape\.radius"):
        argil.load(scene)
    scene.write_text('{"argil": 1, "brushes": [')
    with pytest.raises(argil.SceneError, match=r"scene\.json"):
        argil.Scene.load(scene)
    broken = tmp_path / "broken.vdb"
    broken.write_bytes(b"nothing")
    with pytest.raises(ValueError, match="broken"):
        argil.load(broken)
    with pytest.raises(ValueError, match="broken"):
        (tmp_path / "broken.stl").write_bytes(b"solid")
        argil.load(tmp_path / "broken.stl")


def test_an_existing_file_stays_until_the_new_one_is_whole(tmp_path: Path) -> None:
    path = tmp_path / "x.stl"
    path.write_text("precious")
    with pytest.raises(ValueError):
        cylinder(1).save(path)
    assert path.read_text() == "precious"
    assert issubclass(argil.SceneError, ValueError)
