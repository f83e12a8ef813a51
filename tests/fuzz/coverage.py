#!/usr/bin/env python3
"""Prints the lines that a fuzz target reached in the sources of its parser: llvm-cov export | coverage.py TARGET [-v]

The lines of functions that the target never entered, such as those that write files, are counted separately; -v lists
these functions.
"""

import json
import re
import sys

# The sources of each target's parser, as a pattern for paths from the root.
PARSERS = {
    "gltf": r"src/scene/gltf/",
    "glb": r"src/scene/gltf/(container|schema|model|model_materials|extensions)\.cpp",
    "meshopt": r"src/scene/gltf/meshopt\.cpp",
    "draco": r"src/scene/gltf/draco\.cpp",
    "ktx2": r"src/scene/textures/(ktx2|etc1s|uastc|huffman)\.",
    "image": r"src/scene/textures/(avif|jpeg|png|stb|webp|texture)\.cpp",
    "mesh_file": r"src/scene/mesh_files/.*\.cpp",
    "environment": r"src/scene/environment/picture_(exr|io|radiance)\.cpp",
    "compared_image": r"src/output/(read|png_read|exr_read)\.cpp",
    "cache": r"src/scene/environment/environment_cache\.cpp",
    "job": r"src/data/(json_builder|batch/job_file|batch/schema)\.cpp",
    "camera_file": r"src/data/(json_builder|cameras/.*)\.cpp",
    "command_line": r"(app/render_options|src/render/options/options|src/render/settings/(settings|sensor_options))\.cpp",
    "shader": r"src/vk/.*\.cpp",
    "serve_request": r"src/serve/(access_check|page|token)\.cpp",
    "serve_message": r"src/serve/(read_order|upload)\.cpp",
    "serve_frames": r"tests/fuzz/serve_frames\.cpp",
}




def own_path(filename):
    """Returns the path from the root; unity builds include sources by another one."""
    return re.sub(r"^.*?((src|app|tests)/)", r"\1", filename.replace("include_paths/", ""))


def lines_of(segments):
    """Returns the lines with code and those executed, from a file's segments as llvm-cov counts lines."""
    by_line = {}
    for line, _, count, has_count, is_entry, is_gap in segments:
        by_line.setdefault(line, []).append((count, has_count, is_entry and not is_gap))
    code, executed = set(), set()
    wrapped = (0, False)
    if not by_line:
        return code, executed
    for line in range(min(by_line), max(by_line) + 1):
        here = by_line.get(line, [])
        counts = [count for count, has_count, is_entry in here if is_entry and has_count]
        if wrapped[1]:
            counts.append(wrapped[0])
        if counts:
            code.add(line)
            if max(counts) > 0:
                executed.add(line)
        if here:
            wrapped = here[-1][:2]
    return code, executed


def functions_in(functions, path):
    """Returns {(first line, last line): (entered, name)} of a file's functions."""
    found = {}
    for function in functions:
        if own_path(function["filenames"][0]) != path:
            continue
        first, _, last = function["regions"][0][:3]
        entered = function["count"] > 0 or found.get((first, last), (False,))[0]
        found[first, last] = entered, function["name"].split(":")[-1]
    return found


def main():
    target, verbose = sys.argv[1], "-v" in sys.argv[2:]
    data = json.load(sys.stdin)["data"][0]
    total = [0, 0, 0]
    for file in data["files"]:
        path = own_path(file["filename"])
        if not re.match(PARSERS[target], path):
            continue
        code, executed = lines_of(file["segments"])
        outside, names = set(), []
        for (first, last), (entered, name) in functions_in(data["functions"], path).items():
            if not entered and not any(line in executed for line in range(first, last + 1)):
                outside |= code & set(range(first, last + 1))
                names.append(name)
        code -= outside
        counts = len(executed & code), len(code), len(outside)
        total = [a + b for a, b in zip(total, counts)]
        print(f"  {counts[0]:5} of {counts[1]:5}  {100 * counts[0] / max(counts[1], 1):5.1f} %  {path}"
              + (f" ({counts[2]} lines in functions that are not entered)" if outside else ""))
        if verbose:
            for name in names:
                print(f"                         not entered: {name}")
            missing = sorted(code - executed)
            if missing:
                print(f"                         not reached: {' '.join(map(str, missing))}")
    print(f"  {total[0]:5} of {total[1]:5}  {100 * total[0] / max(total[1], 1):5.1f} %  in all ({total[2]} not entered)")


main()
