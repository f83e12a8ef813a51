"""long_life.py OPERATIONS [DEVICE] [LOG]: a process that lives long. It edits scenes, renders pictures, worlds and rays,
drops tickets, replaces renderers and makes mistakes, all at random, and must hold no more in the end than before.

An epoch begins with a new scene and a new renderer, and ends without any. Its footprint is what the process then holds;
the log has a line per epoch. check() compares the epochs."""

import ctypes
import gc
import math
import os
import random
import statistics
import sys
from collections import Counter
from dataclasses import dataclass, fields
from pathlib import Path

import latelight
import numpy as np

OPERATIONS = 250  # per epoch
MAX_ADDED = 10  # elements of each kind
OUTPUTS = ("depth", "normal", "id", "material", "motion", "position", "color")


# --- footprint --------------------------------------------------------------------------------------------------------


class Mallinfo2(ctypes.Structure):
    names = "arena ordblks smblks hblks hblkhd usmblks fsmblks uordblks fordblks keepcost"
    _fields_ = [(name, ctypes.c_size_t) for name in names.split()]


libc = ctypes.CDLL(None)
libc.mallinfo2.restype = Mallinfo2


@dataclass
class Footprint:
    heap: int  # bytes that are allocated and not freed; lavapipe's Vulkan objects are among them
    resident: int  # bytes, after the heap's free memory was returned
    threads: int
    descriptors: int
    mappings: int  # ranges of the address space
    files: int  # in the cache folder

    def __str__(self):
        return ", ".join(f"{field.name} {getattr(self, field.name):,}" for field in fields(self))


def footprint():
    gc.collect()
    info = libc.mallinfo2()
    libc.malloc_trim(0)
    caches = Path(os.environ.get("XDG_CACHE_HOME", Path.home() / ".cache")) / "latelight"
    return Footprint(
        heap=info.uordblks + info.hblkhd,
        resident=int(Path("/proc/self/statm").read_text().split()[1]) * 4096,
        threads=len(os.listdir("/proc/self/task")),
        descriptors=len(os.listdir("/proc/self/fd")),
        mappings=Path("/proc/self/maps").read_text().count("\n"),
        files=sum(1 for _ in caches.rglob("*")),
    )


def growth_per_epoch(footprints):
    """Bytes of heap: the slope between the medians of the first and the last third, so that single peaks don't count."""
    third = max(len(footprints) // 3, 1)
    first, last = (statistics.median(f.heap for f in part) for part in (footprints[:third], footprints[-third:]))
    return (last - first) / (len(footprints) - third)


def check(footprints):
    """Sentences about what grew. Early epochs, which fill caches, must have been left out."""
    half = len(footprints) // 2
    most = lambda part, name: max(getattr(f, name) for f in part)
    for name, factor, more in (
        ("threads", 1, 0),
        ("descriptors", 1, 0),
        ("files", 1, 0),
        ("mappings", 1, 60),
        ("resident", 1.15, 0),
    ):
        early, late = most(footprints[:half], name), most(footprints[half:], name)
        if late > early * factor + more:
            yield f"{name} grew from {early:,} to {late:,}"
    growth = growth_per_epoch(footprints)
    if growth > 16 * OPERATIONS:  # a leak of the heap's smallest block, 32 bytes, in every second operation
        yield f"the heap grows by {growth:,.0f} bytes per {OPERATIONS} operations"


# --- life -------------------------------------------------------------------------------------------------------------


class Life:
    """One scene and its renderer, and random operations on both."""

    def __init__(self, scene, device, seed, counts):
        self.random = random.Random(seed)
        self.scene, self.device, self.counts = latelight.Scene(scene), device, counts
        self.renderer = latelight.Renderer(self.scene, device)
        self.choices = [self.draw_options() for _ in range(2)]
        self.instances, self.materials, self.lights, self.meshes, self.textures = [], [], [], [], []

    def act(self):
        action = self.random.choices(
            (self.edit, self.render, self.worlds, self.cast, self.pick, self.drop_ticket, self.replace, self.mistake),
            (700, 180, 40, 30, 15, 20, 2, 13),
        )[0]
        self.counts[action.__name__] += 1
        action()

    # --- edits

    def edit(self):
        r, scene = self.random, self.scene
        kind = r.choice(("instance", "instance", "material", "material", "light", "mesh", "texture"))
        added = getattr(self, {"mesh": "meshes"}.get(kind, kind + "s"))
        what = r.choice(("add", "remove", "set", "set"))
        if what == "add" and len(added) < MAX_ADDED:
            added.append(getattr(self, "add_" + kind)())
        elif what == "remove" and added:
            try:
                getattr(scene, "remove_" + kind)(added[-1])
                added.pop()
            except ValueError:  # something uses it
                pass
        else:
            getattr(self, "set_" + kind)()

    def transform(self):
        r = self.random
        angle, size = r.uniform(0, 6.28), r.uniform(0.2, 1.2)
        c, s = size * math.cos(angle), size * math.sin(angle)
        return [[c, 0, s, r.uniform(-3, 3)], [0, size, 0, r.uniform(0, 2)], [-s, 0, c, r.uniform(-3, 3)], [0, 0, 0, 1]]

    def add_instance(self):
        scene, r = self.scene, self.random
        return scene.add_instance(r.choice(scene.meshes()), r.choice(scene.materials()), self.transform(), "added")

    def set_instance(self):
        scene, r = self.scene, self.random
        if r.random() < 0.3:
            scene.assign_material(r.choice(scene.instances()), r.choice(scene.materials()))
        else:
            scene.set_transform(r.choice(scene.instances()), self.transform())

    def material(self):
        r = self.random
        return latelight.Material(
            name="added",
            base_color=[r.random() for _ in range(4)],
            metallic=r.random(),
            roughness=r.random(),
            alpha_mode=r.choice(("opaque", "opaque", "mask", "blend")),
            double_sided=r.random() < 0.5,
            unlit=r.random() < 0.2,
        )

    def add_material(self):
        return self.scene.add_material(self.material())

    def set_material(self):
        scene, r = self.scene, self.random
        if self.textures and r.random() < 0.4:
            scene.set_texture(r.choice(scene.materials()), "base_color", r.choice((None, r.choice(self.textures))))
        else:
            scene.set_material(r.choice(scene.materials()), self.material())

    def light(self):
        r = self.random
        return latelight.Light(
            name="added",
            type=r.choice(("point", "spot", "directional")),
            position=[r.uniform(-3, 3), r.uniform(1, 3), r.uniform(-3, 3)],
            direction=[r.uniform(-1, 1), -1, r.uniform(-1, 1)],
            intensity=r.uniform(0, 5),
            range=6,
            cast_shadow=r.random() < 0.5,
        )

    def add_light(self):
        return self.scene.add_light(self.light())

    def set_light(self):
        if self.lights:
            self.scene.set_light(self.random.choice(self.lights), self.light())

    def positions(self):
        count = 3 * self.random.randint(1, 40)
        return np.array([self.random.uniform(-0.5, 0.5) for _ in range(3 * count)], np.float32).reshape(-1, 3)

    def add_mesh(self):
        return self.scene.add_mesh(self.positions(), name="added")

    def set_mesh(self):
        if self.meshes:
            self.scene.set_mesh(self.random.choice(self.meshes), self.positions())

    def pixels(self):
        shape = (self.random.randint(1, 16), self.random.randint(1, 16), 4)
        return np.full(shape, self.random.randrange(256), np.uint8)

    def add_texture(self):
        return self.scene.add_texture(self.pixels(), name="added")

    def set_texture(self):
        if self.textures:
            self.scene.set_texture_pixels(self.random.choice(self.textures), self.pixels())

    # --- pictures

    def draw_options(self):
        """Options that compile other pipelines: an epoch uses few, so that it renders more than it compiles."""
        r = self.random
        return {
            "raster": r.choice(("compute", "hardware")),
            "layout": r.choice(("compact", "exact", "thin", "plain")),
            "lighting": r.choice(("clustered", "tiled", "fullscreen")),
            "shadows": r.choice(("none", "d32")),
            "transparency": r.choice(("exact", "sorted", "weighted")),
            "shadow_atlas": 512,
            "outputs": ["rgba", *r.sample(OUTPUTS, r.randrange(4))],
        }

    def options(self):
        r = self.random
        size = (r.randint(4, 48), r.randint(4, 32))
        return {**r.choice(self.choices), "size": size, "exposure": r.uniform(-2, 2)}

    def camera(self):
        r = self.random
        eye = [r.uniform(-4, 4), r.uniform(0.2, 4), r.uniform(2, 6)]
        return self.scene.look_at(eye, [0, 0.5, 0], r.uniform(20, 90))

    def render(self):
        options = self.options()
        cameras = [self.camera() for _ in range(self.random.randint(1, 3))]
        frames = self.renderer.render(cameras, **options)
        width, height = options["size"]
        assert frames["rgba"].shape == (len(cameras), height, width, 4)

    def worlds(self):
        r = self.random
        count, instances = r.randint(1, 4), [r.choice(self.scene.instances())]
        frames = self.renderer.render_worlds(
            count, self.camera(), instances=instances, transforms=[[self.transform()] for _ in range(count)], **self.options()
        )
        assert len(frames["rgba"]) == count

    def cast(self):
        count = self.random.randrange(100)
        values = np.array([self.random.uniform(-3, 3) for _ in range(6 * count)]).reshape(2, count, 3)
        assert len(self.renderer.cast(values[0], values[1])["distance"]) == count

    def pick(self):
        options = self.options()
        del options["outputs"]
        self.renderer.pick(self.camera(), [[self.random.randrange(side) for side in options["size"]]], **options)

    def drop_ticket(self):
        on_device = self.random.random() < 0.5
        ticket = self.renderer.submit([self.camera()], on_device=on_device, **self.options())
        if self.random.random() < 0.5:
            ticket.take()

    def replace(self):
        self.renderer = latelight.Renderer(self.scene, self.device)

    def mistake(self):
        """Each must be refused, and change nothing that later operations need."""
        wrong = np.array(self.transform())
        wrong[0][3] = math.nan
        mistakes = (
            lambda: self.scene.set_transform(self.scene.instances()[0], wrong),
            lambda: self.renderer.render(self.camera(), layout="thick", size=(8, 8)),
            lambda: self.renderer.render(self.camera(), outputs=["deepness"], size=(8, 8)),
            lambda: self.renderer.cast([[0, 0, 0]], [[0, 0, 1], [0, 1, 0]]),
        )
        try:
            self.random.choice(mistakes)()
        except (ValueError, latelight.LatelightError):
            return
        raise AssertionError("a mistake was accepted")


def live(epochs, device, log=None):
    """Returns the footprints of the epochs and the counts of operations."""
    footprints, counts = [], Counter()
    for epoch in range(epochs):
        life = Life(("builtin:boxes", "builtin:spheres")[epoch % 2], device, epoch, counts)
        for _ in range(OPERATIONS):
            life.act()
        assert life.renderer.validation_messages() == []
        del life
        footprints.append(footprint())
        if log:
            print(f"{(epoch + 1) * OPERATIONS:,} operations: {footprints[-1]}", file=log, flush=True)
    return footprints, counts


def main(operations, device="auto", log=None):
    with open(log, "a") if log else sys.stdout as out:
        footprints, counts = live(max(int(operations) // OPERATIONS, 8), device, out)
        measured = footprints[max(len(footprints) // 5, 3) :]
        print(", ".join(f"{name} {count:,}" for name, count in counts.most_common()), file=out)
        print(f"the heap grows by {growth_per_epoch(measured):,.0f} bytes per epoch", file=out)
        wrong = list(check(measured))
        print("\n".join(wrong) or "nothing grew", file=out)
    return 1 if wrong else 0


if __name__ == "__main__":
    sys.exit(main(*sys.argv[1:]))
