"""Latelight: glTF scenes to pictures and exact per-pixel data, on GPUs and on the CPU, without a display::

    import latelight

    scene = latelight.Scene("helmet.glb")
    renderer = latelight.Renderer(scene)
    frame = renderer.render(scene.default_camera(), size=(640, 480), outputs=("rgba", "depth", "id"))
    frame["depth"]  # (480, 640) float32, meters

Units are meters and degrees; poses and positions are in the scene file's own frame (glTF: right-handed, Y up).
"""

from . import _cpu_driver  # before the first device is opened
from ._core import (
    Animation,
    AnimationChannel,
    Camera,
    CastTicket,
    DeviceArray,
    Instance,
    InstanceHandle,
    Lens,
    Light,
    LightHandle,
    Material,
    MaterialHandle,
    Mesh,
    MeshHandle,
    Node,
    Pick,
    Renderer,
    Scene,
    SkinHandle,
    Texture,
    TextureHandle,
    Ticket,
    read_environment,
    set_memory_limit,
    version,
)
from . import depth_sensor, lidar
from ._from_mujoco import MujocoScene, from_mujoco
from ._from_open3d import from_open3d
from ._from_trimesh import from_trimesh
from ._from_urdf import from_urdf, pose_urdf
from ._usd.stage import from_usd, usd_exposures
from ._gymnasium import add_pixels
from .errors import (
    ArgumentTypeError,
    DeviceLostError,
    InputError,
    LatelightError,
    NoDeviceError,
    OutOfMemoryError,
    UsageError,
)
from .frames import DeviceFrames, DeviceWorldFrames, Frame, Frames, WorldFrames
from .labels import Correspondence, Keypoint, Keypoints, Labels, WorldCorrespondence, WorldKeypoints, WorldLabels

__version__ = version()

__all__ = [
    "Animation",
    "AnimationChannel",
    "ArgumentTypeError",
    "Camera",
    "CastTicket",
    "Correspondence",
    "DeviceArray",
    "DeviceFrames",
    "DeviceLostError",
    "DeviceWorldFrames",
    "Frame",
    "Frames",
    "InputError",
    "Instance",
    "InstanceHandle",
    "Keypoint",
    "Keypoints",
    "Labels",
    "LatelightError",
    "Lens",
    "Light",
    "LightHandle",
    "Material",
    "MaterialHandle",
    "Mesh",
    "MeshHandle",
    "MujocoScene",
    "NoDeviceError",
    "Node",
    "OutOfMemoryError",
    "Pick",
    "Renderer",
    "Scene",
    "SkinHandle",
    "Texture",
    "TextureHandle",
    "Ticket",
    "UsageError",
    "WorldCorrespondence",
    "WorldFrames",
    "WorldKeypoints",
    "WorldLabels",
    "__version__",
    "add_pixels",
    "depth_sensor",
    "from_mujoco",
    "from_open3d",
    "from_trimesh",
    "from_urdf",
    "from_usd",
    "lidar",
    "pose_urdf",
    "read_environment",
    "set_memory_limit",
    "usd_exposures",
    "version",
]
