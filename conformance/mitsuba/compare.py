"""Compares stills with Mitsuba 3: the same meshes, camera, sky, sun and materials.

Usage: python compare.py ARGIL SCENES FOLDER [SAMPLES]. Prints a line for each picture, and exits with 1 if the mean of squared
relative errors of 16×16 blocks of pixels exceeds 1 %. Pictures stay in FOLDER.
"""

import json
import math
import subprocess
import sys
from pathlib import Path

import mitsuba as mi
import numpy as np

mi.set_variant("scalar_rgb")

SIZE = (192, 144)
BLOCK = 16
MOST = 0.01
FIELD_OF_VIEW = 35.0
SUN_DEGREES = (60.0, 50.0)
# Light of the sky and the sun, as docs of `PathLights::of_frame` state them.
ZENITH, HORIZON, NADIR = np.array([0.30, 0.45, 0.72]), np.array([0.80, 0.86, 0.92]), np.array([0.44, 0.45, 0.47])
SUN = np.array([3.3, 3.05, 2.65]) * math.pi / 2

MATERIALS = {
    "clay": {"base_color": [0.62, 0.36, 0.25], "roughness": 0.6, "metallic": 0.0},
    "glaze": {"base_color": [0.2, 0.35, 0.55], "roughness": 0.25, "metallic": 0.0},
    "gold": {"base_color": [0.9, 0.65, 0.3], "roughness": 0.4, "metallic": 1.0},
}


def toward_sun() -> np.ndarray:
    azimuth, elevation = (math.radians(c) for c in SUN_DEGREES)
    flat = math.cos(elevation)
    return np.array([flat * math.sin(azimuth), math.sin(elevation), flat * math.cos(azimuth)])


def sky(direction: np.ndarray) -> np.ndarray:
    up = direction[..., 1:2]
    above = HORIZON + (ZENITH - HORIZON) * np.sqrt(np.clip(up, 0, None))
    below = HORIZON + (NADIR - HORIZON) * np.clip(-4 * up, 0, 1)
    glow = np.clip(direction @ toward_sun(), 0, None)[..., None] ** 16
    return np.where(up >= 0, above, below) + np.array([0.25, 0.18, 0.08]) * glow


def sky_image() -> mi.Bitmap:
    """The sky as Mitsuba unrolls it: v from y up, u around it."""
    height, width = 512, 1024
    u = (np.arange(width) + 0.5) / width
    v = (np.arange(height) + 0.5) / height
    u, v = np.meshgrid(u * 2 * math.pi, v * math.pi)
    direction = np.stack([np.sin(u) * np.sin(v), np.cos(v), -np.cos(u) * np.sin(v)], -1)
    return mi.Bitmap(sky(direction).astype(np.float32))


def bsdf(material: dict) -> dict:
    color = {"type": "rgb", "value": material["base_color"]}
    # Their plastic reflects less the rougher it is: 63 % of white light at an alpha of 0.36.
    if material["roughness"] > 0.3:
        return {
            "type": "principled",
            "base_color": color,
            "roughness": material["roughness"],
            "metallic": material["metallic"],
            "specular": 0.5,
        }
    return {
        "type": "roughplastic",
        "distribution": "ggx",
        "int_ior": 1.5,
        "alpha": material["roughness"] ** 2,
        "diffuse_reflectance": color,
        "nonlinear": False,
    }


def main() -> int:
    argil, scenes, folder = sys.argv[1], Path(sys.argv[2]), Path(sys.argv[3])
    samples = int(sys.argv[4]) if len(sys.argv) > 4 else 128
    folder.mkdir(parents=True, exist_ok=True)
    worst = 0.0
    for name in ("csg20", "teapot"):
        scene = json.loads((scenes / f"{name}.json").read_text())
        info = json.loads(subprocess.check_output([argil, "info", str(scenes / f"{name}.json"), "--json"]))
        low, high = (np.array(corner) for corner in scene["view"].get("bounds") or info["box"])
        middle, radius = (low + high) / 2, np.linalg.norm(high - low) / 2
        eye = middle + 2.6 * radius * np.array([0.55, 0.45, 0.7]) / np.linalg.norm([0.55, 0.45, 0.7])
        for title, material in MATERIALS.items():
            scene["materials"] = {own: material for own in scene.get("materials", {})}
            scene["view"] |= {
                "camera": {"look_at": {"eye": eye.tolist(), "target": middle.tolist()}},
                "field_of_view_degrees": FIELD_OF_VIEW,
                "sun_degrees": list(SUN_DEGREES),
                "ground": False,
            }
            path = folder / f"{name}-{title}.json"
            path.write_text(json.dumps(scene))
            ours, mesh = path.with_suffix(".exr"), folder / f"{name}.ply"
            size = f"{SIZE[0]}x{SIZE[1]}"
            render = [argil, "render", str(path), "--integrator", "path", "--via", "bricks", "--resolution", "512"]
            subprocess.run([*render, "--samples", str(samples), "--size", size, "-o", str(ours)], check=True, stdout=subprocess.DEVNULL)
            if not mesh.exists():
                subprocess.run([argil, "mesh", str(path), "--resolution", "384", "-o", str(mesh)], check=True, stdout=subprocess.DEVNULL)
            theirs = mi.load_dict(
                {
                    "type": "scene",
                    "integrator": {"type": "path", "max_depth": 33},
                    "sensor": {
                        "type": "perspective",
                        "fov": FIELD_OF_VIEW,
                        "fov_axis": "y",
                        "to_world": mi.ScalarTransform4f().look_at(origin=eye.tolist(), target=middle.tolist(), up=[0, 1, 0]),
                        "film": {
                            "type": "hdrfilm",
                            "width": SIZE[0],
                            "height": SIZE[1],
                            "pixel_format": "rgb",
                            "rfilter": {"type": "box"},
                        },
                        "sampler": {"type": "independent", "sample_count": samples},
                    },
                    "sky": {"type": "envmap", "bitmap": sky_image(), "scale": 1.0},
                    "sun": {
                        "type": "directional",
                        "direction": (-toward_sun()).tolist(),
                        "irradiance": {"type": "rgb", "value": SUN.tolist()},
                    },
                    "mesh": {"type": "ply", "filename": str(mesh), "bsdf": {"type": "twosided", "own": bsdf(material)}},
                }
            )
            found = np.array(mi.render(theirs))
            mi.Bitmap(found.astype(np.float32)).write(str(path.with_name(f"{name}-{title}-mitsuba.exr")))
            own = np.array(mi.Bitmap(str(ours)).convert(mi.Bitmap.PixelFormat.RGB, mi.Struct.Type.Float32))
            blocks = [
                picture.reshape(SIZE[1] // BLOCK, BLOCK, SIZE[0] // BLOCK, BLOCK, 3).mean((1, 3)) for picture in (own, found)
            ]
            error = float((((blocks[0] - blocks[1]) / blocks[1]) ** 2).mean())
            ratio = float(blocks[0].mean() / blocks[1].mean())
            worst = max(worst, error)
            print(f"{name}, {title}: relative MSE of blocks {100 * error:.3f} %, brightness {ratio:.4f} of Mitsuba's", flush=True)
    return int(worst > MOST)


if __name__ == "__main__":
    sys.exit(main())
