"""flip.py FOLDER: the mean FLIP of each picture there beside its reference; fails where one is beyond its bound."""

import sys
from pathlib import Path

import flip_evaluator

LIGHTS = 0.01
ENVIRONMENTS = 0.03

beyond = 0
references = sorted(Path(sys.argv[1]).glob("*.reference.png"))
for reference in references:
    grid, kind = reference.name.split(".")[:2]
    bound = LIGHTS if kind == "lights" else ENVIRONMENTS
    picture = reference.with_name(f"{grid}.{kind}.png")
    mean = flip_evaluator.evaluate(str(reference), str(picture), "LDR")[1]
    beyond += mean > bound
    print(f"{grid}, {kind}: {mean:.4f}, at most {bound}{'  BEYOND' if mean > bound else ''}")
if not references:
    sys.exit("no pictures")
sys.exit(1 if beyond else 0)
