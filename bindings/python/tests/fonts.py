"""A TrueType font of polygons, so that tests need no file."""

from __future__ import annotations

import struct
from collections.abc import Sequence

Polygon = Sequence[tuple[int, int]]

UNITS_PER_EM = 1000


def _glyph(polygons: Sequence[Polygon]) -> bytes:
    """Returns a glyph's outlines, with all points on the curve."""
    points = [point for polygon in polygons for point in polygon]
    ends = [sum(len(polygon) for polygon in polygons[: i + 1]) - 1 for i in range(len(polygons))]
    xs, ys = zip(*points, strict=True)
    steps = [[b - a for a, b in zip((0, *row), row, strict=False)] for row in (xs, ys)]
    head = struct.pack(">5h", len(polygons), min(xs), min(ys), max(xs), max(ys))
    body = struct.pack(f">{len(ends)}HH", *ends, 0) + b"\1" * len(points)
    data = head + body + b"".join(struct.pack(f">{len(row)}h", *row) for row in steps)
    return data + b"\0" * (-len(data) % 4)


def font(glyphs: dict[str, Sequence[Polygon]]) -> bytes:
    """Returns a font whose letters are polygons, each an em wide."""
    letters = sorted(glyphs)
    data = [b"", *(_glyph(glyphs[letter]) for letter in letters)]
    offsets = [sum(map(len, data[:i])) for i in range(len(data) + 1)]
    count = len(data)
    groups = b"".join(struct.pack(">3I", ord(letter), ord(letter), i + 1) for i, letter in enumerate(letters))
    subtable = struct.pack(">HHIII", 12, 0, 16 + len(groups), 0, len(letters)) + groups
    tables = {
        b"cmap": struct.pack(">HHHHI", 0, 1, 3, 10, 12) + subtable,
        b"glyf": b"".join(data),
        b"head": struct.pack(
            ">HHiIIHHqqhhhhHHhhh", 1, 0, 0, 0, 0x5F0F3CF5, 0, UNITS_PER_EM, 0, 0, 0, 0, 1000, 1000, 0, 8, 2, 1, 0
        ),
        b"hhea": struct.pack(">HHhhhHhhhhhh8xhH", 1, 0, 1000, 0, 0, 1000, 0, 0, 1000, 1, 0, 0, 0, count),
        b"hmtx": struct.pack(">Hh", 1000, 0) * count,
        b"loca": struct.pack(f">{len(offsets)}I", *offsets),  # typos: ignore
        b"maxp": struct.pack(">IH13H", 0x10000, count, 400, 16, 0, 0, 1, 0, 0, 0, 0, 0, 0, 0, 0),
    }
    at = 12 + 16 * len(tables)
    records, bodies = b"", b""
    for tag, body in tables.items():
        records += tag + struct.pack(">III", 0, at + len(bodies), len(body))
        bodies += body + b"\0" * (-len(body) % 4)
    return struct.pack(">IHHHH", 0x10000, len(tables), 64, 2, 48) + records + bodies
