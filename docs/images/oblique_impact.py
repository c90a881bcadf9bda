#!/usr/bin/env python3
"""Oblique impacts on a meshed wall, by granary-dem and by the program liggghts, drawn beside the rigid-body limits.

    docs/images/oblique_impact.py docs/images/dem_oblique.svg --dem build/bin/granary-dem

Spheres of 4 mm hit a plane of two triangles at 1 m/s under 2 to 84 degrees, friction 0.3, with three restitutions:

    x = 2 v_t / (7 mu (1 + e) v_n)     y = J_t / (mu J_n)     sticking: y = x     sliding: y = 1

Source: Foerster, Louge, Chang and Allia, Physics of Fluids 6 (1994) 1108. Needs gnuplot and liggghts, for the docs only.
"""
import argparse
import math
import subprocess
import sys
import tempfile
from pathlib import Path

FRICTION, SPEED, RADIUS = 0.3, 1.0, 0.002
ANGLES = range(2, 85, 2)
COLOURS = {0.9: "#2563eb", 0.6: "#059669", 0.3: "#d97706"}

WALL = """solid wall
facet normal 0 0 1
outer loop
vertex -1 -1 0
vertex 1 -1 0
vertex 1 1 0
endloop
endfacet
facet normal 0 0 1
outer loop
vertex -1 -1 0
vertex 1 1 0
vertex -1 1 0
endloop
endfacet
endsolid wall
"""


def deck(restitution, wall):
    lines = ["atom_style granular", "atom_modify map array", "boundary f f f", "newton off",
             "communicate single vel yes", "units si", "region box block -1.1 1.1 -1.1 1.1 -0.01 0.1 units box",
             "create_box 2 box", "neighbor 0.001 bin", "neigh_modify delay 0",
             "fix m1 all property/global youngsModulus peratomtype 5e6 5e8",
             "fix m2 all property/global poissonsRatio peratomtype 0.3 0.3",
             f"fix m3 all property/global coefficientRestitution peratomtypepair 2{4 * f' {restitution}'}",
             f"fix m4 all property/global coefficientFriction peratomtypepair 2{4 * f' {FRICTION}'}",
             "pair_style gran model hertz tangential history", "pair_coeff * *", "timestep 2e-6",
             "fix integrate all nve/sphere", wall, "thermo_modify lost ignore norm no"]
    for i, angle in enumerate(ANGLES):
        a = math.radians(angle)
        lines += [f"create_atoms 1 single 0 {0.01 * i - 0.3} {RADIUS + 1e-5} units box",
                  f"set atom {i + 1} density 1000 diameter {2 * RADIUS} vx {SPEED * math.sin(a)} vy 0 "
                  f"vz {-SPEED * math.cos(a)}"]
    return "\n".join(lines + ["dump d all custom 5000 after.dump id vx vz", "dump_modify d sort id format '%d %.15g %.15g'",
                              "run 5000"]) + "\n"


def rebounds(program, restitution, wall):
    """[(x, y)] of all angles."""
    with tempfile.TemporaryDirectory() as folder:
        Path(folder, "wall.stl").write_text(WALL)
        Path(folder, "in.impact").write_text(deck(restitution, wall))
        done = subprocess.run([program, "-in", "in.impact", "-log", "none"], cwd=folder, capture_output=True, text=True)
        if done.returncode != 0:
            sys.exit(f"{program}: {done.stdout[-500:]}{done.stderr}")
        rows = Path(folder, "after.dump").read_text().split("ITEM: ATOMS")[-1].splitlines()[1:]
    points = []
    for angle, row in zip(ANGLES, rows):
        a = math.radians(angle)
        _, vx, vz = (float(word) for word in row.split())
        normal, tangential = SPEED * math.cos(a) + vz, SPEED * math.sin(a) - vx
        points.append((2 * math.tan(a) / (7 * FRICTION * (1 + restitution)), tangential / (FRICTION * normal)))
    return points


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("picture", type=Path)
    parser.add_argument("--dem", default="granary-dem")
    parser.add_argument("--stock", default="liggghts")
    given = parser.parse_args()
    ours = "fix walls all granary/wall type 2 mesh wall wall.stl"
    stock = ("fix wall all mesh/surface file wall.stl type 2\n"
             "fix walls all wall/gran model hertz tangential history mesh n_meshes 1 meshes wall")
    plot = ["set encoding utf8",
            "set terminal svg noenhanced size 760,440 dynamic font 'system-ui,sans-serif,13' background '#ffffff'",
            f"set output '{given.picture}'", "set border 3 lc rgb '#94a3b8' lw 1",
            "set tics out nomirror scale 0.5 textcolor rgb '#334155'", "set xrange [0:3]", "set yrange [0:1.7]",
            "set key outside right top Left reverse", "set xlabel '2 v_t / (7 μ (1 + e) v_n)'",
            "set ylabel 'J_t / (μ J_n)'"]
    curves = ["(x <= 1 ? x : 1/0) lc rgb '#94a3b8' lw 2 title 'sticks'",
              "(x >= 1 ? 1 : 1/0) lc rgb '#334155' lw 2 title 'slides'"]
    program = str(Path(given.dem).resolve()) if "/" in given.dem else given.dem
    largest = 0.0
    for e, colour in COLOURS.items():
        mine, theirs = rebounds(program, e, ours), rebounds(given.stock, e, stock)
        largest = max([largest] + [abs(a[1] - b[1]) for a, b in zip(mine, theirs)])
        for name, points, mark in (("granary-dem", mine, 6), ("liggghts", theirs, 2)):
            data = f"$d{len(curves)}"
            plot += [f"{data} << EOD"] + [f"{x} {y}" for x, y in points] + ["EOD"]
            curves.append(f"{data} with points pt {mark} ps {0.9 if mark == 6 else 0.5} lc rgb '{colour}' title '{name}, e = {e}'")
    subprocess.run(["gnuplot"], input="\n".join(plot + ["plot " + ", ".join(curves)]), text=True, check=True)
    print(f"{given.picture}: granary-dem and liggghts differ by at most {largest:.1g} of J_t / (mu J_n)")


if __name__ == "__main__":
    main()
