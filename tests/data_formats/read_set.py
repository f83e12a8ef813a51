"""Reads the data set that set_test.cpp wrote, by the readers that people use, and compares with what was rendered."""

import functools
import glob
import json
import os
import subprocess
import sys
import tarfile
import tempfile
import unittest
from pathlib import Path

import cv2
import datumaro
import globox
import h5py
import mmh3
import numpy as np
import OpenEXR
import pycolmap
import webdataset
from plyfile import PlyData
from pycocotools import mask as coco_mask
from pycocotools.coco import COCO
from pypcd4 import PointCloud

SET = os.environ["LATELIGHT_TEST_SET"]
# Metres that a pixel may show of a surface beyond its edge: corners are snapped to parts of a pixel, which on a floor seen
# at a grazing angle are long.
SNAP = 0.01
FRAMES = ["000000", "000001", "000002"]


@functools.lru_cache(maxsize=None)
def raw(frame, name):
    return np.load(f"{SET}/raw/{frame}/{name}.npy")


def read_json(path):
    with open(path, encoding="utf-8") as file:
        return json.load(file)


def folder(name):
    return f"{SET}/{name}"


def half(values):
    """As halves are stored: finite light stays finite."""
    return np.clip(values, -65504, 65504).astype(np.float16)


class Pictures(unittest.TestCase):
    def exr(self, path):
        return OpenEXR.File(path, separate_channels=True)

    def test_files(self):
        for frame in FRAMES:
            channels = self.exr(f"{folder('files-2')}/{frame}.exr").channels()
            for name, single in [("depth", "Z"), ("id", "id")]:
                np.testing.assert_array_equal(np.load(f"{folder('files')}/{frame}.{name}.npy"), raw(frame, name))
                np.testing.assert_array_equal(channels[single].pixels, raw(frame, name))
            np.testing.assert_array_equal(np.load(f"{folder('files')}/{frame}.normal.npy"), raw(frame, "normal"))
            for i, letter in enumerate("XYZ"):
                np.testing.assert_array_equal(channels[f"N.{letter}"].pixels, raw(frame, "normal")[..., i])

    def test_exr(self):
        for frame in FRAMES:
            file = self.exr(f"{folder('exr')}/{frame}.exr")
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
            file = self.exr(f"{folder('exr-2')}/{frame}.exr")
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
            with np.load(f"{folder('npz')}/{frame}.npz") as arrays:
                self.assertEqual(len(arrays.files), 10)
                for name in arrays.files:
                    np.testing.assert_array_equal(arrays[name], raw(frame, name))
                    self.assertEqual(arrays[name].dtype, np.uint32 if name in ("id", "material") else np.float32)

    def test_depth_png(self):
        for name, scale in [("depth-png", 1000), ("depth-png-2", 256)]:
            for frame in FRAMES:
                codes = cv2.imread(f"{folder(name)}/depth/{frame}.png", cv2.IMREAD_UNCHANGED)
                self.assertEqual(codes.dtype, np.uint16)
                depth = raw(frame, "depth").astype(np.float64)
                held = np.isfinite(depth) & (depth * scale < 65535.5)
                self.assertGreater(held.sum(), 1000)
                np.testing.assert_array_equal(codes > 0, held)
                self.assertLessEqual(np.abs(codes[held] / scale - depth[held]).max(), 0.5 / scale + 1e-9)

    def test_flow(self):
        for frame in FRAMES:
            flow = cv2.readOpticalFlow(f"{folder('flow')}/flow/{frame}.flo")
            np.testing.assert_array_equal(flow, raw(frame, "motion")[..., 2:])
            self.assertGreater(np.abs(flow).max(), 0.1)
            bgr = cv2.imread(f"{folder('flow-2')}/flow/{frame}.png", cv2.IMREAD_UNCHANGED)  # as KITTI's development kit
            kitti = (bgr[..., ::-1][..., :2].astype(np.float64) - 2**15) / 64
            valid = bgr[..., 0] == 1
            np.testing.assert_array_equal(valid, (np.abs(flow) < 511).all(-1))
            self.assertLessEqual(np.abs(kitti[valid] - flow[valid]).max(), 1 / 128 + 1e-9)


class Coco(unittest.TestCase):
    def setUp(self):
        stdout, sys.stdout = sys.stdout, open(os.devnull, "w")
        self.coco = COCO(f"{folder('coco')}/annotations/instances.json")
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
            picture = cv2.imread(f"{folder('coco')}/{image['file_name']}", cv2.IMREAD_UNCHANGED)
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


class Annotations(unittest.TestCase):
    """YOLO and Pascal VOC by globox, whose boxes are the edges of pixels; in VOC it keeps numbers of pixels from 1."""

    def setUp(self):
        coco = read_json(f"{folder('coco')}/annotations/instances.json")
        self.names = {a["object"]: a["node"] for a in coco["annotations"]}

    def compare(self, annotations, first, name_of):
        self.assertEqual(len(annotations), len(FRAMES))
        for frame in FRAMES:
            read = annotations[f"{frame}.png"]
            self.assertEqual(tuple(read.image_size), (96, 64))
            ids = raw(frame, "id")
            expected = []
            for value in set(ids.flat) - {0}:
                x, y, width, height = box_of(ids == value)
                expected.append((self.names[value], x + first, y + first, x + width, y + height))
            boxes = [(name_of(b.label), b.xmin, b.ymin, b.xmax, b.ymax) for b in read.boxes]
            self.assertGreater(len(boxes), 5)
            for box, wanted in zip(sorted(boxes), sorted(expected), strict=True):
                self.assertEqual(box[0], wanted[0])
                np.testing.assert_allclose(box[1:], wanted[1:], atol=1e-4)

    def test_yolo(self):
        with open(f"{folder('yolo')}/data.yaml", encoding="utf-8") as file:
            lines = file.read().split("names:\n")[1].splitlines()
        names = {line.split(":")[0].strip(): json.loads(line.split(":", 1)[1]) for line in lines}
        read = globox.AnnotationSet.from_yolo_v5(
            f"{folder('yolo')}/labels", image_folder=f"{folder('yolo')}/images", image_extension=".png")
        self.compare(read, 0, lambda label: names[label])

    def test_voc(self):
        self.compare(globox.AnnotationSet.from_pascal_voc(f"{folder('voc')}/Annotations"), 1, str)


class Kitti(unittest.TestCase):
    """By Datumaro's importer of KITTI's object benchmark."""

    def test_labels(self):
        read = datumaro.Dataset.import_from(folder("kitti"), "kitti3d")
        names = [label.name for label in read.categories()[datumaro.AnnotationType.label]]
        items = {item.id: item for item in read}
        self.assertEqual(sorted(items), FRAMES)
        for frame, item in items.items():
            picture = cv2.imread(f"{folder('coco')}/images/{frame}.png")
            np.testing.assert_array_equal(item.media.data[..., :3], picture)
            self.assertTrue(os.path.exists(item.attributes["calib_path"]))
            boxes = read_json(f"{folder('boxes')}/boxes/{frame}.json")
            ids = raw(frame, "id")
            wanted = {}
            for thing in boxes["objects"]:
                if (ids == thing["id"]).any():
                    wanted[thing["node"].replace(" ", "_")] = thing
            self.assertEqual(sorted(names[box.label] for box in item.annotations), sorted(wanted))
            self.assertGreater(len(wanted), 5)
            for box in item.annotations:
                thing = wanted[names[box.label]]
                x, y, width, height = box_of(ids == thing["id"])
                self.assertEqual(box.get_bbox(), [x, y, width - 1, height - 1])  # from the first pixel to the last one
                space, said = thing["box"], box.attributes
                np.testing.assert_allclose(sorted(said["dimensions"]), sorted(space["size"]), atol=1e-5)
                center = np.array(space["toCamera"])[:3, 3]
                np.testing.assert_allclose(said["location"], center + [0, said["dimensions"][0] / 2, 0], atol=1e-4)
                x, _, z = said["location"]
                turned = said["rotation_y"] - np.arctan2(x, z) - said["alpha"]
                self.assertAlmostEqual(np.cos(turned), 1, places=6)
                shown = thing["visible"]["pixels"] / thing["whole"]["pixelsInPicture"]
                self.assertEqual(said["occluded"], 0 if shown >= 0.8 else 1 if shown >= 0.4 else 2)


class Boxes(unittest.TestCase):
    def setUp(self):
        self.frames = {f: read_json(f"{folder('boxes')}/boxes/{f}.json") for f in FRAMES}

    def test_extents(self):
        hidden = 0
        for frame, boxes in self.frames.items():
            ids = raw(frame, "id")
            for thing in boxes["objects"]:
                visible = ids == thing["id"]
                self.assertEqual(thing["visible"]["pixels"], visible.sum())
                self.assertTrue((coco_mask.decode(thing["visible"]["segmentation"]) == visible).all())
                whole = coco_mask.decode(thing["whole"]["segmentation"])
                self.assertEqual(whole.sum(), thing["whole"]["pixelsInPicture"])
                self.assertTrue((whole[visible] == 1).all())
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
            k = np.array(boxes["camera"]["K"])
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
        self.scene = f"{folder('bop')}/train/000000"
        self.camera, self.gt, self.info = (
            read_json(f"{self.scene}/{name}.json") for name in ("scene_camera", "scene_gt", "scene_gt_info"))
        self.models = read_json(f"{folder('bop')}/models/models_info.json")

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
            pixels = in_camera @ k.T  # OpenCV's pixels: centers at whole numbers
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
        data = read_json(f"{folder('transforms')}/transforms.json")
        self.assertEqual((data["w"], data["h"], len(data["frames"])), (96, 64, 3))
        self.assertAlmostEqual(np.tan(data["camera_angle_x"] / 2) * data["fl_x"], data["w"] / 2)
        for name, frame in zip(FRAMES, data["frames"]):
            picture = cv2.imread(f"{folder('transforms')}/{frame['file_path']}", cv2.IMREAD_UNCHANGED)
            self.assertEqual(picture.shape, (64, 96, 4))
            x, y, positions, _ = surfaces(name)
            codes = cv2.imread(f"{folder('transforms')}/{frame['depth_file_path']}", cv2.IMREAD_UNCHANGED)
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
            file = OpenEXR.File(f"{folder('cryptomatte')}/cryptomatte/{frame}.exr", separate_channels=True)
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
            points = PlyData.read(f"{folder('ply')}/points/{frame}.ply")["vertex"]
            ids = raw(frame, "id")
            shown = ids != 0
            np.testing.assert_array_equal(points["id"], ids[shown])
            picture = cv2.imread(f"{folder('coco')}/images/{frame}.png", cv2.IMREAD_UNCHANGED)
            for i, names in enumerate([("x", "nx", "red"), ("y", "ny", "green"), ("z", "nz", "blue")]):
                np.testing.assert_array_equal(points[names[0]], raw(frame, "position")[..., i][shown])
                np.testing.assert_array_equal(points[names[1]], raw(frame, "normal")[..., i][shown])
                np.testing.assert_array_equal(points[names[2]], picture[..., 2 - i][shown])

class Lidar(unittest.TestCase):
    """The same scans in each file format, by readers that others wrote."""

    @classmethod
    def setUpClass(cls):
        cls.folder = tempfile.TemporaryDirectory()
        sensor = {"type": "vlp-16", "rate": 20}
        formats = [{"format": "lidar", "sensor": sensor, "samples": 4, "returns": "all", "as": kind,
                    "scans": f"lidar/{kind}.json"} for kind in ("ply", "pcd", "bin", "npz")]  # fmt: skip
        job = {"scenes": "builtin:boxes", "output": f"{cls.folder.name}/set", "formats": formats,
               "options": {"size": "64x48"}}  # fmt: skip
        path = f"{cls.folder.name}/job.json"
        Path(path).write_text(json.dumps(job))
        subprocess.run([os.environ["LATELIGHT_PROGRAM"], "batch", path, "--devices", "cpu"], check=True)
        cls.points = np.load(f"{cls.folder.name}/set/lidar/000000.npz")

    @classmethod
    def tearDownClass(cls):
        cls.folder.cleanup()

    def path(self, kind):
        return f"{self.folder.name}/set/lidar/000000.{kind}"

    def test_npz(self):
        names = ["x", "y", "z", "intensity", "time", "ring", "range", "echo", "firing", "id", "part", "material"]
        self.assertEqual(list(self.points), names)
        count = json.loads(Path(f"{self.folder.name}/set/lidar/npz.json").read_text())["scans"][0]["points"]
        self.assertGreater(count, 1000)
        for name in names:
            self.assertEqual(self.points[name].shape, (count,))
        away = np.sqrt(sum(self.points[axis].astype(np.float64) ** 2 for axis in "xyz"))
        np.testing.assert_allclose(away, self.points["range"], rtol=1e-6)
        self.assertGreater(self.points["echo"].max(), 0)

    def test_ply(self):
        vertices = PlyData.read(self.path("ply"))["vertex"]
        for name in self.points:
            np.testing.assert_array_equal(vertices[name], self.points[name])
            self.assertEqual(vertices[name].dtype, self.points[name].dtype)

    def test_pcd(self):
        cloud = PointCloud.from_path(self.path("pcd"))
        self.assertEqual(list(cloud.fields), list(self.points))
        for name in self.points:
            np.testing.assert_array_equal(cloud.pc_data[name], self.points[name])
            self.assertEqual(cloud.pc_data[name].dtype, self.points[name].dtype)

    def test_kitti(self):
        rows = np.fromfile(self.path("bin"), np.float32).reshape(-1, 4)
        for i, name in enumerate(("x", "y", "z", "intensity")):
            np.testing.assert_array_equal(rows[:, i], self.points[name])


class Video(unittest.TestCase):
    def test_frames(self):
        path = f"{folder('video')}/video.mp4"
        if not os.path.exists(path):
            self.skipTest("ffmpeg is not installed")
        film = cv2.VideoCapture(path)
        self.assertEqual(film.get(cv2.CAP_PROP_FPS), 12)
        for frame in FRAMES:
            read, picture = film.read()
            self.assertTrue(read)
            wanted = cv2.imread(f"{folder('video')}/images/{frame}.png")
            self.assertEqual(picture.shape, wanted.shape)
            self.assertGreater(cv2.PSNR(picture, wanted), 25)
        self.assertFalse(film.read()[0])


def camera_of(data_name):
    """K in pixels with centers at half-integers, and the poses of the frames in OpenCV's camera frame, by nerfstudio's file."""
    data = read_json(f"{folder(data_name)}/transforms.json")
    k = np.array([[data["fl_x"], 0, data["cx"]], [0, data["fl_y"], data["cy"]], [0, 0, 1]])
    return k, [np.array(frame["transform_matrix"]) @ np.diag([1, -1, -1, 1]) for frame in data["frames"]]


@unittest.skipUnless(os.path.exists(folder("hdf5")), "the HDF5 library is not installed")
class Hdf5(unittest.TestCase):
    """With h5py, by the conventions of BlenderProc's writer and of its script visHdf5Files.py."""

    def setUp(self):
        self.files = [h5py.File(f"{folder('hdf5')}/{i}.hdf5", "r") for i in range(3)]

    def tearDown(self):
        for file in self.files:
            file.close()

    def test_types(self):
        for file in self.files:
            for key, dtype, shape in [("colors", np.uint8, (64, 96, 3)), ("depth", np.float32, (64, 96)),
                                      ("distance", np.float32, (64, 96)), ("normals", np.float32, (64, 96, 3)),
                                      ("diffuse", np.float32, (64, 96, 3)), ("nocs", np.float32, (64, 96, 4)),
                                      ("category_id_segmaps", np.uint8, (64, 96)),
                                      ("forward_flow", np.float32, (64, 96, 2)), ("backward_flow", np.float32, (64, 96, 2))]:
                self.assertEqual((file[key].dtype, file[key].shape, file[key].compression), (dtype, shape, "gzip"))
            self.assertEqual(file["instance_segmaps"].shape, (64, 96))
            self.assertEqual(file["instance_attribute_maps"].dtype.char, "S")

    def test_values(self):
        k, poses = camera_of("transforms")
        for name, pose, file in zip(FRAMES, poses, self.files):
            depth = raw(name, "depth")
            np.testing.assert_array_equal(file["depth"][()], np.where(np.isinf(depth), np.float32(1e10), depth))
            np.testing.assert_array_equal(file["diffuse"][()], raw(name, "albedo"))
            np.testing.assert_array_equal(file["nocs"][..., :3], raw(name, "nocs"))
            np.testing.assert_array_equal(file["nocs"][..., 3], raw(name, "id") > 0)
            np.testing.assert_array_equal(file["forward_flow"][()], raw(name, "motion")[..., 2:])
            np.testing.assert_array_equal(file["backward_flow"][()], raw(name, "motion")[..., :2])
            rgba = cv2.imread(f"{folder('coco')}/images/{name}.png", cv2.IMREAD_UNCHANGED).astype(np.int64)
            np.testing.assert_array_equal(file["colors"][()], (rgba[..., 2::-1] * rgba[..., 3:] + 127) // 255)
            # BlenderProc multiplies by the inverse of the pose of Blender's camera, which looks along -Z.
            blender = pose[:3, :3] @ np.diag([1, -1, -1])
            np.testing.assert_allclose(file["normals"][()], raw(name, "normal") @ blender * 0.5 + 0.5, atol=1e-6)
            state, = json.loads(np.array(file["campose"]).tobytes())
            np.testing.assert_allclose(np.array(state["cam_K"]) + [[0, 0, 0.5], [0, 0, 0.5], [0, 0, 0]], k)
            np.testing.assert_allclose(state["cam2world_matrix"], pose @ np.diag([1, -1, -1, 1]), atol=1e-6)
            self.assertAlmostEqual(np.tan(state["fov_x"] / 2) * k[0, 0], 48)

    def test_maps(self):
        paths = {}
        for name, file in zip(FRAMES, self.files):
            ids, instances, categories = raw(name, "id"), file["instance_segmaps"][()], file["category_id_segmaps"][()]
            entries = json.loads(np.array(file["instance_attribute_maps"]).tobytes())
            self.assertEqual([e["idx"] for e in entries], sorted(set(instances.flat)))
            for entry in entries:
                mask = instances == entry["idx"]
                self.assertEqual(len(set(ids[mask])), 1)
                self.assertEqual(set(categories[mask]), {entry["category_id"]})
                self.assertEqual(paths.setdefault(entry["idx"], entry["name"]), entry["name"])
            self.assertEqual(len(entries), len(set(ids.flat)))
            self.assertGreater(len({e["category_id"] for e in entries}), 3)


class Scannet(unittest.TestCase):
    """As the community's loaders read the folders that SensReader unpacks."""

    scan = f"{folder('scannet')}/scans/scene0000_00"

    def setUp(self):
        if not os.path.exists(self.scan):
            self.fail("there is no scan")

    def test_files(self):
        self.assertEqual(sorted(os.listdir(self.scan)),
                         ["color", "depth", "instance", "intrinsic", "label", "labels.tsv", "pose"])
        numbers = sorted(int(name.split(".")[0]) for name in os.listdir(f"{self.scan}/color"))
        self.assertEqual(numbers, [0, 1, 2])

    def test_points(self):
        """Depth, through the intrinsics and the pose, gives the positions that were rendered."""
        k = np.loadtxt(f"{self.scan}/intrinsic/intrinsic_depth.txt")
        np.testing.assert_array_equal(k, np.loadtxt(f"{self.scan}/intrinsic/intrinsic_color.txt"))
        for number, name in enumerate(FRAMES):
            x, y, positions, _ = surfaces(name)
            at = (y.astype(int), x.astype(int))
            depth = cv2.imread(f"{self.scan}/depth/{number}.png", cv2.IMREAD_UNCHANGED)[at] / 1000
            pose = np.loadtxt(f"{self.scan}/pose/{number}.txt")
            points = np.stack([(at[1] - k[0, 2]) / k[0, 0], (at[0] - k[1, 2]) / k[1, 1], np.ones_like(x)], -1) * depth[:, None]
            np.testing.assert_allclose(points @ pose[:3, :3].T + pose[:3, 3], positions, atol=2e-3)

    def test_images(self):
        with open(f"{self.scan}/labels.tsv", encoding="utf-8") as file:
            rows = [line.rstrip("\n").split("\t") for line in file]
        self.assertEqual(rows[0], ["id", "raw_category", "category"])
        self.assertEqual([int(row[0]) for row in rows[1:]], list(range(1, len(rows))))
        for number, name in enumerate(FRAMES):
            color = cv2.imread(f"{self.scan}/color/{number}.jpg")
            picture = cv2.imread(f"{folder('coco')}/images/{name}.png")
            self.assertGreater(cv2.PSNR(color, picture), 35)
            ids = raw(name, "id")
            for kind, source in [("instance", ids), ("label", raw(name, "material"))]:
                image = cv2.imread(f"{self.scan}/{kind}/{number}.png", cv2.IMREAD_UNCHANGED)
                self.assertIn(image.dtype, (np.uint8, np.uint16))
                np.testing.assert_array_equal(image == 0, ids == 0)
                pairs = {(int(a), int(b)) for a, b in zip(image.flat, source.flat)}
                if kind == "instance":
                    self.assertEqual(len(pairs), len(set(ids.flat)))
                else:
                    self.assertLess(int(image.max()), len(rows))


class Colmap(unittest.TestCase):
    """With COLMAP's own library."""

    def models(self):
        return {kind: pycolmap.Reconstruction(f"{folder(name)}/sparse/0")
                for kind, name in [("binary", "colmap"), ("text", "colmap-2")]}

    def test_cameras(self):
        k, poses = camera_of("transforms")
        for model in self.models().values():
            self.assertEqual((model.num_cameras(), model.num_reg_images()), (1, 3))
            np.testing.assert_allclose(model.cameras[1].calibration_matrix(), k, rtol=1e-9)
            for number, pose in enumerate(poses):
                image = model.images[number + 1]
                self.assertEqual(image.name, f"{FRAMES[number]}.png")
                self.assertTrue(os.path.exists(f"{folder('colmap')}/images/{image.name}"))
                np.testing.assert_allclose(image.cam_from_world().matrix(), np.linalg.inv(pose)[:3], atol=1e-6)

    def test_points(self):
        """Points are surfaces, and lie at the pixels of their tracks in every image of these."""
        for model in self.models().values():
            self.assertGreater(model.num_points3D(), 200)
            observations = 0
            for point in list(model.points3D.values())[::5]:
                self.assertGreaterEqual(point.track.length(), 2)
                for element in point.track.elements:
                    image = model.images[element.image_id]
                    seen = image.points2D[element.point2D_idx].xy
                    np.testing.assert_allclose(image.project_point(point.xyz), seen, atol=1e-6)
                    position = raw(FRAMES[element.image_id - 1], "position")[int(seen[1]), int(seen[0])]
                    depth = raw(FRAMES[element.image_id - 1], "depth")[int(seen[1]), int(seen[0])]
                    # Within 1 % of the depth along the ray, and half a pixel beside it.
                    self.assertLess(np.linalg.norm(position - point.xyz), 0.05 * depth)
                    observations += 1
            self.assertGreater(observations, 100)
            self.assertGreater(model.compute_mean_track_length(), 2.3)
            self.assertLess(model.compute_mean_reprojection_error(), 1e-6)
        binary, text = self.models().values()
        for number, point in binary.points3D.items():
            np.testing.assert_allclose(text.points3D[number].xyz, point.xyz, rtol=1e-12)
            np.testing.assert_array_equal(text.points3D[number].color, point.color)

    def test_new_points_have_their_pixels_color(self):
        model = self.models()["binary"]
        picture = cv2.imread(f"{folder('colmap')}/images/{FRAMES[0]}.png")
        centers = 0
        for point in model.points3D.values():
            first = point.track.elements[0]
            x, y = model.images[first.image_id].points2D[first.point2D_idx].xy
            if first.image_id == 1 and abs(x % 4 - 2.5) < 1e-6 and abs(y % 4 - 2.5) < 1e-6:
                np.testing.assert_array_equal(point.color, picture[int(y), int(x), ::-1])
                centers += 1
        self.assertGreater(centers, 100)

    def test_depth_maps(self):
        """As read_write_dense.py of COLMAP reads them."""
        for name in FRAMES:
            with open(f"{folder('colmap')}/stereo/depth_maps/{name}.png.geometric.bin", "rb") as file:
                width, height, channels = (int(number) for number in file.read(64).split(b"&")[:3])
                file.seek(len(f"{width}&{height}&{channels}&"))
                depth = np.fromfile(file, np.float32).reshape((width, height, channels), order="F").transpose(1, 0, 2)[..., 0]
            wanted = raw(name, "depth")
            np.testing.assert_array_equal(depth, np.where(np.isinf(wanted), 0, wanted))


class SparsePoints(unittest.TestCase):
    def test_nerfstudios_points(self):
        """transforms.json names a PLY file, whose points are those of COLMAP's model and others that one image shows."""
        data = read_json(f"{folder('transforms-2')}/transforms.json")
        points = PlyData.read(f"{folder('transforms-2')}/{data['ply_file_path']}")["vertex"]
        found = np.stack([points["x"], points["y"], points["z"]], -1)
        self.assertEqual({points[name].dtype for name in ("red", "green", "blue")}, {np.dtype(np.uint8)})
        for point in list(pycolmap.Reconstruction(f"{folder('colmap')}/sparse/0").points3D.values())[::10]:
            self.assertLess(np.linalg.norm(found - point.xyz, axis=1).min(), 0.3)
        surface = np.concatenate([surfaces(name)[2] for name in FRAMES])
        for point in found[::20]:
            self.assertLess(np.linalg.norm(surface - point, axis=1).min(), 2e-3)


class WebDatasets(unittest.TestCase):
    def read(self, name, shards):
        path = f"{folder(name)}/shards/{{000000..{shards - 1:06}}}.tar"
        return list(webdataset.WebDataset(path, shardshuffle=False).decode("rgb"))

    def test_samples(self):
        samples = self.read("webdataset", 2)
        self.assertEqual([sample["__key__"] for sample in samples], FRAMES)
        self.assertEqual(sorted(os.listdir(f"{folder('webdataset')}/shards")), [".frames", "000000.tar", "000001.tar"])
        for name, sample in zip(FRAMES, samples):
            self.assertEqual(set(sample) - {"__key__", "__url__", "__local_path__"}, {"rgb.png", "depth.npy", "id.npy", "json"})
            np.testing.assert_array_equal(sample["depth.npy"], raw(name, "depth"))
            np.testing.assert_array_equal(sample["id.npy"], raw(name, "id"))
            self.assertEqual(sample["rgb.png"].shape, (64, 96, 3))
            self.assertEqual(sample["json"]["aovs"]["depth"]["file"], f"{name}.depth.npy")

    def test_files(self):
        """Python's tarfile, which checks all sums, finds regular files without times and owners."""
        with tarfile.open(f"{folder('webdataset-2')}/shards/000000.tar") as tar:
            members = tar.getmembers()
            self.assertEqual([m.name for m in members], [f"{n}.{e}" for n in FRAMES for e in ("depth.exr", "json")])
            for member in members:
                self.assertTrue(member.isfile())
                self.assertEqual((member.mtime, member.uid, member.gid, member.mode), (0, 0, 0, 0o644))


if __name__ == "__main__":
    unittest.main(warnings="ignore")
