"""long_life.py OPERATIONS [--device D] [--seed S] [--epoch N] [--seconds T] [--log FILE]: a process that lives long.

It edits scenes, renders pictures, worlds and rays, drops tickets, replaces renderers and makes mistakes, all at random,
and must hold no more in the end than before. An epoch begins with a new scene and a new renderer, and ends without any.
Its footprint is what the process then holds; the log has a line per epoch."""

import argparse
import math
import random
import sys
import time
from collections import Counter

import latelight
import numpy as np

from footprint import check, footprint, growth_per_epoch

OPERATIONS = 250  # per epoch
MAX_ADDED = 10  # elements of each kind
OUTPUTS = ("depth", "normal", "id", "material", "motion", "position", "color")


# --- life -------------------------------------------------------------------------------------------------------------


def draw_options(r):
    """Options that compile other pipelines: an epoch uses few, so that it renders more than it compiles."""
    return {
        "raster": r.choice(("compute", "hardware")),
        "layout": r.choice(("compact", "exact", "thin", "plain")),
        "lighting": r.choice(("clustered", "tiled", "fullscreen")),
        "shadows": r.choice(("none", "d32")),
        "transparency": r.choice(("exact", "sorted", "weighted")),
        "shadow_atlas": 512,
        "outputs": ["rgba", *r.sample(OUTPUTS, r.randrange(4))],
    }


class Life:
    """One scene and its renderer, and random operations on both."""

    def __init__(self, scene, device, seed, counts, *, max_side=32, edits=700, choices=None):
        """Pictures have sides up to `max_side`; there are `edits` edits for 300 other operations."""
        self.random = random.Random(seed)
        self.scene, self.device, self.counts = latelight.Scene(scene), device, counts
        self.max_side, self.edits = max_side, edits
        self.renderer = latelight.Renderer(self.scene, device)
        self.choices = choices or [draw_options(self.random) for _ in range(2)]
        self.instances, self.materials, self.lights, self.meshes, self.textures = [], [], [], [], []

    def act(self):
        action = self.random.choices(
            (self.edit, self.render, self.worlds, self.cast, self.pick, self.drop_ticket, self.replace, self.mistake),
            (self.edits, 180, 40, 30, 15, 20, 2, 13),
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

    def options(self):
        r = self.random
        size = (r.randint(4, self.max_side), r.randint(4, self.max_side))
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


def live(epochs, device, *, first=0, operations=OPERATIONS, until=math.inf, log=None, **life_options):
    """Returns the footprints of the epochs and the counts of operations. `first` is the seed of the first epoch."""
    footprints, counts = [], Counter()
    for epoch in range(first, first + epochs):
        if time.monotonic() > until:
            break
        life = Life(("builtin:boxes", "builtin:spheres")[epoch % 2], device, epoch, counts, **life_options)
        for _ in range(operations):
            life.act()
        assert life.renderer.validation_messages() == []
        del life
        footprints.append(footprint())
        if log:
            print(f"{counts.total():,} operations: {footprints[-1]}", file=log, flush=True)
    return footprints, counts


def main():
    parser = argparse.ArgumentParser()
    parser.add_argument("operations", type=int)
    parser.add_argument("--device", default="auto")
    parser.add_argument("--seed", type=int, default=0, help="of the first epoch; each further epoch has the next one")
    parser.add_argument("--epoch", type=int, default=OPERATIONS, help="operations per epoch")
    parser.add_argument("--edits", type=int, default=700, help="for 300 other operations")
    parser.add_argument("--choices", type=int, help="sets of options for all epochs; default: two new ones per epoch")
    parser.add_argument("--side", type=int, default=32, help="the largest side of a picture, in pixels")
    parser.add_argument("--seconds", type=float, default=math.inf, help="no epoch begins later")
    parser.add_argument("--log", type=argparse.FileType("a"), default=sys.stdout)
    a = parser.parse_args()
    r = random.Random(a.seed)
    footprints, counts = live(
        max(a.operations // a.epoch, 8),
        a.device,
        first=a.seed,
        operations=a.epoch,
        until=time.monotonic() + a.seconds,
        log=a.log,
        max_side=a.side,
        edits=a.edits,
        choices=[draw_options(r) for _ in range(a.choices)] if a.choices else None,
    )
    measured = footprints[max(len(footprints) // 5, 3) :]
    print(", ".join(f"{name} {count:,}" for name, count in counts.most_common()), file=a.log)
    print(f"the heap grows by {growth_per_epoch(measured):,.0f} bytes per epoch", file=a.log)
    wrong = list(check(measured, a.epoch))
    print("\n".join(wrong) or "nothing grew", file=a.log)
    return 1 if wrong else 0


if __name__ == "__main__":
    sys.exit(main())
