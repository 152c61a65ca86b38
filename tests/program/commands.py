#!/usr/bin/env python3
# SPDX-License-Identifier: MIT
"""Runs the commands of the documents: all lines in blocks that begin with "svocl", at small depths and sizes, in a
folder that has what they read. What measures for minutes or opens windows is left out.

usage: commands.py PROGRAM ROOT FOLDER
"""

import glob
import os
import re
import shlex
import shutil
import subprocess
import sys

LEFT_OUT = ("COMMAND", "bench", "report", "tune", "view")
"""Commands that are not run: a placeholder, measurements, the viewer."""
LARGEST = {"-d": 5, "--frames": 2, "--turntable": 2, "--repeat": 2, "--samples": 4, "--paths": 64, "--reference": 16,
           "--points": 8, "--levels": 3, "--frame": 0, "--shares": 1, "--part": 0}  # fmt: skip
"""The most that numbers after these options are."""
SMALL = {"--size": "32x24", "--probes": "2,2,2", "--max-memory": "64M", "--voxel-size": "0.125"}
"""What stands after these in place of what is written."""
LARGE_SCENES = {
    "scene:atrium": "scene:knot:500",
    "scene:statue": "scene:knot:500",
    "scene:knot:20000": "scene:knot:500",
}

CUBE = """mtllib model.mtl
v {0} {0} {0}
v {1} {0} {0}
v {0} {1} {0}
v {1} {1} {0}
v {0} {0} {1}
v {1} {0} {1}
v {0} {1} {1}
v {1} {1} {1}
usemtl red
f 1 3 4 2
f 5 6 8 7
f 1 2 6 5
usemtl blue
f 3 7 8 4
f 1 5 7 3
f 2 4 8 6
"""
FILES = {
    "model.obj": CUBE.format("0", "1"),
    "statue.obj": CUBE.format("0.5", "8.5"),
    "model.mtl": "newmtl red\nKd 1 .2 .1\nnewmtl blue\nKd .1 .2 1\n",
    "points.csv": "0.5,1,0.5,0,1,0\n0,0.5,0.5,-1,0,0\n",
    "rays.csv": "0.5,0.5,-2,0,0,1\n0.5,3,0.5,0,-1,0\n",
    "dig.txt": "set box 0 0 0 32 4 32 color 92 145 60\nclear sphere 8 4 8 4\n",
    "place.txt": "set voxels statue.vox at 2 0 1\n",
    "scene.json": '{"trees": {"box": {"path": "model.obj", "depth": 4}}, "instances": [{"tree": "box"}]}\n',
    "moving.json": '{"trees": {"box": {"path": "model.obj", "depth": 4}}, "instances": [{"tree": "box"}, '
    '{"tree": "box", "motion": [{"time": 0, "translate": [0, 0, 0]}, {"time": 1, "translate": [1, 0, 0]}]}]}\n',
    "cloud.ply": "ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\nproperty float y\nproperty float z\n"
    "end_header\n1 2 3\n4 5 6\n7 8 9\n",
}
"""What a folder has at first."""
MADE = (
    "convert model.obj model.vox -d 5",
    "build model.obj -d 5 --need color,normal,rays,projected-area -o model.svo",
    "convert model.svo model.svc --tree-form shared",
    "convert statue.obj statue.vox --voxel-size 1 --solid winding",
    "scene cube -o model.ply",
    "mesh model.obj -d 4 -o model.glb",
    "parts plan model.ply -d 5 --max-memory 64M -o model.svo",
    "parts build model.svo.parts",
)
"""How the rest is made, in the folder of the first document, from which others are copied."""
COPIES = {
    "castle.vox": "model.vox", "walk.vox": "model.vox", "castle.obj": "model.obj", "hall.obj": "model.obj",
    "lost_empire.obj": "model.obj", "sponza.obj": "model.obj", "golden.svo": "model.svo", "large.svo": "model.svo",
    "scan.las": "cloud.ply", "huge.ply": "model.ply", "huge.svo.parts": "model.svo.parts",
}  # fmt: skip
CLOUDS = ("voxel_files.md",)
"""Documents whose scan.ply has points; in others it has faces."""


def commands_of(path):
    """The commands of a document, each with its line."""
    inside, command, begin = False, "", 0
    with open(path, encoding="utf-8") as file:
        for number, line in enumerate(file, 1):
            if line.startswith("```"):
                inside, command = not inside, ""
            elif inside and (command or line.startswith("svocl ")):
                begin = begin if command else number
                command += line.rstrip("\n")
                if command.endswith("\\"):
                    command = command[:-1]
                    continue
                yield begin, command
                command = ""


def arguments_of(command):
    """The words of a command up to a comment or a pipe, made small."""
    words = []
    for word in shlex.split(command, comments=True)[1:]:
        if word in ("|", ">", "&&"):
            break
        last = words[-1] if words else ""
        if last in LARGEST and re.fullmatch(r"\d+", word):
            word = str(min(int(word), LARGEST[last]))
        elif last in SMALL and word != "1":
            word = SMALL[last]
        words.append(LARGE_SCENES.get(word, word))
    return words + (["--size", SMALL["--size"]] if words[0] == "render" and "--size" not in words else [])


def run(program, folder, words):
    """The exit code of a command and what it says."""
    done = subprocess.run([program, *words], cwd=folder, stdin=subprocess.DEVNULL, timeout=600,
                          stdout=subprocess.PIPE, stderr=subprocess.STDOUT)  # fmt: skip
    return done.returncode, done.stdout.decode(errors="replace")


def fill(program, root, folder):
    """Makes a folder with what commands read."""
    shutil.rmtree(folder, ignore_errors=True)
    os.makedirs(folder)
    for name, content in FILES.items():
        with open(os.path.join(folder, name), "w", encoding="utf-8") as file:
            file.write(content)
    for name in ("samples", "docs"):
        os.symlink(os.path.join(root, name), os.path.join(folder, name))
    for path in ("samples/08_light/sun.json", "samples/16_ci/part.obj"):
        shutil.copy(os.path.join(root, path), folder)
    for command in MADE:
        code, said = run(program, folder, command.split())
        if code != 0:
            sys.exit(f"{command}: exit code {code}\n{said}")
    for name, source in COPIES.items():
        copy = shutil.copytree if os.path.isdir(os.path.join(folder, source)) else shutil.copy
        copy(os.path.join(folder, source), os.path.join(folder, name))


def main():
    program, root, folder = sys.argv[1:]
    first = os.path.join(folder, "first")
    fill(program, root, first)
    ran = wrong = 0
    for path in sorted(glob.glob(os.path.join(root, "docs/*.md"))):
        own = os.path.join(folder, "own")
        shutil.rmtree(own, ignore_errors=True)
        shutil.copytree(first, own, symlinks=True)
        shutil.copy(os.path.join(own, "cloud.ply" if os.path.basename(path) in CLOUDS else "model.ply"),
                    os.path.join(own, "scan.ply"))  # fmt: skip
        for line, command in commands_of(path):
            words = arguments_of(command)
            if words[0] in LEFT_OUT:
                continue
            if words[0] == "build" and "--max-memory" in words:
                shutil.rmtree(os.path.join(own, "model.svo.parts"), ignore_errors=True)
            code, said = run(program, own, words)
            if "built without" in said:
                print(f"not run: svocl {' '.join(words)}\n{said}")
                continue
            ran += 1
            if code > (1 if words[0] == "diff" else 0):  # which says so that files differ
                wrong += 1
                print(f"{os.path.relpath(path, root)}:{line}: exit code {code}: svocl {' '.join(words)}\n{said}")
    print(f"{ran} commands ran, {wrong} failed")
    sys.exit(wrong > 0 or ran < 90)


if __name__ == "__main__":
    main()
