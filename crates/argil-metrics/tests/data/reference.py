"""The numbers of reference.json, by SciPy, scikit-image and NVIDIA's flip-evaluator: python reference.py > reference.json"""
import json, pathlib
import numpy as np
from PIL import Image
from scipy import ndimage
from skimage.metrics import peak_signal_noise_ratio, structural_similarity
import flip_evaluator

here = pathlib.Path(__file__).parent

def load(name):
    return np.asarray(Image.open(here / name).convert("RGB"))

def laplacian(picture):
    kernel = -np.ones((5, 5), np.int64)
    kernel[2, 2] = 24
    channels = [ndimage.convolve(picture[..., c].astype(np.int64), kernel, mode="nearest") for c in range(3)]
    return np.clip(np.stack(channels, -1), 0, 255)

out = []
for a_name, b_name in [("teapot-field.png", "teapot-mesh.png"), ("csg20-field.png", "csg20-dense.png")]:
    a, b = load(a_name), load(b_name)
    difference = np.abs(laplacian(a) - laplacian(b))
    _, flip, _ = flip_evaluator.evaluate(
        a.astype(np.float32) / 255, b.astype(np.float32) / 255, "LDR", inputsRGB=True, applyMagma=False)
    ssim = structural_similarity(
        a, b, channel_axis=-1, data_range=255, gaussian_weights=True, sigma=1.5, use_sample_covariance=False)
    out.append({
        "a": a_name,
        "b": b_name,
        "psnr_db": float(peak_signal_noise_ratio(a, b, data_range=255)),
        "ssim": float(ssim),
        "flip_mean": float(flip),
        "laplacian_equal_pixels": int((difference == 0).all(-1).sum()),
        "laplacian_mean_abs": float(difference.mean()),
        "laplacian_histogram": np.bincount(difference[..., 0].ravel(), minlength=256).tolist(),
        "differing_pixels": int((a != b).any(-1).sum()),
    })
print(json.dumps(out))
