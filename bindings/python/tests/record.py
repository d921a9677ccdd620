"""Records what fogleman/sdf returns for the cases, for tests where it is not at hand.

python tests/record.py PATH_TO_FOGLEMAN_SDF
"""

from __future__ import annotations

import sys
from pathlib import Path

import numpy as np

sys.path.insert(0, sys.argv[1])
sys.path.insert(0, str(Path(__file__).parent))

import cases
import sdf

at = np.random.default_rng(11).uniform(-1.5, 1.5, (500, 3)).astype(np.float32)
found = {"points": at}
for name, make in (cases.SHAPES | cases.SURFACES | cases.OPERATORS | cases.DEFORMATIONS).items():
    found[name] = make(sdf)(at.astype(np.float64)).reshape(-1).astype(np.float32)
np.savez_compressed(Path(__file__).with_name("fogleman.npz"), **found)
