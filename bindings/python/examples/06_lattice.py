"""A sheet of a minimal surface in a shell: closed, although its surface is curved."""

from argil import *

body = sphere(1)
f = (gyroid(2.2, 0.5, 0.06) & body.erode(0.06)) | body.shell(0.08)
f = f.paint("sand") - box(2, (1, -1, 1)).paint("red")
