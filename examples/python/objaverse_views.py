"""Views of one object, with the arguments, cameras, lights and files of Objaverse's rendering scripts for Blender.

usage: objaverse_views.py --object_path OBJECT.glb --output_dir FOLDER [--engine BLENDER_EEVEE|CYCLES]

With --num_renders (the default), the script follows scripts/rendering/blender_script.py of Objaverse-XL (commit
19f0cf4): random cameras in a shell around the object, four suns with random energies, and FOLDER/000.png, 000.npy (the
3x4 matrix from Blender's world to Blender's camera) and metadata.json. With --num_images or --camera_dist it follows
scripts/blender_script.py of objaverse-rendering (commit 3ae0fa2): cameras on a ring 30 degrees above the object, light
from above, and FOLDER/OBJECT/000.png.

BLENDER_EEVEE rasterizes; CYCLES traces --samples paths per pixel. "--" before the arguments is ignored, as after
"blender -b -P script.py". --seed and --samples are additions: the original scripts draw other numbers in each run.
"""

import argparse
import json
import math
import sys
from pathlib import Path

import numpy as np

import latelight

SIZE = (512, 512)
FIELD_OF_VIEW = math.degrees(2 * math.atan(16 / 35))  # a lens of 35 mm and a sensor of 32 mm
WORLD = 0.0509  # radiance of the world of Blender's startup file
SKY = 30000 / (math.pi * 100 * 100)  # radiance of a light of 30 kW and 100 m x 100 m above the object
# Name, choices of the energy in W/m2, and rotation about X and Z of each sun.
SUNS = [
    ("Key_Light", (3, 4, 5), 0.785398, -0.785398),
    ("Fill_Light", (2, 3, 4), 0.785398, 2.35619),
    ("Rim_Light", (3, 4, 5), -0.785398, -3.92699),
    ("Bottom_Light", (1, 2, 3), 3.14159, 0),
]

parser = argparse.ArgumentParser(description="Renders views of an object as Objaverse's scripts for Blender do.")
parser.add_argument("--object_path", required=True)
parser.add_argument("--output_dir", default="./views")
parser.add_argument("--engine", default="BLENDER_EEVEE", choices=["CYCLES", "BLENDER_EEVEE"])
parser.add_argument("--num_renders", type=int, default=12)
parser.add_argument("--only_northern_hemisphere", action="store_true")
parser.add_argument("--num_images", type=int)
parser.add_argument("--camera_dist", type=float)
parser.add_argument("--scale", type=float, default=0.8, help="accepted and not used, as in the original")
parser.add_argument("--seed", type=int, default=0)
parser.add_argument("--samples", type=int, default=128)
args = parser.parse_args([argument for argument in sys.argv[1:] if argument != "--"])
if min(args.num_renders, 12 if args.num_images is None else args.num_images) < 1:
    parser.error("--num_renders and --num_images must be at least 1")
is_ring = args.num_images is not None or args.camera_dist is not None
random = np.random.default_rng(args.seed)


def eyes():
    """Positions of cameras around a unit cube, in Blender's world (Z up)."""
    if is_ring:
        count, distance, phi = args.num_images or 12, args.camera_dist or 1.2, math.radians(60)
        for theta in np.arange(count) / count * 2 * math.pi:
            yield distance * np.array([math.sin(phi) * math.cos(theta), math.sin(phi) * math.sin(theta), math.cos(phi)])
        return
    for _ in range(args.num_renders):
        direction = random.uniform(-1, 1, 3)
        eye = direction / np.linalg.norm(direction) * random.uniform(1.5, 2.2)
        yield eye * [1, 1, -1] if args.only_northern_hemisphere and eye[2] < 0 else eye


def world_to_camera(eye):
    """The 3x4 matrix of a camera that looks at the origin, in Blender's camera frame (X right, Y up, Z backward)."""
    back = eye / np.linalg.norm(eye)
    right = np.cross([0, 0, 1], back)
    right /= np.linalg.norm(right)
    rotation = np.stack([right, np.cross(back, right), back])
    return np.concatenate([rotation, (-rotation @ eye)[:, None]], axis=1)


def replace_lights(scene, turn):
    """Removes the object's lights and adds the suns of the random views. `turn`: from Blender's axes to the scene's."""
    for light in scene.lights():
        scene.remove_light(light)
    for name, energies, x, z in [] if is_ring else SUNS:
        direction = [-math.sin(x) * math.sin(z), math.sin(x) * math.cos(z), -math.cos(x)]
        scene.add_light(
            latelight.Light(
                name=name,
                type="directional",
                direction=tuple(turn @ direction),
                intensity=float(random.choice(energies)),
                cast_shadow=False,
            )
        )


def metadata_of(scene, turn):
    corners = np.array(scene.bounds) @ turn
    return {
        "file_size": Path(args.object_path).stat().st_size,
        "poly_count": scene.triangle_count,
        "material_count": len(scene.materials()),
        "mesh_count": len(scene.meshes()),
        "animation_count": len(scene.animations),
        "scene_size": {"bbox_min": corners.min(0).tolist(), "bbox_max": corners.max(0).tolist()},
    }


def main():
    # An equirectangular environment: the world, and in the upper half the light from above.
    environment = np.full((64, 128, 3), WORLD, np.float32)
    environment[:32] += SKY if is_ring else 0
    scene = latelight.Scene(args.object_path)
    # From Blender's axes to the file's: glTF and OBJ have Y up, PLY and STL have Z up.
    has_z_up = Path(args.object_path).suffix.lower() in (".ply", ".stl")
    turn = np.eye(3) if has_z_up else np.array([[1, 0, 0], [0, 0, 1], [0, -1, 0]])
    out = Path(args.output_dir) / (Path(args.object_path).name.split(".")[0] if is_ring else "")
    out.mkdir(parents=True, exist_ok=True)
    low, high = np.array(scene.bounds)
    replace_lights(scene, turn)
    # The object is not scaled to the unit cube; the cameras are scaled to the object.
    positions = list(eyes())
    cameras = [
        latelight.Camera.look_at(
            (low + high) / 2 + turn @ eye * (high - low).max(), (low + high) / 2, tuple(turn @ [0, 0, 1]), FIELD_OF_VIEW
        )
        for eye in positions
    ]
    options = {"lighting": "reference", "samples": args.samples} if args.engine == "CYCLES" else {"aa": "ss2"}
    renderer = latelight.Renderer(scene, environment=environment)
    for number, frame in enumerate(renderer.render(cameras, SIZE, ("rgba",), **options)):
        (out / f"{number:03}.png").write_bytes(frame.png())
        if not is_ring:
            np.save(out / f"{number:03}.npy", world_to_camera(positions[number]))
    if not is_ring:
        (out / "metadata.json").write_text(json.dumps(metadata_of(scene, turn), sort_keys=True, indent=2))


if __name__ == "__main__":
    try:
        main()
    except latelight.LatelightError as error:
        print(f"objaverse_views: {error}", file=sys.stderr)
        sys.exit(error.exit_code)
