"""Reads the data set that set_test.cpp wrote, by the readers that people use, and compares with what was rendered."""

import glob
import json
import os
import sys
import unittest

import cv2
import numpy as np
import OpenEXR
from pycocotools import mask as coco_mask
from pycocotools.coco import COCO

SET = os.environ["LATELIGHT_TEST_SET"]
FRAMES = ["000000", "000001", "000002"]


def raw(frame, name):
    return np.load(f"{SET}/raw/{frame}/{name}.npy")


def folder(number, name):
    return f"{SET}/{number}-{name}"


def half(values):
    """As halves are stored: finite light stays finite."""
    return np.clip(values, -65504, 65504).astype(np.float16)


class Pictures(unittest.TestCase):
    def exr(self, path):
        return OpenEXR.File(path, separate_channels=True)

    def test_exr(self):
        for frame in FRAMES:
            file = self.exr(f"{folder(0, 'exr')}/{frame}.exr")
            self.assertIn("idManifest", file.header())
            channels = file.channels()
            for i, name in enumerate("RGBA"):
                np.testing.assert_array_equal(channels[name].pixels, half(raw(frame, "color")[..., i]))
            for name, source in [("Z", "depth"), ("distance", "distance"), ("id", "id"), ("material", "material")]:
                np.testing.assert_array_equal(channels[name].pixels, raw(frame, source))
            for layer, source, letters in [("N", "normal", "XYZ"), ("P", "position", "XYZ"), ("motion", "motion", "XYZW")]:
                for i, letter in enumerate(letters):
                    np.testing.assert_array_equal(channels[f"{layer}.{letter}"].pixels, raw(frame, source)[..., i])

    def test_exr_with_blenders_names(self):
        for frame in FRAMES:
            file = self.exr(f"{folder(1, 'exr')}/{frame}.exr")
            channels = {name.removeprefix("ViewLayer."): c.pixels for name, c in file.channels().items()}
            for i, name in enumerate("RGBA"):
                np.testing.assert_array_equal(channels[f"Combined.{name}"], half(raw(frame, "color")[..., i]))
            np.testing.assert_array_equal(channels["Depth.Z"], raw(frame, "depth"))
            np.testing.assert_array_equal(channels["IndexOB.X"], raw(frame, "id"))
            np.testing.assert_array_equal(channels["IndexMA.X"], raw(frame, "material"))
            np.testing.assert_array_equal(channels["distance.X"], raw(frame, "distance"))
            for i, name in enumerate("XYZ"):
                np.testing.assert_array_equal(channels[f"Normal.{name}"], raw(frame, "normal")[..., i])
                np.testing.assert_array_equal(channels[f"Position.{name}"], raw(frame, "position")[..., i])
            for i, (name, sign) in enumerate([("X", 1), ("Y", -1), ("Z", -1), ("W", 1)]):
                np.testing.assert_array_equal(channels[f"Vector.{name}"], sign * raw(frame, "motion")[..., i])
            self.assertNotIn("idManifest", file.header())
            said = json.loads(file.header()["latelight"])
            self.assertEqual(said["aovs"]["depth"]["channels"], ["ViewLayer.Depth.Z"])

    def test_npz(self):
        for frame in FRAMES:
            with np.load(f"{folder(2, 'npz')}/{frame}.npz") as arrays:
                self.assertEqual(len(arrays.files), 10)
                for name in arrays.files:
                    np.testing.assert_array_equal(arrays[name], raw(frame, name))
                    self.assertEqual(arrays[name].dtype, np.uint32 if name in ("id", "material") else np.float32)

    def test_depth_png(self):
        for number, scale in [(3, 1000), (4, 256)]:
            for frame in FRAMES:
                codes = cv2.imread(f"{folder(number, 'depth-png')}/depth/{frame}.png", cv2.IMREAD_UNCHANGED)
                self.assertEqual(codes.dtype, np.uint16)
                depth = raw(frame, "depth").astype(np.float64)
                held = np.isfinite(depth) & (depth * scale < 65535.5)
                self.assertGreater(held.sum(), 1000)
                np.testing.assert_array_equal(codes > 0, held)
                self.assertLessEqual(np.abs(codes[held] / scale - depth[held]).max(), 0.5 / scale + 1e-9)

    def test_flow(self):
        for frame in FRAMES:
            flow = cv2.readOpticalFlow(f"{folder(5, 'flow')}/flow/{frame}.flo")
            np.testing.assert_array_equal(flow, raw(frame, "motion")[..., 2:])
            self.assertGreater(np.abs(flow).max(), 0.1)
            bgr = cv2.imread(f"{folder(6, 'flow')}/flow/{frame}.png", cv2.IMREAD_UNCHANGED)  # as KITTI's development kit
            kitti = (bgr[..., ::-1][..., :2].astype(np.float64) - 2**15) / 64
            valid = bgr[..., 0] == 1
            np.testing.assert_array_equal(valid, (np.abs(flow) < 511).all(-1))
            self.assertLessEqual(np.abs(kitti[valid] - flow[valid]).max(), 1 / 128 + 1e-9)


class Coco(unittest.TestCase):
    def setUp(self):
        stdout, sys.stdout = sys.stdout, open(os.devnull, "w")
        self.coco = COCO(f"{folder(7, 'coco')}/annotations/instances.json")
        sys.stdout.close()
        sys.stdout = stdout

    def test_masks(self):
        for image in self.coco.loadImgs(self.coco.getImgIds()):
            ids = raw(f"{image['id']:06}", "id")
            annotations = self.coco.loadAnns(self.coco.getAnnIds(imgIds=image["id"]))
            self.assertEqual(sorted(a["object"] for a in annotations), sorted(set(ids.flat) - {0}))
            self.assertGreater(len(annotations), 5)
            for annotation in annotations:
                mask = ids == annotation["object"]
                np.testing.assert_array_equal(self.coco.annToMask(annotation), mask)
                encoded = coco_mask.encode(np.asfortranarray(mask.astype(np.uint8)))
                self.assertEqual(encoded["counts"].decode(), annotation["segmentation"]["counts"])
                self.assertEqual(coco_mask.area(encoded), annotation["area"])
                self.assertEqual(list(coco_mask.toBbox(encoded)), annotation["bbox"])

    def test_images(self):
        for image in self.coco.loadImgs(self.coco.getImgIds()):
            picture = cv2.imread(f"{folder(7, 'coco')}/{image['file_name']}", cv2.IMREAD_UNCHANGED)
            self.assertEqual(picture.shape, (image["height"], image["width"], 4))

    def test_categories(self):
        names = [c["name"] for c in self.coco.loadCats(self.coco.getCatIds())]
        self.assertEqual(names, sorted(names))
        for annotation in self.coco.loadAnns(self.coco.getAnnIds()):
            self.assertEqual(self.coco.cats[annotation["category_id"]]["name"], annotation["node"])


if __name__ == "__main__":
    unittest.main()
