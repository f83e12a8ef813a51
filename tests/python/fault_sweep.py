"""fault_sweep.py FOLDER WORK STEPS KIND...: one call after another fails, while Python calls the package.

WORK is a name of WORKS. KIND is a kind of tests/faults/library ("new", "open", ...), the name of a Vulkan call, or
"lose", which loses the device at a submission. Each fault must raise an error of the package, with one sentence, or have
no effect on the result. Then the same work succeeds with its usual bytes, nothing is left in the folder, and the process
holds no more than before. STEPS faults are spread over all calls of a kind, or are the first ones of a Vulkan call; for
0, each call fails. Each allocation fails in a child process, because destructors that allocate would end the process,
as those of JSON values do (docs/quality.md). The environment is that of test_faults.py."""

import ctypes
import os
import sys
import traceback
from pathlib import Path

import latelight
import numpy as np

from footprint import check, footprint

LIBRARY = b"liblatelight.so.0.2"
FILE_KINDS = ("open", "read", "write", "close", "rename", "stat")
libc = ctypes.CDLL(None)
libc.getenv.restype = ctypes.c_char_p


def camera(scene):
    return scene.look_at((3, -4, 2), (0, 0, 0.5))


# --- works: each returns arrays, or files that it wrote -------------------------------------------------------------------------------------------------------


def build(folder, device):
    """A scene of arrays; elements that the scene did not accept leave it as it was."""
    scene = latelight.Scene()
    mesh = scene.add_mesh(np.eye(3, dtype=np.float32), name="triangle")
    material = scene.add_material(latelight.Material(name="paint", roughness=0.5))
    scene.set_texture(material, "base_color", scene.add_texture(np.full((4, 4, 3), 200, np.uint8)))
    scene.add_instance(mesh, material, np.eye(4), "one")
    scene.add_light(latelight.Light(position=(0, 2, 3), intensity=30))
    return [scene.mesh_arrays(mesh)["positions"], np.array(scene.bounds), len(scene.nodes)]


def load(folder, device):
    scene = latelight.Scene(folder / "boxes.glb")
    return [np.array(scene.bounds), len(scene.instances())]


def export(folder, device):
    latelight.Scene("builtin:boxes").export(folder / "out.glb")
    return [folder / "out.glb"]


def render(folder, device):
    scene = latelight.Scene("builtin:boxes")
    renderer = latelight.Renderer(scene, device)
    frame = renderer.render(camera(scene), (24, 16), ("rgba", "depth", "id"))
    return [frame["rgba"], frame["depth"], frame["id"]]


def worlds(folder, device):
    scene = latelight.Scene("builtin:boxes")
    renderer = latelight.Renderer(scene, device)
    moved = np.tile(np.eye(4), (2, 1, 1, 1))
    moved[:, 0, 0, 3] = (0, 0.5)
    frames = renderer.render_worlds(
        2, camera(scene), (24, 16), "depth", instances=scene.instances()[:1], transforms=moved
    )
    return [frames["depth"]]


def tickets(folder, device):
    scene = latelight.Scene("builtin:boxes")
    renderer = latelight.Renderer(scene, device)
    frame = renderer.submit(camera(scene), (24, 16), "depth")
    rays = np.full((8, 3), (3, -4, 2)), np.linspace((-1, 1, -0.5), (-0.5, 1, -0.4), 8)
    hits = renderer.submit_cast(*rays)
    moved = np.tile(np.eye(4), (2, 1, 1, 1))
    moved[:, 0, 0, 3] = (0, 0.5)
    in_worlds = renderer.submit_cast_worlds(2, *np.stack([rays, rays], 1), instances=scene.instances()[:1],
                                            transforms=moved)
    return [hits.take()["distance"], frame.take()["depth"], in_worlds.take()["distance"]]


def edit(folder, device):
    """Edits of a scene that a renderer shows. After a call that failed, it renders what a new renderer does."""
    scene = latelight.Scene("builtin:boxes")
    view = camera(scene)

    def show(renderer):
        frame = renderer.render(view, (24, 16), ("rgba", "depth", "material"))
        return [frame[name] for name in frame]

    renderer = latelight.Renderer(scene, device)
    images = show(renderer)
    box, other = scene.instances()[:2]
    moved, far = np.eye(4), np.eye(4)
    moved[2, 3], far[0, 3] = 0.25, 1e6
    try:
        scene.set_transform(box, moved)
        images += show(renderer)
        mesh = scene.add_mesh(np.eye(3, dtype=np.float32), name="triangle")
        paint = scene.add_material(latelight.Material(name="paint", roughness=0.5))
        scene.set_texture(paint, "base_color", scene.add_texture(np.full((4, 4, 3), 200, np.uint8)))
        triangle = scene.add_instance(mesh, paint, np.eye(4), "one")
        light = scene.add_light(latelight.Light(position=(0, 2, 3), intensity=30))
        images += show(renderer)
        scene.set_mesh(mesh, 2 * np.eye(3, dtype=np.float32))
        scene.assign_material(box, paint)
        scene.set_transform(other, far)
        images += show(renderer)
        scene.remove_light(light)
        scene.remove_instance(triangle)
        scene.remove_instance(box)
        images += show(renderer)
    except latelight.OutOfMemoryError:
        start("none", 0)
        images = zip(show(renderer), show(latelight.Renderer(scene, device)), strict=True)
        assert all(np.array_equal(one, another) for one, another in images), "the next image differs"
        raise
    return images


WORKS = {work.__name__: work for work in (build, load, export, render, worlds, tickets, edit)}


# --- faults -----------------------------------------------------------------------------------------------------------


def start(kind, number):
    """Lets a call fail, 0: none. Returns the number of calls since the last start, of kinds that are counted."""
    if kind == "lose":
        set_variable("LATELIGHT_LOSE_SUBMISSION", str(number) if number else None)
    elif kind.startswith("vk"):
        set_variable("LATELIGHT_FAIL_CALL", f"{kind} {number}" if number else "none 0")
    else:
        return libc.latelight_fault(f"{kind} {number}".encode(), LIBRARY)
    return 0


def set_variable(name, value):
    """The layer removes the variable when the call fails, which os.environ does not see."""
    libc.unsetenv(name.encode())
    if value is not None:
        libc.setenv(name.encode(), value.encode(), 1)


def has_failed(kind):
    if kind == "lose":
        return libc.getenv(b"LATELIGHT_LOSE_SUBMISSION") is None
    return libc.getenv(b"LATELIGHT_FAIL_CALL") is None


def promised(kind):
    if kind == "lose":
        return latelight.DeviceLostError
    # Files that can't be read are InputError; those that can't be written, LatelightError.
    return latelight.LatelightError if kind in FILE_KINDS else latelight.OutOfMemoryError


class Sweep:
    def __init__(self, folder, work, kind, device="cpu"):
        self.folder, self.work, self.kind, self.device = folder, work, kind, device
        self.files = sorted(folder.iterdir())
        self.expected = self.result()

    def result(self):
        values = self.work(self.folder, self.device)
        self.calls = start("none", 0)
        for i, value in enumerate(values):
            if isinstance(value, Path):
                values[i] = np.frombuffer(value.read_bytes(), np.uint8)
                value.unlink()
        return values

    def is_expected(self, result):
        return all(np.array_equal(a, b) for a, b in zip(result, self.expected, strict=True))

    def fail_at(self, number):
        """Raises AssertionError if a promise is broken. Returns whether the work raised an error, and whether a call failed."""
        where = f"{self.kind} {number} of {self.work.__name__}"
        raised = False
        start(self.kind, number)
        try:
            assert self.is_expected(self.result()), f"{where}: the result differs"
        except promised(self.kind) as error:
            start("none", 0)
            raised = True
            assert str(error) and "\n" not in str(error), f"{where}: not one sentence: {error!r}"
        assert sorted(self.folder.iterdir()) == self.files, f"{where}: a file remains"
        failed = not self.is_layered() or has_failed(self.kind)
        if self.is_layered():
            start(self.kind, 0)
        assert self.is_expected(self.result()), f"{where}: the next result differs"
        return raised, failed

    def is_layered(self):
        return self.kind == "lose" or self.kind.startswith("vk")

    def numbers(self, steps):
        """The calls of the layer are not counted: a sweep goes on until none fails."""
        if self.is_layered():
            yield from range(1, (steps or 1000) + 1)
            return
        start(self.kind, 0)
        self.result()
        last = self.calls
        steps = min(steps or last, last)
        yield from sorted({1 + i * (last - 1) // max(steps - 1, 1) for i in range(steps)})

    def run(self, steps):
        """Returns the numbers of faults and of errors, and of allocations that ended the process."""
        faults = errors = ended = 0
        footprints = []
        for number in self.numbers(steps):
            if self.kind == "new":
                raised, has_ended = in_child(lambda: self.fail_at(number)[0])
                ended += has_ended
            else:
                raised, failed = self.fail_at(number)
                if not failed:
                    break
                footprints.append(footprint())
            faults, errors = faults + 1, errors + raised
        late = footprints[len(footprints) // 5 :]
        for sentence in check(late, 1000) if len(late) >= 12 else ():
            print(sentence)
        return faults, errors, ended


def in_child(call):
    """Returns what `call` does in a child process, as a bool, and whether a signal ended the child."""
    child = os.fork()
    if child == 0:
        try:
            os._exit(10 if call() else 0)
        except BaseException:
            traceback.print_exc()
            os._exit(1)
    status = os.waitpid(child, 0)[1]
    assert os.WIFSIGNALED(status) or os.WEXITSTATUS(status) in (0, 10), "a promise was broken"
    return os.WIFEXITED(status) and os.WEXITSTATUS(status) == 10, os.WIFSIGNALED(status)


def main():
    folder, work, steps = Path(sys.argv[1]), WORKS[sys.argv[2]], int(sys.argv[3])
    for kind in sys.argv[4:]:
        faults, errors, ended = Sweep(folder, work, kind).run(steps)
        print(f"{kind}: {faults} faults, {errors} errors, {ended} ended", flush=True)


if __name__ == "__main__":
    main()
