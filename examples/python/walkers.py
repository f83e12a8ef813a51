"""Robots that walk and see: each step advances 1,024 four-legged robots and renders what all of them see in one call.

Every robot has a gait of its own, a camera on its head, and a world of its own: its colors, light, and environment are
random (domain randomization). MuJoCo simulates the robots on all cores. There is no policy: a learner would read
`seen` and set the targets of the joints. The same arguments give the same images, as the printed checksums show.

usage: walkers.py [STEPS] [ROBOTS]
"""

import os
import sys
import time
import zlib
from concurrent.futures import ThreadPoolExecutor

import mujoco
import numpy as np

import latelight

STEPS, ROBOTS = (int(word) for word in (sys.argv[1:] + ["50", "1024"][len(sys.argv) - 1 :])[:2])
SIZE = (64, 64)
rng = np.random.default_rng(3)

# --- the robot ---

LEG = """
<body pos="{x} {y} 0">
  <joint name="hip{leg}" type="hinge" axis="0 1 0" range="-60 60" damping="1"/>
  <geom type="capsule" fromto="0 0 0 0 0 -0.16" size="0.025" material="leg"/>
  <body pos="0 0 -0.16">
    <joint name="knee{leg}" type="hinge" axis="0 1 0" range="-10 110" damping="1"/>
    <geom type="capsule" fromto="0 0 0 0 0 -0.16" size="0.03" material="leg" friction="1.5"/>
  </body>
</body>"""
LEGS = [(0.2, 0.16), (0.2, -0.16), (-0.2, 0.16), (-0.2, -0.16)]  # front left and right, rear left and right
MODEL = mujoco.MjModel.from_xml_string(f"""
<mujoco>
  <option timestep="0.005"/>
  <asset>
    <texture name="tiles" type="2d" builtin="checker" rgb1="0.8 0.8 0.8" rgb2="0.3 0.3 0.3" width="64" height="64"/>
    <material name="floor" texture="tiles" texrepeat="12 12"/>
    <material name="torso"/> <material name="leg"/> <material name="post"/>
  </asset>
  <worldbody>
    <light name="lamp" pos="0 0 4" dir="0.3 0.2 -1" type="directional"/>
    <geom name="floor" type="plane" size="6 6 0.1" material="floor"/>
    {"".join(f'<geom type="box" pos="{x} {y} 0.3" size="0.1 0.1 0.3" material="post"/>'
             for x, y in [(2, 0.8), (3, -0.7), (4, 0.4)])}
    <body pos="0 0 0.32">
      <freejoint/>
      <geom name="torso" type="box" size="0.2 0.1 0.05" mass="3" material="torso"/>
      <camera name="head" pos="0.21 0 0.08" xyaxes="0 -1 0 0.2 0 1" fovy="70"/>
      {"".join(LEG.format(leg=leg, x=x, y=y) for leg, (x, y) in enumerate(LEGS))}
    </body>
  </worldbody>
  <actuator>
    {"".join(f'<position joint="{joint}{leg}" kp="60"/>' for leg in range(4) for joint in ("hip", "knee"))}
  </actuator>
</mujoco>""")

HIP, KNEE = -0.6, 1.2  # radians: standing
states = [mujoco.MjData(MODEL) for _ in range(ROBOTS)]
for state in states:
    state.qpos[2], state.qpos[7:] = 0.3, [HIP, KNEE] * 4
pace, stride = rng.uniform(2.3, 2.8, ROBOTS), rng.uniform(0.24, 0.34, ROBOTS)  # steps per second, radians


def targets(robot, now):
    """A trot: the legs of a diagonal swing together, and bend while they swing forward."""
    phase = 2 * np.pi * pace[robot] * now + np.pi * np.array([0, 1, 1, 0])
    share = min(1, 2 * now)  # of the full stride
    hips = HIP - share * stride[robot] * np.sin(phase)
    knees = KNEE + share * 0.35 * np.maximum(np.cos(phase), 0)
    return np.stack([hips, knees], 1).ravel()


def walk(robot):
    """Advances a robot by a twentieth of a second."""
    data = states[robot]
    for _ in range(10):
        data.ctrl[:] = targets(robot, data.time)
        mujoco.mj_step(MODEL, data)
    mujoco.mj_kinematics(MODEL, data)
    mujoco.mj_camlight(MODEL, data)


# --- what the robots see ---

robots = latelight.from_mujoco(MODEL)
renderer = latelight.Renderer(robots.scene)
colors = np.ones((ROBOTS, len(robots.instances), 4), np.float32)
colors[..., :3] = rng.uniform(0.2, 1, (ROBOTS, len(robots.instances), 3))
look = {
    "base_color": colors,
    "roughness": rng.uniform(0.2, 1, (ROBOTS, len(robots.instances))),
    "lights": robots.lights,
    "light_intensity": rng.uniform(0.5, 3, (ROBOTS, 1)),
    "environments": ["studio"],
    "environment_index": np.zeros(ROBOTS, np.int64),
    "environment_rotation": rng.uniform(0, 360, ROBOTS),
    "environment_intensity": rng.uniform(0.3, 1.2, ROBOTS),
    "shadows": "none",
}

with ThreadPoolExecutor(os.cpu_count()) as pool:
    for step in range(STEPS):
        list(pool.map(walk, range(ROBOTS)))
        start = time.perf_counter()
        frames = renderer.render_worlds(ROBOTS, robots.cameras, SIZE, ("rgba", "depth"), **robots.worlds(states), **look)
        seen = frames["rgba"][:, 0, :, :, :3]
        took = time.perf_counter() - start
        way = np.mean([data.qpos[0] for data in states])
        print(f"step {step}: {way:.3f} m walked, images {zlib.crc32(np.ascontiguousarray(seen)):08x}")
        print(f"step {step}: {ROBOTS / took:.0f} views/s", file=sys.stderr)
