"""Reads the data set that set_test.cpp wrote, by the readers that people use, and compares with what was rendered."""

import glob
import json
import os
import sys
import unittest

import cv2
import mmh3
import numpy as np
import OpenEXR
from plyfile import PlyData
from pycocotools import mask as coco_mask
from pycocotools.coco import COCO

SET = os.environ["LATELIGHT_TEST_SET"]
# Metres that a pixel may show of a surface beyond its edge: corners are snapped to parts of a pixel, which on a floor seen
# at a grazing angle are long.
SNAP = 0.01
FRAMES = ["000000", "000001", "000002"]


def raw(frame, name):
    return np.load(f"{SET}/raw/{frame}/{name}.npy")


def read_json(path):
    with open(path, encoding="utf-8") as file:
        return json.load(file)


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


def surfaces(frame):
    """Pixels that show something: their coordinates, positions and ids."""
    ids = raw(frame, "id")
    y, x = np.nonzero(ids)
    return x + 0.5, y + 0.5, raw(frame, "position")[y, x].astype(np.float64), ids[y, x]


def box_of(mask):
    y, x = np.nonzero(mask)
    return [x.min(), y.min(), np.ptp(x) + 1, np.ptp(y) + 1]


class Boxes(unittest.TestCase):
    def setUp(self):
        self.frames = {f: read_json(f"{folder(8, 'boxes')}/boxes/{f}.json") for f in FRAMES}

    def test_extents(self):
        hidden = 0
        for frame, boxes in self.frames.items():
            ids = raw(frame, "id")
            for thing in boxes["objects"]:
                visible = ids == thing["id"]
                self.assertEqual(thing["visible"]["pixels"], visible.sum())
                self.assertGreaterEqual(thing["whole"]["pixels"], thing["whole"]["pixelsInPicture"])
                self.assertAlmostEqual(thing["visibleShare"], visible.sum() / thing["whole"]["pixels"])
                hidden += thing["visibleShare"] < 1
                if not visible.any():
                    continue
                self.assertEqual(thing["visible"]["box"], box_of(visible))
                x, y, width, height = thing["whole"]["box"]
                vx, vy, vwidth, vheight = thing["visible"]["box"]
                self.assertTrue(x <= vx and y <= vy and x + width >= vx + vwidth and y + height >= vy + vheight)
            self.assertLessEqual(set(ids.flat) - {0}, {thing["id"] for thing in boxes["objects"]})
        self.assertGreater(hidden, 3)

    def test_boxes_in_space(self):
        for frame, boxes in self.frames.items():
            k = np.reshape(boxes["camera"]["K"], (3, 3))
            to_camera = np.array(boxes["camera"]["worldToCamera"])
            _, _, positions, ids = surfaces(frame)
            for thing in boxes["objects"]:
                box = thing["box"]
                np.testing.assert_allclose(box["toCamera"], to_camera @ box["toWorld"], atol=1e-6)
                half = np.array(box["size"]) / 2
                inside = (positions[ids == thing["id"]] - np.array(box["toWorld"])[:3, 3]) @ np.array(box["toWorld"])[:3, :3]
                self.assertTrue((np.abs(inside) <= half + SNAP).all())
                for i, corner in enumerate(box["corners"]):
                    sign = np.array([i & 1, i >> 1 & 1, i >> 2 & 1]) * 2 - 1
                    p = (np.array(box["toCamera"]) @ [*(sign * half), 1])[:3]
                    if p[2] <= 0:
                        self.assertIsNone(corner)
                    elif p[2] > 0.1:
                        np.testing.assert_allclose(corner, [*(k @ p)[:2] / p[2], p[2]], rtol=1e-6, atol=1e-5)


class Bop(unittest.TestCase):
    def setUp(self):
        self.scene = f"{folder(9, 'bop')}/train/000000"
        self.camera, self.gt, self.info = (
            read_json(f"{self.scene}/{name}.json") for name in ("scene_camera", "scene_gt", "scene_gt_info"))
        self.models = read_json(f"{folder(9, 'bop')}/models/models_info.json")

    def mask(self, kind, image, number):
        mask = cv2.imread(f"{self.scene}/{kind}/{image:06}_{number:06}.png", cv2.IMREAD_UNCHANGED)
        self.assertLessEqual(set(mask.flat), {0, 255})
        return mask > 0

    def test_layout(self):
        self.assertEqual(set(self.camera), {"0", "1", "2"})
        for image in range(3):
            rgb = cv2.imread(f"{self.scene}/rgb/{image:06}.png", cv2.IMREAD_UNCHANGED)
            self.assertEqual(rgb.shape, (64, 96, 3))
            count = len(self.gt[str(image)])
            self.assertGreater(count, 5)
            self.assertEqual(len(self.info[str(image)]), count)
            for kind in ("mask", "mask_visib"):
                self.assertEqual(len(glob.glob(f"{self.scene}/{kind}/{image:06}_*.png")), count)

    def test_depth(self):
        for image in range(3):
            codes = cv2.imread(f"{self.scene}/depth/{image:06}.png", cv2.IMREAD_UNCHANGED)
            depth = raw(f"{image:06}", "depth").astype(np.float64) * 1000
            scale = self.camera[str(image)]["depth_scale"]
            self.assertEqual(scale, 0.5)
            seen = codes > 0
            self.assertGreater(seen.sum(), 1000)
            self.assertLessEqual(np.abs(codes[seen] * scale - depth[seen]).max(), scale / 2 + 1e-6)

    def test_visibility(self):
        for image in range(3):
            ids = raw(f"{image:06}", "id")
            seen = np.zeros(ids.shape, bool)
            depth = cv2.imread(f"{self.scene}/depth/{image:06}.png", cv2.IMREAD_UNCHANGED)
            for number, info in enumerate(self.info[str(image)]):
                visible, whole = (self.mask(kind, image, number) for kind in ("mask_visib", "mask"))
                self.assertFalse((visible & ~whole).any())
                self.assertFalse((visible & seen).any())
                seen |= visible
                self.assertEqual(info["px_count_visib"], visible.sum())
                self.assertGreaterEqual(info["px_count_all"], whole.sum())
                self.assertEqual(info["px_count_valid"], (depth[whole] > 0).sum())
                self.assertAlmostEqual(info["visib_fract"], visible.sum() / info["px_count_all"])
                if visible.any():
                    self.assertEqual(info["bbox_visib"], box_of(visible))
                    self.assertEqual(len(set(ids[visible])), 1)
                else:
                    self.assertEqual(info["bbox_visib"], [-1, -1, -1, -1])
            np.testing.assert_array_equal(seen, ids != 0)

    def test_poses(self):
        """What is seen of an object lies in its model's box, by the pose of the camera and by that of the object."""
        for image in range(3):
            x, y, positions, _ = surfaces(f"{image:06}")
            camera = self.camera[str(image)]
            k, r, t = (np.reshape(camera[name], shape)
                       for name, shape in [("cam_K", (3, 3)), ("cam_R_w2c", (3, 3)), ("cam_t_w2c", 3)])
            in_camera = positions * 1000 @ r.T + t
            pixels = in_camera @ k.T  # OpenCV's pixels: centres at whole numbers
            np.testing.assert_allclose(pixels[:, 0] / pixels[:, 2], x - 0.5, atol=1e-2)
            np.testing.assert_allclose(pixels[:, 1] / pixels[:, 2], y - 0.5, atol=1e-2)
            for number, gt in enumerate(self.gt[str(image)]):
                r, t = np.reshape(gt["cam_R_m2c"], (3, 3)), np.array(gt["cam_t_m2c"])
                np.testing.assert_allclose(r @ r.T, np.eye(3), atol=1e-5)
                self.assertAlmostEqual(np.linalg.det(r), 1, places=5)
                visible = self.mask("mask_visib", image, number)[y.astype(int), x.astype(int)]
                in_model = (in_camera[visible] - t) @ r
                model = self.models[str(gt["obj_id"])]
                low = np.array([model[f"min_{axis}"] for axis in "xyz"])
                high = low + [model[f"size_{axis}"] for axis in "xyz"]
                self.assertTrue(((in_model > low - 1000 * SNAP) & (in_model < high + 1000 * SNAP)).all())


class Transforms(unittest.TestCase):
    def test_cameras(self):
        """Depth, through the camera as nerfstudio documents it, gives the positions that were rendered."""
        data = read_json(f"{folder(10, 'transforms')}/transforms.json")
        self.assertEqual((data["w"], data["h"], len(data["frames"])), (96, 64, 3))
        self.assertAlmostEqual(np.tan(data["camera_angle_x"] / 2) * data["fl_x"], data["w"] / 2)
        for name, frame in zip(FRAMES, data["frames"]):
            picture = cv2.imread(f"{folder(10, 'transforms')}/{frame['file_path']}", cv2.IMREAD_UNCHANGED)
            self.assertEqual(picture.shape, (64, 96, 4))
            x, y, positions, _ = surfaces(name)
            codes = cv2.imread(f"{folder(10, 'transforms')}/{frame['depth_file_path']}", cv2.IMREAD_UNCHANGED)
            depth = raw(name, "depth")[y.astype(int), x.astype(int)].astype(np.float64)
            self.assertLessEqual(np.abs(codes[y.astype(int), x.astype(int)] / 1000 - depth).max(), 0.00051)
            rays = np.stack([(x - data["cx"]) / data["fl_x"], -(y - data["cy"]) / data["fl_y"], -np.ones_like(x)], -1)
            pose = np.array(frame["transform_matrix"])
            np.testing.assert_allclose((rays * depth[:, None]) @ pose[:3, :3].T + pose[:3, 3], positions, atol=1e-3)


class Cryptomatte(unittest.TestCase):
    """By the published formulas, with an independent MurmurHash3."""

    def bits(self, name):
        hashed = mmh3.hash(name.encode(), signed=False)
        return hashed ^ (1 << 23) if hashed >> 23 & 255 in (0, 255) else hashed

    def test_mattes(self):
        for frame in FRAMES:
            file = OpenEXR.File(f"{folder(11, 'cryptomatte')}/cryptomatte/{frame}.exr", separate_channels=True)
            header, channels = file.header(), {name: c.pixels for name, c in file.channels().items()}
            np.testing.assert_array_equal(channels["R"], half(raw(frame, "color")[..., 0]))
            for layer, source in [("CryptoObject", "id"), ("CryptoMaterial", "material")]:
                key = f"cryptomatte/{mmh3.hash(layer, signed=False):08x}"[:19]
                self.assertEqual(header[f"{key}/name"], layer)
                self.assertEqual(header[f"{key}/hash"], "MurmurHash3_32")
                self.assertEqual(header[f"{key}/conversion"], "uint32_to_float32")
                manifest = json.loads(header[f"{key}/manifest"])
                for name, code in manifest.items():
                    self.assertEqual(int(code, 16), self.bits(name))
                planes = [channels[f"{layer}{i // 4:02}.{'RGBA'[i % 4]}"] for i in range(12)]
                ids = [p.view(np.uint32) for p in planes[::2]]
                shares = planes[1::2]
                for before, after in zip(shares, shares[1:]):
                    self.assertTrue((before >= after).all())
                samples = raw(f"{frame}/samples", source).reshape(64, 3, 96, 3).transpose(0, 2, 1, 3).reshape(64, 96, 9)
                counts = -np.sort([-(samples == value).sum(-1) for value in set(samples.flat) - {0}], 0)
                np.testing.assert_allclose(shares, np.resize(counts[:6], (6, 64, 96)) / 9, atol=1e-6)
                mattes = [sum(np.where(i == int(code, 16), s, 0) for i, s in zip(ids, shares)) for code in manifest.values()]
                ranked = (counts > 0).sum(0) <= 6  # pixels of which no name is left out
                self.assertGreater(ranked.sum(), 6000)
                wanted = [(samples == value).mean(-1) for value in set(samples.flat) - {0}]
                self.assertGreater(len(wanted), 3)
                mattes = [m for m in mattes if m.any()]
                self.assertEqual(len(mattes), len(wanted))
                for want in wanted:
                    self.assertTrue(any(np.abs((matte - want)[ranked]).max() < 1e-6 for matte in mattes))
                self.assertTrue(any(((0 < want) & (want < 1)).any() for want in wanted))


class Points(unittest.TestCase):
    def test_points(self):
        for frame in FRAMES:
            points = PlyData.read(f"{folder(12, 'ply')}/points/{frame}.ply")["vertex"]
            ids = raw(frame, "id")
            shown = ids != 0
            np.testing.assert_array_equal(points["id"], ids[shown])
            picture = cv2.imread(f"{folder(7, 'coco')}/images/{frame}.png", cv2.IMREAD_UNCHANGED)
            for i, names in enumerate([("x", "nx", "red"), ("y", "ny", "green"), ("z", "nz", "blue")]):
                np.testing.assert_array_equal(points[names[0]], raw(frame, "position")[..., i][shown])
                np.testing.assert_array_equal(points[names[1]], raw(frame, "normal")[..., i][shown])
                np.testing.assert_array_equal(points[names[2]], picture[..., 2 - i][shown])


class Video(unittest.TestCase):
    def test_frames(self):
        path = f"{folder(13, 'video')}/video.mp4"
        if not os.path.exists(path):
            self.skipTest("ffmpeg is not installed")
        film = cv2.VideoCapture(path)
        self.assertEqual(film.get(cv2.CAP_PROP_FPS), 12)
        for frame in FRAMES:
            read, picture = film.read()
            self.assertTrue(read)
            wanted = cv2.imread(f"{folder(13, 'video')}/images/{frame}.png")
            self.assertEqual(picture.shape, wanted.shape)
            self.assertGreater(cv2.PSNR(picture, wanted), 25)
        self.assertFalse(film.read()[0])


if __name__ == "__main__":
    unittest.main(warnings="ignore")
