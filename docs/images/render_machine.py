#!/usr/bin/env python3
"""Draws the machine of a DEM burst at its last state: particles coloured by speed, casing translucent.

    granary run workflows/cm5.json --dir runs/picture --set /machine/refinement=4
    granary stop runs/picture                            # when the first burst is done
    docs/images/render_machine.py runs/picture/bursts/0001-dem docs/images/dem_cm5.png --dem build/bin/granary-dem

Needs POV-Ray (Debian: apt-get install povray) and granary-dem in the PATH or named by --dem. Only for the docs:
nothing of Granary needs either at run time. The state is what granary-dem reads back from restart.liggghts; blades are
turned by what their time makes of their speed: so it must be the first burst.
"""
import argparse
import json
import math
import re
import subprocess
import sys
from pathlib import Path

MAP = [(48, 18, 59), (70, 107, 227), (27, 207, 212), (97, 252, 108), (209, 233, 52), (254, 155, 45), (217, 56, 6)]


def colour(share):
    """From dark blue (at rest) over green to red, as `r,g,b` in linear light."""
    at = min(max(share, 0.0), 0.9999) * (len(MAP) - 1)
    low, part = MAP[int(at)], at - int(at)
    high = MAP[int(at) + 1]
    return ",".join(f"{(((1 - part) * a + part * b) / 255) ** 2.2:.3f}" for a, b in zip(low, high))


def particles(burst, dem):
    """Rows id radius x y z vx vy vz of restart.liggghts."""
    deck = (burst / "in.liggghts").read_text()
    deck = re.sub(r"region +box block .*\n.*create_box .*\n", "read_restart restart.liggghts\n", deck)
    deck = re.sub(r"read_restart +.*", "read_restart restart.liggghts", deck)
    deck = re.sub(r"processors .*", "processors 1 1 1", deck)
    deck = deck[: deck.index("fix guard")]
    deck += "\ndump d all custom 1 picture.dump id radius x y z vx vy vz\nthermo_modify lost ignore norm no\nrun 0\n"
    (burst / "in.picture").write_text(deck)
    done = subprocess.run([dem, "-in", "in.picture", "-log", "none"], cwd=burst, capture_output=True, text=True)
    if done.returncode != 0:
        sys.exit(f"{dem} could not read the burst back: {done.stdout[-500:]} {done.stderr}")
    text = (burst / "picture.dump").read_text().split("ITEM: ATOMS")[1]
    return [[float(word) for word in line.split()] for line in text.splitlines()[1:]]


def triangles(stl):
    words = [line.split() for line in stl.read_text().splitlines()]
    corner = [tuple(map(float, w[1:])) for w in words if w[:1] == ["vertex"]]
    return [corner[k:k + 3] for k in range(0, len(corner), 3)]


def turned(mesh, origin, axis, angle):
    """Right-handed about a coordinate axis through `origin`."""
    i, j = (axis + 1) % 3, (axis + 2) % 3
    cos, sin = math.cos(angle), math.sin(angle)

    def turn(p):
        q = list(p)
        u, v = p[i] - origin[i], p[j] - origin[j]
        q[i], q[j] = origin[i] + cos * u - sin * v, origin[j] + sin * u + cos * v
        return tuple(q)
    return [[turn(p) for p in corners] for corners in mesh]


def rotation(burst, name):
    """(origin, axis, rad/s) of a body from the script's `rotate NAME o a rad/s W`; None if it stands."""
    found = re.search(rf"rotate {name} " + r"(\S+) " * 6 + r"rad/s (\S+)", (burst / "in.liggghts").read_text())
    if not found:
        return None
    value = [float(x) for x in found.groups()]
    axis = max(range(3), key=lambda k: abs(value[3 + k]))
    return value[:3], axis, value[6] * math.copysign(1.0, value[3 + axis])


def pov_mesh(mesh, texture):
    vector = lambda p: "<" + ",".join(f"{SCALE * x:.5f}" for x in p) + ">"
    rows = "\n".join("triangle {" + ",".join(map(vector, corners)) + "}" for corners in mesh)
    return f"mesh {{\n{rows}\n{texture} }}\n"


SCALE = 100  # POV-Ray takes what is nearer than about 1e-3 for the same place

SCENE = """#version 3.7;
global_settings { assumed_gamma 1.0 max_trace_level 12 }
background { rgb 1 }
#declare Casing = texture { pigment { rgbt <0.40,0.56,0.80,0.90> } finish { ambient 0.2 diffuse 0.35 } }
#declare Metal = finish { ambient 0.10 diffuse 0.62 specular 0.2 roughness 0.08 }
#declare Steel = texture { pigment { rgb <0.62,0.64,0.67> } finish { Metal } }
#declare Chopper = texture { pigment { rgb <0.80,0.58,0.30> } finish { Metal } }
#declare Dull = finish { ambient 0.16 diffuse 0.72 }
"""

VIEWS = {
    "cm5": dict(at="<0.222,0.004,0>", eye="<0.40,0.36,0.86>", up="<0,1,0>", angle=31, size=(1600, 720),
                lights=["<0.2,1.4,1.2>", "<-0.9,0.6,1.2>"]),
    "batch_bowl": dict(at="<0,0,0.027>", eye="<0.13,-0.25,0.165>", up="<0,0,1>", angle=27, size=(1100, 900),
                       lights=["<0.3,-0.6,0.9>", "<-0.8,-0.3,0.5>"]),
}


def main():
    ask = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    ask.add_argument("burst", type=Path)
    ask.add_argument("picture", type=Path)
    ask.add_argument("--dem", default="granary-dem", help="the program granary-dem")
    ask.add_argument("--fastest", type=float, help="speed that is drawn red [m/s] (default: that 1 %% exceed)")
    given = ask.parse_args()
    burst = given.burst.resolve()
    case = json.loads((burst / "case.json").read_text())
    kind = case["machine"]["type"]
    view = VIEWS[kind]
    rows = particles(burst, given.dem)
    last = json.loads((burst / "tallies.jsonl").read_text().splitlines()[-1])
    time = last["step"] * case["time_step"]
    speeds = sorted(math.dist((0, 0, 0), row[5:8]) for row in rows)
    fastest = given.fastest or speeds[int(0.99 * len(speeds))]

    scene = [SCENE]
    for stl in sorted((burst / "meshes").glob("*.stl")):
        mesh, turn = triangles(stl), rotation(burst, stl.stem)
        if turn:
            mesh = turned(mesh, turn[0], turn[1], turn[2] * time)
        look = "texture { Casing } no_shadow" if stl.stem == "shell" else \
            "texture { Chopper }" if stl.stem == "chopper" else "texture { Steel }"
        scene.append(pov_mesh(mesh, look))
    for row in rows:
        share = math.dist((0, 0, 0), row[5:8]) / fastest
        place = ",".join(f"{SCALE * x:.5f}" for x in row[2:5])
        scene.append(f"sphere {{ <{place}>,{SCALE * row[1]:.5f} "
                     f"pigment {{ rgb <{colour(share)}> }} finish {{ Dull }} }}")
    wide, high = view["size"]
    # POV-Ray is left-handed: the mirrored `right` makes its pictures ours.
    scene.append(f"camera {{ location {SCALE}*{view['eye']} sky {view['up']} right -x*{wide}/{high} "
                 f"angle {view['angle']} look_at {SCALE}*{view['at']} }}")
    for light, strength, shadow in zip(view["lights"], (0.95, 0.5), ("", "shadowless")):
        scene.append(f"light_source {{ {SCALE}*{light} rgb {strength} {shadow} }}")
    (burst / "picture.pov").write_text("\n".join(scene))
    options = [f"+O{given.picture.resolve()}", f"+W{wide}", f"+H{high}", "+A0.2", "-D", "+FN8"]
    done = subprocess.run(["povray", "picture.pov", *options], cwd=burst, capture_output=True, text=True)
    if done.returncode != 0:
        sys.exit(f"povray failed: {done.stderr[-2000:]}")
    print(f"{given.picture}: {len(rows)} particles, red from {fastest:.3g} m/s on, "
          f"{last['time_s']:.3g} s from the start")


if __name__ == "__main__":
    main()
