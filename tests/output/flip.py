"""flip.py PROGRAM FOLDER: mean FLIP of pairs of pictures by `PROGRAM compare`, and by flip-evaluator; fails where they
are more than 1e-4 apart."""

import json
import struct
import subprocess
import sys
import zlib
from pathlib import Path

import flip_evaluator
import numpy as np

program, folder = sys.argv[1], Path(sys.argv[2])
random = np.random.default_rng(5)


def write_png(path, pixels):
    """(height, width, 3) of 8 bits."""
    height, width, _ = pixels.shape
    chunk = lambda kind, data: struct.pack(">I", len(data)) + kind + data + struct.pack(">I", zlib.crc32(kind + data))
    rows = b"".join(b"\0" + row.tobytes() for row in pixels)
    path.write_bytes(b"\x89PNG\r\n\x1a\n" + chunk(b"IHDR", struct.pack(">IIBBBBB", width, height, 8, 2, 0, 0, 0))
                     + chunk(b"IDAT", zlib.compress(rows)) + chunk(b"IEND", b""))


def pairs():
    height, width = 72, 96
    y, x = np.mgrid[0:height, 0:width]
    smooth = np.stack([x / width, y / height, (x + y) / (width + height)], axis=-1)
    yield "noise", random.random((height, width, 3)), random.random((height, width, 3))
    yield "faint noise", smooth, np.clip(smooth + random.normal(0, 0.02, smooth.shape), 0, 1)
    checks = np.where(((x // 8 + y // 8) % 2)[..., None] == 0, 0.1, 0.9) * np.array([1, 0.8, 0.6])
    yield "moved by a pixel", checks, np.roll(checks, 1, axis=1)
    yield "another colour", smooth, smooth[..., ::-1]
    yield "brighter", smooth, np.clip(smooth * 1.3, 0, 1)
    yield "black and white", np.zeros_like(smooth), np.ones_like(smooth)
    wide = np.zeros((5, 200, 3))
    wide[:, 100] = 1
    yield "smaller than the filters", wide, np.zeros_like(wide)


far = 0
for name, reference, test in pairs():
    pictures = [np.round(picture * 255).astype(np.uint8) for picture in (reference, test)]
    paths = [folder / "reference.png", folder / "test.png"]
    for path, picture in zip(paths, pictures):
        write_png(path, picture)
    for ppd in (67.0, 30.0):
        ours = subprocess.run([program, "compare", *map(str, paths), "--json", "--ppd", str(ppd)], capture_output=True, text=True)
        mean = json.loads(ours.stdout)["outputs"]["color"]["flip"]
        theirs = flip_evaluator.evaluate(*(picture.astype(np.float32) / 255 for picture in pictures), "LDR",
                                         parameters={"ppd": ppd})[1]
        off = abs(mean - theirs) > 1e-4
        far += off
        print(f"{name}, {ppd:.0f} pixels per degree: {mean:.6f}, flip-evaluator {theirs:.6f}{'  FAR' if off else ''}")
sys.exit(1 if far else 0)
