"""What a type checker says, by the package's stubs: nothing of the tutorial, and all that is wrong here."""

import os
import re
import subprocess
import sys
from pathlib import Path

import latelight

ROOT = Path(__file__).parents[2]
PACKAGE = Path(latelight.__file__).parent

RIGHT = """
channel = latelight.AnimationChannel(node="/a", property="scale")
channel.interpolation = "step"
channel.times, channel.values = [0.0, 2.0], [[1, 1, 1], [2, 2, 2]]
channel.property = "rotation"
names: list[str] = [channel.node, channel.property]
"""

WRONG = """
renderer.render(camera, exposre=1)
renderer.submit(camera, exposure=[1])
renderer.submit(camera, tonemap="film")
scene.set_texture(scene.materials()[0], "bump", None)
latelight.Camera(fov=40)
renderer.render(camera, (8, 8)).png
renderer.render([camera], (8, 8)).png
"""


def errors(folder, file):
    environment = {**os.environ, "MYPYPATH": str(PACKAGE.parent)}
    run = subprocess.run(
        [sys.executable, "-m", "mypy", "--cache-dir", folder / "cache", file],
        cwd=folder, env=environment, capture_output=True, text=True,
    )
    assert run.stderr == ""
    return [line for line in run.stdout.splitlines() if ": error:" in line]


def complaints(folder, source):
    (folder / "checked.py").write_text(source)
    return errors(folder, "checked.py")


def test_types(tmp_path):
    blocks = re.findall(r"^```python\n(.*?)^```", (ROOT / "docs/python.md").read_text(), re.DOTALL | re.MULTILINE)
    right = "\n".join(block for block in blocks if "exposre" not in block) + RIGHT
    assert complaints(tmp_path, right) == []
    wrong = complaints(tmp_path, right + WRONG)
    first = len(right.split("\n"))
    lines = {int(line.split(":")[1]) - first for line in wrong}
    assert lines == {1, 2, 3, 4, 5, 7}


def test_the_stub(tmp_path):
    assert [line for line in errors(tmp_path, PACKAGE / "_core.pyi") if "_core.pyi:" in line] == []
