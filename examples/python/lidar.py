"""A robot drives through the hall with a lidar: point clouds, and a range image of the first scan.

    python lidar.py FOLDER [--sensor vlp-16|hdl-32e|hdl-64e|os1-64|os1-128|mid-40] [--scans 3]
"""

import argparse
from pathlib import Path

import numpy as np
from PIL import Image

import latelight
from latelight import lidar

SENSORS = {"vlp-16": lidar.vlp16, "hdl-32e": lidar.hdl32e, "hdl-64e": lidar.hdl64e, "os1-64": lidar.os1_64,
           "os1-128": lidar.os1_128, "mid-40": lidar.livox_mid40}  # fmt: skip
FARTHEST = 25.0  # meters, of the image


def range_image(scan: lidar.Scan, columns: int = 1024) -> Image.Image:
    """Columns are degrees of azimuth, forward in the middle; rows are lasers, or degrees. Near surfaces are bright."""
    x, y, z = scan.position.T.astype(np.float64)
    azimuth, elevation = np.arctan2(y, x), np.arctan2(z, np.hypot(x, y))
    steps = columns / (2 * np.pi)
    column = ((np.pi - azimuth) * steps).astype(int) % columns
    row = scan.ring.max() - scan.ring if scan.ring.any() else ((elevation.max() - elevation) * steps).astype(int)
    image = np.zeros((row.max() + 1, columns), np.uint8)
    order = np.argsort(-scan.range)  # nearer points replace farther ones
    image[row[order], column[order]] = (255 - 215 * np.clip(scan.range[order] / FARTHEST, 0, 1)).astype(np.uint8)
    return Image.fromarray(image.repeat(max(1, 128 // len(image)), axis=0))


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("folder", type=Path)
    parser.add_argument("--sensor", choices=SENSORS, default="vlp-16")
    parser.add_argument("--scans", type=int, default=3)
    parser.add_argument("--device", default="auto")
    arguments = parser.parse_args()
    arguments.folder.mkdir(parents=True, exist_ok=True)

    renderer = latelight.Renderer(latelight.Scene("builtin:hall"), arguments.device)
    drive = lidar.Motion(lidar.sensor_pose((0, 1.2, 12), forward=(0, 0, -1)), velocity=(0, 0, -5))
    pattern = SENSORS[arguments.sensor]()
    for number in range(arguments.scans):
        scan = lidar.scan(
            renderer, pattern, drive, start=number * pattern.period, samples=4, returns="dual", seed=number
        )
        path = arguments.folder / f"{number:04}.pcd"
        scan.write(path)
        print(f"{path}: {len(scan)} points, the nearest at {scan.range.min():.2f} m")
        if number == 0:
            range_image(scan).save(arguments.folder / "range.png")


if __name__ == "__main__":
    main()
