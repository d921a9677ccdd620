"""Scenes, bricks, files, functions, images and pictures."""

from __future__ import annotations

import json
import math
import zipfile
from pathlib import Path

import argil
import numpy as np
import pytest
from argil import SDF3, Scene, box, circle, cylinder, sphere, torus


def points(count: int = 5000) -> np.ndarray:
    return np.random.default_rng(5).uniform(-1.5, 1.5, (count, 3))


def part() -> SDF3:
    return (box((1.4, 1.0, 0.6)) - cylinder(0.3).k(0.05)).paint("gold", metallic=1)


@pytest.mark.parametrize("ending", ["stl", "obj", "ply", "glb", "gltf", "3mf", "vdb", "nvdb", "nrrd"])
def test_files_hold_the_solid_where_it_is(ending: str, tmp_path: Path) -> None:
    solid = part().rotate(0.4, (1, 2, 3)).translate((0.3, 0.1, 0.5))
    path = tmp_path / f"part.{ending}"
    solid.save(path, 0.04)
    assert path.stat().st_size > 1000
    again = argil.load(path, resolution=64)
    at = points(3000)
    expected, found = solid.distance(at), again.distance(at)
    near = np.abs(expected) > 0.05
    assert np.mean((expected < 0)[near] == (found < 0)[near]) > 0.995
    assert [file.name for file in tmp_path.iterdir()] == [path.name]


def test_3mf_files_point_up(tmp_path: Path) -> None:
    corners = np.array([[0, 0, 0], [1, 0, 0], [0, 2, 0], [0, 0, 3]], dtype=np.float32)
    mesh = argil.Mesh.from_arrays(corners, np.array([[0, 2, 1], [0, 1, 3], [1, 2, 3], [2, 0, 3]]))
    mesh.save(tmp_path / "a.3mf")
    with zipfile.ZipFile(tmp_path / "a.3mf") as file:
        text = file.read("3D/3dmodel.model").decode()
    assert 'x="0" y="0" z="3"' in text and 'unit="meter"' in text
    assert argil.Mesh.from_file(tmp_path / "a.3mf").size == pytest.approx((1, 2, 3))


def test_copies_in_one_place_are_a_warning(tmp_path: Path) -> None:
    around = argil.sphere(0.5).circular_array(6)
    with pytest.warns(UserWarning, match="all copies are in one place"):
        assert around.distance([[1.0, 0.0, 0.0]])[0] == pytest.approx(0.5)
    text = '{"argil": 1, "brushes": [{"shape": {"type": "sphere", "radius": 1}, "modifiers": [{"type": "radial_repeat", "count": 6}]}]}'
    (tmp_path / "a.json").write_text(text)
    with pytest.warns(UserWarning, match=r"a.json: brushes\[0\].modifiers\[0\]: all copies"):
        argil.Scene.load(tmp_path / "a.json")


def test_what_a_reader_leaves_out_is_a_warning(tmp_path: Path) -> None:
    corners = "".join(f"v {x} {y} {z}\n" for x, y, z in [(0, 0, 0), (1, 0, 0), (0, 1, 0), (0, 0, 1)])
    (tmp_path / "a.obj").write_text(corners + "f 1 3 2\nf 1 2 4\nf 2 3 4\nf 3 1 4\nl 1 2\n")
    with pytest.warns(UserWarning, match="left out 1 line"):
        assert len(argil.Mesh.from_file(tmp_path / "a.obj")) == 4
    with pytest.warns(UserWarning, match="left out 1 line"):
        argil.load(tmp_path / "a.obj")


def test_scene_files_hold_the_solid_to_the_bit(tmp_path: Path) -> None:
    solid = part().twist(0.4) | sphere(0.2).translate((0, 0, 1)).k(0.1)
    solid.save(tmp_path / "scene.json")
    at = points()
    assert np.array_equal(argil.load(tmp_path / "scene.json").distance(at), solid.distance(at))
    scene = json.loads((tmp_path / "scene.json").read_text())
    assert scene["argil"] == 1 and "gold" not in scene["materials"]
    # y is up in files.
    sphere(0.2).translate((1, 2, 3)).save(tmp_path / "one.json")
    by = json.loads((tmp_path / "one.json").read_text())["brushes"][0]["modifiers"][0]["by"]
    assert by == [1, 3, -2]
    solid.save(tmp_path / "part.argil", 0.05)
    assert np.array_equal(argil.load(tmp_path / "part.argil").distance(at), solid.distance(at))


def test_scenes_change_and_take_it_back() -> None:
    scene = Scene(box(1.0))
    hole = scene.add(cylinder(0.2), "difference", name="hole", k=0.05)
    assert len(scene) == 2 and scene.find("hole") == hole
    before = scene.solid()
    scene.translate(hole, (0.3, 0, 0))
    scene.rotate(hole, math.pi / 2, (1, 0, 0))
    at = points()
    moved = box(1.0) - cylinder(0.2).translate((0.3, 0, 0)).rotate(math.pi / 2, (1, 0, 0)).k(0.05)
    assert np.abs(scene.solid().distance(at) - moved.distance(at)).max() < 1e-5
    assert scene.undo() and scene.undo() and np.array_equal(scene.solid().distance(at), before.distance(at))
    assert scene.redo()
    group = scene.group("intersection", name="limit")
    inner = scene.add(sphere(0.8), parent=group)
    assert scene.info(inner).parent == group and scene.info(inner).path == "brushes[2].brushes[0]"
    scene.paint(hole, "red")
    assert scene.info(hole).material == "red"
    scene.set_visible(group, False)
    assert not scene.info(group).visible
    scene.move(inner, 0)
    assert scene.info(inner).path == "brushes[0]"
    scene.remove(inner)
    with pytest.raises(KeyError):
        scene.info(inner)
    with pytest.raises(KeyError):
        scene.find("nothing")
    with pytest.raises(ValueError, match="operator"):
        scene.add(sphere(1), "wrong")
    other = Scene(sphere(1))
    with pytest.raises(argil.SceneError, match="not in the scene"):
        other.remove(hole)


def test_bricks_follow_edits_and_equal_a_fresh_build() -> None:
    bricks = box((1.0, 1.2, 0.8)).bricks(96)
    size = bricks.memory_bytes
    bricks -= sphere(0.3).translate((0.5, 0.6, 0.4)).k(0.05)
    bricks |= torus(0.3, 0.08).translate((0, 0, 0.4))
    report = bricks.edit(cylinder(0.1), "difference")
    assert not report.rebuilt and report.changed is not None and report.milliseconds > 0
    assert bricks.diff_from_rebuild() == 0
    solid = bricks.scene.solid()
    at = bricks.mesh().vertices
    assert np.abs(solid.distance(at)).max() < 0.5 * bricks.voxel_size
    assert bricks.undo() and bricks.diff_from_rebuild() == 0
    assert bricks.redo() and bricks.memory_bytes > size / 2
    low, high = bricks.bounds
    assert bricks.resolution == tuple(np.round((np.array(high) - low) / bricks.voxel_size).astype(int))
    inside = np.random.default_rng(1).uniform(-0.4, 0.4, (100, 3))
    assert np.all((bricks.distance(inside) < 0) == (solid.distance(inside) < 0))


def test_functions_become_brushes_and_tell_how() -> None:
    @argil.sdf3(bounds=((-1, -1, -1), (1, 1, 1)), lipschitz=1)
    def ball(radius: float) -> object:
        return lambda p: np.linalg.norm(p, axis=1) - radius

    solid = ball(0.7)
    assert "not sampled yet" in repr(solid)
    cut = solid & box(1.0)
    assert solid.sampling.spacing == pytest.approx(2 / 128) and not solid.sampling.is_measured
    assert "stated" in repr(solid)
    exact = sphere(0.7) & box(1.0)
    assert cut.volume() == pytest.approx(exact.volume(), rel=2e-3)

    @argil.sdf3
    def steep(radius: float) -> object:
        return lambda p: 3 * (np.linalg.norm(p, axis=1) - radius)

    measured = steep(0.5)
    assert measured.volume() == pytest.approx(sphere(0.5).volume(), rel=5e-3)
    assert measured.sampling.is_measured and 3 <= measured.sampling.lipschitz < 3.5
    at = points()
    # Divided by its slope, so that it stays a bound.
    assert np.all(np.abs(measured.distance(at)) <= np.abs(sphere(0.5).distance(at)) + 0.02)

    @argil.op3
    def bulged(other: SDF3, by: float) -> object:
        return lambda p: other(p) - by

    grown = sphere(0.5).bulged(0.1)
    assert grown.volume() == pytest.approx(sphere(0.6).volume(), rel=5e-3)

    @argil.sdf2(bounds=((-1, -1), (1, 1)))
    def disc(radius: float) -> object:
        return lambda p: np.linalg.norm(p, axis=1) - radius

    assert disc(0.5).extrude(1).volume() == pytest.approx(math.pi / 4, rel=5e-3)


def test_functions_that_fail_raise_their_own_exception() -> None:
    @argil.sdf3(bounds=((-1, -1, -1), (1, 1, 1)))
    def broken() -> object:
        def f(p: np.ndarray) -> np.ndarray:
            raise ZeroDivisionError("mine")

        return f

    with pytest.raises(ZeroDivisionError, match="mine"):
        broken().mesh(0.1)
    bad = {
        "one distance per point": lambda p: p,
        "finite": lambda p: p[:, 0] * np.nan,
        "nowhere negative": lambda p: 1 + np.abs(p[:, 0]),
    }
    for text, function in bad.items():
        make = argil.sdf3(bounds=((-1, -1, -1), (1, 1, 1)), lipschitz=1)(lambda own=function: own)
        with pytest.raises(ValueError, match=text):
            make().mesh(0.1)
    with pytest.raises(ValueError, match="no end"):
        argil.sdf3(lambda: lambda p: p[:, 2])().mesh(0.1)
    jumps = argil.sdf3(bounds=((-1, -1, -1), (1, 1, 1)), lipschitz=1)(
        lambda: lambda p: np.where(np.linalg.norm(p, axis=1) < 0.5, -0.2, 0.2)
    )
    with pytest.warns(argil.SamplingWarning):
        jumps().mesh(0.1)


def test_bounds_cut_and_close() -> None:
    half = sphere(1).mesh(0.05, bounds=((-2, -2, 0), (2, 2, 2)))
    assert half.is_watertight and half.volume == pytest.approx(2 / 3 * math.pi, rel=0.01)
    assert half.bounding_box[0][2] == pytest.approx(0, abs=0.01)
    pipe = cylinder(1).mesh(0.05, bounds=((-2, -2, -1), (2, 2, 1)))
    assert pipe.is_watertight and pipe.volume == pytest.approx(2 * math.pi, rel=0.01)
    turned = sphere(1)
    for nth in range(12):
        turned = turned.rotate(0.7, (nth % 2, 1, nth % 3))
    assert turned.mesh().volume == pytest.approx(4 / 3 * math.pi, rel=0.01)
    assert box((50, 0.2, 0.2)).volume() == pytest.approx(2, rel=0.05)
    far = sphere(1) | sphere(1).translate((0, 0, 2e4))
    assert far.bounds[1][2] == pytest.approx(20001, rel=1e-3)
    assert sphere(4e4).mesh(samples=1e5).is_watertight
    assert sphere(1).blend(box(1), k=0).volume() == pytest.approx(sphere(1).volume(), rel=0.01)


def test_profiles_are_no_solids() -> None:
    for wrong in (lambda: Scene(circle(1)), lambda: sphere(1).transition_linear(circle(1)), lambda: Scene(5)):  # type: ignore[arg-type]
        with pytest.raises(TypeError):
            wrong()


def test_images_are_profiles() -> None:
    y, x = np.mgrid[0:200, 0:300]
    disc = np.hypot(x - 99.5, y - 49.5) < 40
    profile = argil.image(disc, width=3.0)
    assert argil.measure_image(disc, width=3.0) == (3.0, 2.0)
    (x0, y0), (x1, y1) = profile.bounds
    # Left of the middle and above it, as in the picture.
    assert ((x0 + x1) / 2, (y0 + y1) / 2) == pytest.approx((-0.5, 0.5), abs=0.02)
    assert profile.extrude(1).volume() == pytest.approx(math.pi * 0.16, rel=0.02)
    at = np.random.default_rng(1).uniform((-0.9, 0.1), (-0.1, 0.9), (2000, 2))
    exact = circle(0.4, (-0.5, 0.5)).distance(at)
    assert np.abs(profile.distance(at) - exact)[np.abs(exact) < 0.1].max() < 0.02
    assert np.array_equal(argil.image(disc * 255, 3.0).distance(at), profile.distance(at))
    assert np.array_equal(argil.image(disc.astype(float), 3.0).distance(at), profile.distance(at))


def test_meshes_become_solids_and_come_back(tmp_path: Path) -> None:
    mesh = (sphere(1) - box(1.0, (0.5, 0.5, 0.5))).mesh(0.05)
    solid = mesh.sdf(0.02)
    assert solid.volume() == pytest.approx(mesh.volume, rel=0.01)
    mesh.save(tmp_path / "m.stl")
    assert argil.Mesh.from_file(tmp_path / "m.stl").sdf(resolution=100).volume() == pytest.approx(mesh.volume, rel=0.02)
    hollow = solid.erode(0.1).shell(0.1)
    assert hollow.mesh(0.03).is_watertight
    mesh.save(tmp_path / "m.stl", scale=2.0)
    assert argil.Mesh.from_file(tmp_path / "m.stl").size == pytest.approx(tuple(2 * c for c in mesh.size), rel=1e-4)


def test_pictures_show_the_solid(tmp_path: Path) -> None:
    picture = part().render((80, 60), ground=True)
    assert picture.shape == (60, 80, 3) and picture.dtype == np.uint8
    assert picture.std() > 5
    # z is up: a ball above is seen above.
    above = (sphere(0.2) | sphere(0.5).translate((0, 0, 3))).render((60, 60), show="normal", camera=(0, 0, 3))
    rows = (above.reshape(60, -1) != above[0, 0].repeat(60).reshape(3, 60).T.reshape(-1)).any(axis=1)
    assert rows[:30].sum() > rows[30:].sum()
    # x is to the right, seen from -y.
    right = (sphere(0.1) | sphere(0.5).translate((3, 0, 0))).render((60, 60), show="normal", eye=(1, -9, 0), target=(1, 0, 0))
    columns = (right != right[0, 0]).any(axis=(0, 2))
    assert columns[30:].sum() > columns[:30].sum()
    png = part()._repr_png_()
    assert png is not None and png.startswith(b"\x89PNG")
    assert argil.plane()._repr_png_() is None and "plane" in repr(argil.plane()).lower()
    profile = argil.hexagon(1)._repr_png_()
    assert profile is not None and profile.startswith(b"\x89PNG")
    part().save_picture(tmp_path / "p.png", (32, 24))
    part().turntable(tmp_path / "t.gif", frames=3, size=(32, 24))
    assert (tmp_path / "p.png").read_bytes().startswith(b"\x89PNG")
    gif = (tmp_path / "t.gif").read_bytes()
    assert gif.startswith(b"GIF89a") and gif.count(b"\x2c\x00\x00\x00\x00\x20\x00\x18\x00") == 3
    assert Scene(part()).render((16, 12)).shape == (12, 16, 3)
    assert part().bricks(32).render((16, 12), show="bricks").shape == (12, 16, 3)


def test_the_editor_opens_or_tells_what_is_missing(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.delenv("ARGIL_STUDIO", raising=False)
    monkeypatch.setenv("PATH", str(tmp_path))
    with pytest.raises(FileNotFoundError, match="not installed"):
        part().show()
    fake = tmp_path / "argil-studio"
    fake.write_text('#!/bin/sh\n/bin/cp "$1" "$(/usr/bin/dirname "$0")/opened.json"\n')
    fake.chmod(0o755)
    assert part().show().wait(10) == 0
    assert json.loads((tmp_path / "opened.json").read_text())["argil"] == 1


def test_slices_are_distances_in_a_plane() -> None:
    values, extent, axes = argil.sample_slice(sphere(1), w=41, h=21, z=0.5, bounds=((-1, -2, -1), (1, 2, 1)))
    assert values.shape == (41, 21) and axes == "YX" and extent == (-2, 2, -1, 1)
    assert values[20, 10] == pytest.approx(-0.5, abs=1e-6)
    with pytest.raises(ValueError, match="one of x, y and z"):
        argil.sample_slice(sphere(1))


def test_other_programs_take_meshes() -> None:
    trimesh = pytest.importorskip("trimesh")
    mesh = part().mesh(0.04)
    made = mesh.to_trimesh()
    assert isinstance(made, trimesh.Trimesh) and made.is_watertight and made.is_winding_consistent
    assert made.volume == pytest.approx(mesh.volume, rel=1e-5)
    assert made.center_mass == pytest.approx(mesh.center_of_mass(), abs=1e-4)
    assert np.mean(np.einsum("ij,ij->i", made.vertex_normals, mesh.normals)) > 0.9
    assert made.visual.vertex_colors.shape[1] == 4


def test_old_names_work() -> None:
    triangles = sphere(1).generate(step=0.2)
    assert triangles.shape[1] == 3 and len(triangles) % 3 == 0
    assert argil.union(sphere(1), box(1), k=0.1).distance([(0, 0, 2)]).shape == (1,)
    assert argil.slice(sphere(1)).extrude(1).mesh(0.1).is_watertight
    assert argil.d2.slab(x0=0).distance([(1.0, 0.0)])[0] == pytest.approx(-1)
    assert argil.np is np and argil.pi == math.pi and argil.UP.tolist() == [0, 0, 1]


def test_shapes_that_he_does_not_have() -> None:
    shapes = [
        argil.box_frame(1, 0.1),
        argil.capped_torus(0.6, 0.1, 2),
        argil.chain_link(0.5, 0.3, 0.1),
        argil.cut_sphere(0.8, 0.2),
        argil.solid_angle(0.8, 0.6),
        argil.rhombus(1.2, 0.8, 0.3, 0.05),
        argil.superellipsoid((0.8, 0.6, 0.5), 3, 4),
        argil.gyroid(1.2, 0.6, 0.06),
        argil.schwarz_p(1.2, 0.6, 0.06),
        argil.bezier_tube((0, 0, 0), (0.5, 0, 1), (1, 0, 0), 0.2, 0.1),
        argil.spline_tube([(0, 0, 0), (0.5, 0.2, 0.4), (1, 0, 0)], 0.1),
        sphere(0.5).displace(0.05, 4),
        sphere(0.3).mirror(x=True),
        sphere(0.2).instances([(0, 0, 0), (1, 0, 0)], scales=[1, 2]),
        sphere(1).union(box(1).translate((0.8, 0, 0)), chamfer=0.1),
    ]
    for solid in shapes:
        assert solid.mesh(samples=50_000).is_watertight, solid
    arc = argil.capped_torus(0.6, 0.1, 0.5)
    assert arc.distance([(0, 0.6, 0)])[0] < 0 < arc.distance([(0, -0.6, 0)])[0]
    assert argil.cut_sphere(0.8, 0.2).bounds[0][2] == pytest.approx(0.2, abs=4e-3)


def test_groups_of_any_depth_are_kept(tmp_path: Path) -> None:
    path = tmp_path / "deep.json"
    ball = '{"shape": {"type": "sphere", "radius": 1}}'
    depth = 5000
    path.write_text('{"argil": 1, "brushes": [' + '{"brushes": [' * depth + ball + "]}" * depth + "]}")
    scene = argil.Scene.load(path)
    assert scene.solid().distance([(0, 0, 3)])[0] == pytest.approx(2, abs=1e-4)
