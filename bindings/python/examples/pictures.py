"""Renders the pictures of the README: every example's solid, by its name, into docs/.

python examples/pictures.py
"""

from pathlib import Path
from runpy import run_path
from typing import Any

CAMERAS: dict[str, dict[str, Any]] = {
    "02_blends": {"camera": (25, 30, 2.6)},
    "03_ring": {"camera": (30, 20, 3.4)},
    "04_profiles": {"camera": (10, 30, 2.9)},
    "05_text": {"camera": (0, 25, 3.0)},
    "06_lattice": {"camera": (35, 30, 2.8)},
    "07_function": {"camera": (20, 35, 2.8)},
    "08_mesh": {"camera": (-60, 15, 2.8)},
    "10_bricks": {"camera": (20, 40, 2.8)},
}

here = Path(__file__).parent
for path in sorted(here.glob("[0-9]*.py")):
    solid = run_path(str(path))["f"]
    picture = here.parent / "docs" / f"{path.stem[3:]}.png"
    solid.save_picture(picture, (480, 320), ground=True, **CAMERAS.get(path.stem, {}))
    print(picture)
