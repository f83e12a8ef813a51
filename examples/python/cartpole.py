"""Cart-pole from pixels: an agent learns to balance a pole that it only sees, by proximal policy optimization (PPO).

Each step renders all carts in one call, as worlds. The colors of a cart and its pole change with every episode (domain
randomization). Everything is NumPy: physics (Barto, Sutton and Anderson 1983, "Neuronlike adaptive elements that can
solve difficult learning control problems"), a network of one hidden layer, and PPO (Schulman et al. 2017). The same
arguments give the same images in every step, as the printed checksums show.

usage: cartpole.py [ITERATIONS] [WORLDS]
"""

import sys
import zlib

import numpy as np

import latelight

ITERATIONS, WORLDS = (int(word) for word in (sys.argv[1:] + ["60", "32"][len(sys.argv) - 1 :])[:2])
STEPS, WIDTH, HEIGHT, HIDDEN = 32, 40, 16, 48
GAMMA, LAMBDA, CLIP, RATE, EPOCHS, ENTROPY = 0.97, 0.95, 0.2, 2e-3, 8, 0.003
rng = np.random.default_rng(1)

# --- what is seen ---

BOX = np.array([[x, y, z] for x in (-1, 1) for y in (-1, 1) for z in (-1, 1)], np.float32)
SIDES = [[0, 1, 3], [0, 3, 2], [4, 6, 7], [4, 7, 5], [0, 4, 5], [0, 5, 1],
         [2, 3, 7], [2, 7, 6], [0, 2, 6], [0, 6, 4], [1, 5, 7], [1, 7, 3]]
scene = latelight.Scene()
parts = []
for half in ((0.3, 0.1, 0.1), (0.06, 0.5, 0.06)):  # cart and pole
    paint = scene.add_material(latelight.Material(unlit=True))
    parts.append(scene.add_instance(scene.add_mesh(BOX * np.float32(half), SIDES), paint))
camera = latelight.Camera.look_at((0, 0.45, 8), (0, 0.45, 0), vertical_fov=14)
renderer = latelight.Renderer(scene)


def look(states, colors):
    """Grayscale images (N, HEIGHT * WIDTH) of carts, and the checksum of the images that they come from."""
    transforms = np.tile(np.eye(4), (len(states), 2, 1, 1))
    transforms[:, 0, 0, 3] = states[:, 0]
    sine, cosine = np.sin(states[:, 2]), np.cos(states[:, 2])
    transforms[:, 1, :2, :2] = np.stack([np.stack([cosine, sine], -1), np.stack([-sine, cosine], -1)], -2)
    transforms[:, 1, 0, 3], transforms[:, 1, 1, 3] = states[:, 0] + 0.5 * sine, 0.1 + 0.5 * cosine
    frames = renderer.render_worlds(
        len(states), camera, (WIDTH, HEIGHT), "rgba", instances=parts, transforms=transforms, base_color=colors
    )
    pictures = frames["rgba"][:, 0, :, :, :3]
    return pictures.mean(-1).reshape(len(states), -1) / 255, zlib.crc32(np.ascontiguousarray(pictures))


def random_colors(count):
    colors = np.ones((count, 2, 4))
    colors[..., :3] = rng.uniform(0.2, 1.0, (count, 2, 3))
    return colors


# --- physics ---


def start(count):
    return rng.uniform(-0.05, 0.05, (count, 4)) * [10, 1, 2, 1]


def step(states, right):
    """A twentieth of a second under a force of 10 N: position, speed, angle from upright, angular speed."""
    x, speed, angle, spin = states.T
    for _ in range(2):
        force = (np.where(right, 10, -10) + 0.05 * spin**2 * np.sin(angle)) / 1.1
        turn = (9.8 * np.sin(angle) - np.cos(angle) * force) / (0.5 * (4 / 3 - 0.1 * np.cos(angle) ** 2 / 1.1))
        push = force - 0.05 * turn * np.cos(angle) / 1.1
        x, speed, angle, spin = x + 0.02 * speed, speed + 0.02 * push, angle + 0.02 * spin, spin + 0.02 * turn
    return np.stack([x, speed, angle, spin], 1), (np.abs(x) > 1.8) | (np.abs(angle) > 0.35)


# --- the agent ---

network = {"w": rng.normal(0, 0.06, (2 * WIDTH * HEIGHT, HIDDEN)), "b": np.zeros(HIDDEN),
           "policy": rng.normal(0, 0.01, (HIDDEN, 2)), "value": np.zeros((HIDDEN, 1))}
moments = {name: [np.zeros_like(value), np.zeros_like(value)] for name, value in network.items()}
updates = 0


def think(seen):
    hidden = np.tanh(seen @ network["w"] + network["b"])
    logits = hidden @ network["policy"]
    chances = np.exp(logits - logits.max(1, keepdims=True))
    return hidden, chances / chances.sum(1, keepdims=True), (hidden @ network["value"])[:, 0]


def learn(seen, actions, before, advantages, returns):
    """One step of Adam on PPO's clipped objective, the value's squared error, and the entropy."""
    global updates
    updates += 1
    hidden, chances, values = think(seen)
    rows = np.arange(len(seen))
    ratio = chances[rows, actions] / before
    kept = np.where(advantages > 0, ratio < 1 + CLIP, ratio > 1 - CLIP)
    one = np.zeros_like(chances)
    one[rows, actions] = 1
    logs = np.log(chances + 1e-9)
    entropy = chances * (logs - (chances * logs).sum(1, keepdims=True))
    to_logits = (-(kept * advantages * ratio)[:, None] * (one - chances) + ENTROPY * entropy) / len(seen)
    to_values = (values - returns)[:, None] / len(seen)
    back = (to_logits @ network["policy"].T + to_values @ network["value"].T) * (1 - hidden**2)
    slopes = {"policy": hidden.T @ to_logits, "value": hidden.T @ to_values, "w": seen.T @ back, "b": back.sum(0)}
    for name, slope in slopes.items():
        first, second = moments[name]
        first += 0.1 * (slope - first)
        second += 0.001 * (slope**2 - second)
        network[name] -= RATE * (first / (1 - 0.9**updates)) / (np.sqrt(second / (1 - 0.999**updates)) + 1e-8)


states, colors, ages = start(WORLDS), random_colors(WORLDS), np.zeros(WORLDS, int)
now, checksum = look(states, colors)
last = now
for iteration in range(ITERATIONS):
    seen, actions, chances, values, fallen, lengths, checksums = [], [], [], [], [], [], []
    for _ in range(STEPS):
        seen.append(np.concatenate([now, 10 * (now - last)], 1))
        _, both, value = think(seen[-1])
        actions.append((rng.random(WORLDS) < both[:, 1]).astype(int))
        chances.append(both[np.arange(WORLDS), actions[-1]])
        values.append(value)
        states, fell = step(states, actions[-1] == 1)
        ages += 1
        over = fell | (ages >= 200)
        lengths += ages[over].tolist()
        fallen.append(over)
        states[over], ages[over] = start(over.sum()), 0
        colors[over] = random_colors(over.sum())
        last = now
        now, checksum = look(states, colors)
        checksums.append(checksum)
        last = np.where(over[:, None], now, last)
    _, _, value = think(np.concatenate([now, 10 * (now - last)], 1))
    advantages, advantage = [], np.zeros(WORLDS)
    for t in reversed(range(STEPS)):  # generalized advantage estimation
        alive = ~fallen[t]
        error = 0.1 * alive + GAMMA * value * alive - values[t]
        advantage = error + GAMMA * LAMBDA * alive * advantage
        advantages.insert(0, advantage)
        value = values[t]
    gained = np.concatenate(advantages)
    returns = gained + np.concatenate(values)
    gained = (gained - gained.mean()) / (gained.std() + 1e-8)
    batch = [np.concatenate(rows) for rows in (seen, actions, chances)]
    for _ in range(EPOCHS):
        for part in np.array_split(rng.permutation(len(gained)), 4):
            learn(*(rows[part] for rows in batch), gained[part], returns[part])
    mean = np.mean(lengths) if lengths else STEPS
    print(f"iteration {iteration}: episodes of {mean:.1f} steps, images {zlib.crc32(np.uint32(checksums)):08x}")
