"""Profiles of letters and images."""

from __future__ import annotations

import functools
import os
import sys
from typing import TYPE_CHECKING, Any

from . import _native
from ._numbers import ENDLESS, modified, number, shape
from ._sdf2 import SDF2

if TYPE_CHECKING:
    import numpy as np
    from numpy.typing import NDArray

_FOLDERS = {
    "darwin": ("/System/Library/Fonts", "/Library/Fonts", "~/Library/Fonts"),
    "win32": (r"C:\Windows\Fonts", r"~\AppData\Local\Microsoft\Windows\Fonts"),
}.get(sys.platform, ("/usr/share/fonts", "/usr/local/share/fonts", "~/.local/share/fonts", "~/.fonts"))


def _font_path(name: str) -> str:
    """Finds a font by its path, or by its file's name among the system's fonts."""
    if os.path.isfile(name):
        return name
    wanted = os.path.splitext(os.path.basename(name))[0].lower().replace(" ", "")
    for folder in _FOLDERS:
        for where, _, files in os.walk(os.path.expanduser(folder)):
            for file in sorted(files):
                stem, ending = os.path.splitext(file)
                if ending.lower() in (".ttf", ".otf", ".ttc") and stem.lower().replace(" ", "") == wanted:
                    return os.path.join(where, file)
    raise FileNotFoundError(
        f"font {name!r}: it is neither a file nor among the fonts of {', '.join(_FOLDERS)}; "
        "pass the path of a .ttf or .otf file, or None for the built-in font"
    )


@functools.lru_cache(maxsize=8)
def _font(path: str) -> bytes:
    with open(path, "rb") as file:
        return file.read()


def _outline(path: Any) -> _native.Node:
    start, segments = path
    parts = [{"to": to} if control is None else {"control": control, "to": to} for control, to in segments]
    return shape("extrusion", outline={"start": start, "segments": parts}, half_depth=ENDLESS)


def _letters(font: str | None, text: str) -> tuple[_native.Node, tuple[float, float, float, float]]:
    """Returns the letters as one node, and their box."""
    if font is None:
        node = shape("text", text=text, size=1.0, half_depth=1.0)
        low, high = node.bounds() or ([0.0] * 3, [0.0] * 3)
        # The letters lie in the scene's x-y plane, whose y is Python's z.
        return modified(node, "extrude", half_depth=ENDLESS), (low[0], low[2], high[0], high[2])
    letters = _native.text_outlines(_font(_font_path(font)), text)
    box = [float("inf"), float("inf"), float("-inf"), float("-inf")]
    whole: _native.Node | None = None
    for paths in letters:
        letter: _native.Node | None = None
        # Each path comes after the paths around it.
        for depth, path in paths:
            own, operator = _outline(path), "subtract" if depth % 2 else "union"
            letter = own if letter is None else letter.joined(own, operator, 0.0, "smooth", 0.0, None)
        if letter is not None:
            whole = letter if whole is None else whole.joined(letter, "union", 0.0, "smooth", 0.0, None)
            (x0, _, y0), (x1, _, y1) = modified(letter, "extrude", half_depth=1.0).bounds() or ([0.0] * 3, [0.0] * 3)
            box = [min(box[0], x0), min(box[1], y0), max(box[2], x1), max(box[3], y1)]
    if whole is None:
        raise ValueError("text: it has no visible characters")
    return whole, (box[0], box[1], box[2], box[3])


def _scaled(aspect: float, width: float | None, height: float | None) -> tuple[float, float]:
    if width is None and height is None:
        height = 1.0
    if width is None:
        assert height is not None
        width = height * aspect
    if height is None:
        height = width / aspect
    width, height = number("width", width), number("height", height)
    if width <= 0 or height <= 0:
        raise ValueError(f"width, height: {width} × {height} is not above 0")
    return width, height


def measure_text(name: str | None, text: str, width: float | None = None, height: float | None = None) -> tuple[float, float]:
    """Returns width and height of what `text` returns."""
    _, (x0, y0, x1, y1) = _letters(name, text)
    return _scaled((x1 - x0) / (y1 - y0), width, height)


def text(
    font_name: str | None,
    text: str,
    width: float | None = None,
    height: float | None = None,
    pixels: int | None = None,
    points: int | None = None,
) -> SDF2:
    """Returns letters as a profile around the origin, `width` wide or `height` high, by default 1 high.

    `font_name` is the path of a .ttf or .otf file, the name of such a file among the system's fonts, or None for the built-in
    font, Ubuntu Light. Letters are exact outlines: `pixels` and `points` are accepted and change nothing.
    """
    del pixels, points
    node, (x0, y0, x1, y1) = _letters(font_name, text)
    wide, high = _scaled((x1 - x0) / (y1 - y0), width, height)
    x, y = wide / (x1 - x0), high / (y1 - y0)
    placed = SDF2(node).translate((-0.5 * (x0 + x1), -0.5 * (y0 + y1)))
    return placed.scale(x) if abs(x / y - 1) < 1e-4 else placed.scale((x, y))


def _mask(thing: Any) -> NDArray[np.bool_]:
    import numpy as np

    if isinstance(thing, (str, os.PathLike)):
        try:
            from PIL import Image
        except ImportError:
            raise ImportError("reading images needs Pillow: pip install argil-sdf[images]") from None
        with Image.open(thing) as picture:
            array = np.asarray(picture.convert("L"))
    else:
        array = np.asarray(thing)
    if array.ndim == 3:
        array = array[..., :3].astype(float) @ [0.299, 0.587, 0.114]
    if array.ndim != 2:
        raise ValueError(f"image: expected an array (height, width), not of shape {array.shape}")
    if array.dtype == bool:
        return np.ascontiguousarray(array)
    top = 255.0 if array.dtype.kind in "iu" or array.max(initial=0) > 1 else 1.0
    return np.ascontiguousarray(array >= 0.5 * top)


def measure_image(thing: Any, width: float | None = None, height: float | None = None) -> tuple[float, float]:
    """Returns width and height of what `image` returns."""
    mask = _mask(thing)
    return _scaled(mask.shape[1] / mask.shape[0], width, height)


def image(thing: Any, width: float | None = None, height: float | None = None, pixels: int | None = None) -> SDF2:
    """Returns the bright part of an image as a profile around the origin, `width` wide or `height` high.

    `thing` is the path of an image, read by Pillow, or an array: of booleans, of numbers from 0 to 1, or of bytes. Pixels of
    half the brightness or more are inside. `pixels` is accepted and changes nothing.
    """
    del pixels
    mask = _mask(thing)
    wide, high = _scaled(mask.shape[1] / mask.shape[0], width, height)
    node = modified(_native.image_profile(mask, wide), "extrude", half_depth=ENDLESS)
    stretch = high / (wide * mask.shape[0] / mask.shape[1])
    profile = SDF2(node)
    return profile if abs(stretch - 1) < 1e-4 else profile.scale((1.0, stretch))
