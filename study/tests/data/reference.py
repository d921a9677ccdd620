"""The numbers of reference.json, by NumPy, trimesh and SciPy: python reference.py > reference.json"""
import json, pathlib
import numpy as np
import trimesh
from scipy.spatial import cKDTree

here = pathlib.Path(__file__).parent

def numbers(name):
    return np.fromfile(here / f"{name}.f32", "<f4").astype(np.float64)

def spread(errors):
    errors = np.abs(errors)
    return {"count": len(errors), "mean": errors.mean(), "rms": np.sqrt((errors**2).mean()), "max": errors.max()}

exact, own = numbers("exact-lengths"), numbers("mesh-lengths")
both = np.isfinite(exact) & np.isfinite(own)
depths = {
    "both": spread((own - exact)[both]),
    "missed": int((np.isfinite(exact) & ~np.isfinite(own)).sum()),
    "added": int((~np.isfinite(exact) & np.isfinite(own)).sum()),
}

band = 0.05
exact, own = numbers("exact-distances"), numbers("stored-distances")
stored = spread((own - exact)[(np.abs(own) < band) & (np.abs(exact) < band)]) | {"band": band}

# Points by trimesh's own spreading, distances to the nearest of very many points of the other surface.
a, b = (trimesh.load(here / f"teapot-{n}.ply") for n in (24, 32))
points = [trimesh.sample.sample_surface(mesh, 2_000_000, seed=1)[0] for mesh in (a, b)]
forth = cKDTree(points[1]).query(points[0][:100_000])[0]
back = cKDTree(points[0]).query(points[1][:100_000])[0]
# A tenth of the points decides the means; for the greatest, corners too.
corners = [trimesh.proximity.closest_point(b, a.vertices)[1].max(), trimesh.proximity.closest_point(a, b.vertices)[1].max()]
apart = {"hausdorff": max(forth.max(), back.max(), *corners), "chamfer": forth.mean() + back.mean()}

as_number = lambda x: x.item() if hasattr(x, "item") else x
print(json.dumps({"depths": depths, "stored": stored, "apart": apart}, default=as_number))
