"""What a type checker says, by the package's stubs: nothing of the tutorial, and all that is wrong here."""

import os
import re
import subprocess
import sys
from pathlib import Path

import latelight

ROOT = Path(__file__).parents[2]
PACKAGE = Path(latelight.__file__).parent

WRONG = """
renderer.render(camera, exposre=1)
renderer.submit(camera, exposure=[1])
renderer.submit(camera, tonemap="film")
scene.set_texture(scene.materials()[0], "bump", None)
latelight.Camera(fov=40)
renderer.render(camera, (8, 8)).png
renderer.render([camera], (8, 8)).png
"""


def complaints(folder, source):
    (folder / "checked.py").write_text(source)
    environment = {**os.environ, "MYPYPATH": str(PACKAGE.parent)}
    run = subprocess.run(
        [sys.executable, "-m", "mypy", "--cache-dir", folder / "cache", "checked.py"],
        cwd=folder, env=environment, capture_output=True, text=True,
    )
    assert run.stderr == ""
    return [line for line in run.stdout.splitlines() if ": error:" in line]


def test_types(tmp_path):
    blocks = re.findall(r"^```python\n(.*?)^```", (ROOT / "docs/python.md").read_text(), re.DOTALL | re.MULTILINE)
    right = "\n".join(block for block in blocks if "exposre" not in block)
    assert complaints(tmp_path, right) == []
    wrong = complaints(tmp_path, right + WRONG)
    first = len(right.split("\n"))
    lines = {int(line.split(":")[1]) - first for line in wrong}
    assert lines == {1, 2, 3, 4, 5, 7}
