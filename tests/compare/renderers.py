"""Many views of one scene in one process: latelight on the CPU beside other renderers from PyPI, frame by frame in turn.

    python3 -m venv /tmp/compare
    /tmp/compare/bin/pip install pyrender==0.1.45 open3d==0.20.0 f3d==4.0.0
    /tmp/compare/bin/pip install --no-deps PyOpenGL==3.1.10   # pyrender's own pin does not know OSMesa's contexts
    sudo apt-get install libosmesa6
    PYTHONPATH=build/release/python /tmp/compare/bin/python tests/compare/renderers.py DamagedHelmet.glb --pictures out

Each renderer has a process of its own, which renders while the others wait. A view is what the renderer can give of
color, depth, ids and normals. Processor time, of all threads, says more than elapsed time where others use the machine.
--together 8 renders as many views per turn, Latelight in one call and the others one after another.
--baseline build/before/python adds the package of another build, to compare two versions in one run.
"""

import argparse
import math
import multiprocessing
import os
import statistics
import sys
import time

FOV = 45.0  # degrees, vertical


def look_at(eye, target):
    """Camera to world as OpenGL has it, with +Y up."""
    import numpy as np

    back = np.subtract(eye, target)
    back = back / np.linalg.norm(back)
    right = np.cross([0.0, 1.0, 0.0], back)
    right = right / np.linalg.norm(right)
    pose = np.eye(4)
    pose[:3, 0], pose[:3, 1], pose[:3, 2], pose[:3, 3] = right, np.cross(back, right), back, eye
    return pose


class OneByOne:
    """A renderer of a view per call."""

    def render_all(self, eyes, target):
        return [self.render(eye, target) for eye in eyes][-1]


class Latelight:
    gives = "color, depth, ids, normals"

    def __init__(self, path, size):
        import latelight

        self.size = size
        self.scene = latelight.Scene(path)
        self.renderer = latelight.Renderer(self.scene, device="cpu")

    def render_all(self, eyes, target):
        cameras = [self.scene.look_at(eye=eye, target=target, vertical_fov=FOV) for eye in eyes]
        frames = self.renderer.render(cameras, self.size, ("rgba", "depth", "id", "normal"))
        return frames[-1]["rgba"][..., :3]


class Pyrender(OneByOne):
    gives = "color and depth, then ids; no normals"

    def __init__(self, path, size):
        os.environ["PYOPENGL_PLATFORM"] = "osmesa"
        import numpy as np

        np.infty = np.inf  # which NumPy 2 no longer has
        import pyrender
        import trimesh

        self.scene = pyrender.Scene.from_trimesh_scene(trimesh.load(path))
        self.flags = pyrender.RenderFlags.SEG
        self.colors = {node: (i % 256, i // 256, 1) for i, node in enumerate(self.scene.mesh_nodes)}
        camera = pyrender.PerspectiveCamera(yfov=math.radians(FOV), aspectRatio=size[0] / size[1])
        self.moving = [self.scene.add(camera), self.scene.add(pyrender.DirectionalLight(intensity=4))]
        self.renderer = pyrender.OffscreenRenderer(*size)

    def render(self, eye, target):
        for node in self.moving:
            self.scene.set_pose(node, look_at(eye, target))
        color, _ = self.renderer.render(self.scene)
        self.renderer.render(self.scene, flags=self.flags, seg_node_map=self.colors)
        return color


class Open3d(OneByOne):
    gives = "color, then depth; no ids, no normals"

    def __init__(self, path, size):
        os.environ["OPEN3D_CPU_RENDERING"] = "true"
        os.environ["EGL_PLATFORM"] = "surfaceless"
        import open3d

        self.renderer = open3d.visualization.rendering.OffscreenRenderer(*size)
        self.renderer.scene.add_model("scene", open3d.io.read_triangle_model(path))

    def render(self, eye, target):
        import numpy as np

        self.renderer.setup_camera(FOV, target, eye, [0, 1, 0])
        color = np.asarray(self.renderer.render_to_image())
        np.asarray(self.renderer.render_to_depth_image(z_in_view_space=True))
        return color


class F3d(OneByOne):
    gives = "color; no depth, no ids, no normals"

    def __init__(self, path, size):
        import f3d

        f3d.Log.set_verbose_level(f3d.Log.WARN)
        f3d.Engine.autoload_plugins()
        self.engine = f3d.Engine.create_osmesa()
        self.engine.options.update({"ui.loader_progress": False, "render.grid.enable": False})
        self.engine.window.size = size
        self.engine.scene.add(path)

    def render(self, eye, target):
        import numpy as np

        camera = self.engine.window.camera
        camera.position, camera.focal_point, camera.view_up, camera.view_angle = eye, target, (0, 1, 0), FOV
        image = self.engine.window.render_to_image()
        rows = np.frombuffer(image.content, dtype=np.uint8).reshape(image.height, image.width, image.channel_count)
        return rows[::-1, :, :3]


RENDERERS = {"latelight": Latelight, "pyrender": Pyrender, "open3d": Open3d, "f3d": F3d}
BASELINE = "latelight, baseline"


def work(pipe, name, package, path, size, pictures):
    """The process of one renderer: answers places of the eye with the seconds that their views took."""
    if package:
        sys.path.insert(0, package)
    begin = time.perf_counter()
    renderer = RENDERERS[name](path, size)
    first = True
    for eyes, target in iter(pipe.recv, None):
        elapsed, processor = time.perf_counter(), time.process_time()
        color = renderer.render_all(eyes, target)
        pipe.send((time.perf_counter() - (begin if first else elapsed), time.process_time() - processor))
        if first and pictures:
            from PIL import Image

            Image.fromarray(color).save(os.path.join(pictures, f"{name}{'-baseline' if package else ''}.png"))
        first = False


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("scene")
    parser.add_argument("--size", default="640x480")
    parser.add_argument("--views", type=int, default=20, help="number of turns")
    parser.add_argument("--together", type=int, default=1, help="views per turn")
    parser.add_argument("--distance", type=float, default=3.2, help="of the eye from the origin, meters")
    parser.add_argument("--renderers", default=",".join(RENDERERS))
    parser.add_argument("--baseline", metavar="FOLDER", help="the folder of the package latelight of another build")
    parser.add_argument("--pictures", help="folder for one picture by each, to look at")
    args = parser.parse_args()
    size = tuple(int(side) for side in args.size.split("x"))
    if args.pictures:
        os.makedirs(args.pictures, exist_ok=True)

    context = multiprocessing.get_context("spawn")
    workers = {}
    names = [(name, name, None) for name in args.renderers.split(",")]
    if args.baseline:
        names.append((BASELINE, "latelight", args.baseline))
    for label, name, package in names:
        pipe, theirs = context.Pipe()
        started = (theirs, name, package, args.scene, size, args.pictures)
        context.Process(target=work, args=started, daemon=True).start()
        workers[label] = (pipe, [])
        turn(*workers[label], args, 0)  # loads, and warms up, before the next begins
    for view in range(args.views + 1):
        for pipe, taken in workers.values():
            turn(pipe, taken, args, view)
    for pipe, _ in workers.values():
        pipe.send(None)

    # Other load changes both times of a view alike, so ratios are those of views that follow each other.
    print(
        f"| {args.size}, {args.views} turns of {args.together} | elapsed, ms per view | processor, ms per view "
        "| elapsed, relative to the first | processor, relative to the first | start to first array, s | output |"
    )
    print("|---|---|---|---|---|---|---|")
    first = next(iter(workers.values()))[1]
    for name, (_, taken) in workers.items():
        elapsed, processor = (1000 * statistics.median(column) / args.together for column in zip(*taken[2:]))
        ratios = [[own / base for own, base in zip(*pair)] for pair in zip(taken[2:], first[2:])]
        longer, more = (statistics.median(column) for column in zip(*ratios))
        print(
            f"| {name} | {elapsed:.1f} | {processor:.1f} | {longer:.2f} | {more:.2f} | {taken[0][0]:.2f} "
            f"| {RENDERERS[name.split(',')[0]].gives} |"
        )


def turn(pipe, taken, args, view):
    angles = [math.radians(20 + 7 * (view + i)) for i in range(args.together)]
    d = args.distance
    eyes = [[d * math.sin(angle), 0.25 * d, d * math.cos(angle)] for angle in angles]
    pipe.send((eyes, [0.0, 0.0, 0.0]))
    taken.append(pipe.recv())


if __name__ == "__main__":
    main()
