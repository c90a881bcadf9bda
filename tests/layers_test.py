#!/usr/bin/env python3
"""Reads every #include of ours and holds it against the arrows of docs/architecture.md.

A folder may include itself, its own sub-folders' parents as listed, and what its line below allows; and each library
header belongs to the folders of its fence. Run: layers_test.py REPOSITORY
"""
import re
import subprocess
import sys
from pathlib import Path

# folder -> folders it may include besides itself (longest prefix wins)
ALLOWED = {
    "common": ["common"],
    "estimation/breakage": ["common"],
    "estimation/problem": ["common"],
    "estimation/search": ["common"],
    "estimation/trust": ["common", "estimation/search"],
    "estimation/estimator": ["common", "estimation"],
    "pilot": ["common", "pilot"],
    "pbm_solver/case": ["common"],
    "pbm_solver/model": ["common", "pbm_solver/case"],
    "pbm_solver/time": ["common", "pbm_solver/case", "pbm_solver/model"],
    "pbm_solver/parallel": ["common", "pbm_solver/case", "pbm_solver/model", "pbm_solver/time"],
    "pbm_solver/verification": ["common", "pbm_solver", "pilot/launch"],
    "pbm_solver/evaluate": ["common", "pbm_solver", "estimation"],
    "pbm_solver": ["common", "pbm_solver"],
    "dem_templates/case": ["common"],
    "dem_templates/geometry": ["common", "dem_templates/case"],
    "dem_templates/render": ["common", "dem_templates/case", "dem_templates/geometry", "dem_templates/templates.hpp"],
    "dem_templates/plugin/tally": ["common"],
    "dem_templates/plugin": ["common", "dem_templates/plugin"],
    "controller/campaign": ["common", "estimation/problem", "pilot/task", "pilot/schedule", "pbm_solver/case", "dem_templates/case",
                            "dem_templates/geometry", "dem_templates/render"],
    "controller/coupling": ["common", "pbm_solver/case", "dem_templates/case", "controller/monitor"],
    "controller/monitor": ["common"],
    "controller/report": ["common", "pilot/launch"],
    "controller": ["common", "pilot", "estimation", "pbm_solver/case", "dem_templates/case", "dem_templates/geometry",
                   "dem_templates/render", "controller"],
}

# header pattern -> the only folders that may include it
FENCES = {
    r"hdf5\.h|H5": ["common/results"],
    r"mpi\.h": ["pbm_solver/parallel", "dem_templates/plugin"],
    r"nlohmann/|valijson/": ["common/json"],
    r"udunits2\.h": ["common"],
    r"spdlog/": ["common"],
    r"spawn\.h|boost/process|sys/wait\.h|sys/ptrace\.h": ["pilot/launch"],
    r"hwloc": ["pilot/schedule", "pilot/launch"],
    r"openssl/": ["pilot/protocol"],
    r"boost/asio|boost/beast": ["pilot", "controller/serve"],
    r"lammps\.h|atom\.h|fix\.h|modify\.h|pair_gran|neighbor\.h|neigh_list\.h": ["dem_templates/plugin"],
    r"omp\.h": ["pbm_solver"],
    r"Eigen/": ["estimation"],
}


def below(path, folder):
    return path == folder or path.startswith(folder + "/")


def rule_for(folder):
    best = max((f for f in ALLOWED if below(folder, f)), key=len, default=None)
    return best, ([best] + ALLOWED[best]) if best else []


def main(root):
    faults, seen = [], 0
    files = subprocess.run(["git", "-C", root, "ls-files", "-co", "--exclude-standard", "*.cpp", "*.hpp", "*.h"],
                           capture_output=True, text=True, check=True).stdout.split()
    # granary_embed(TARGET HEADER ...) makes headers that are in no folder of ours.
    cmake = subprocess.run(["git", "-C", root, "grep", "-hoE", r"granary_embed\([a-z_-]+ +[^ ]+"], capture_output=True, text=True)
    generated = {Path(line.split()[-1]).name for line in cmake.stdout.splitlines()}
    tops = {f.split("/")[0] for f in ALLOWED}
    for name in files:
        if name.split("/")[0] not in tops or not (Path(root) / name).exists():
            continue
        folder = str(Path(name).parent)
        own, allowed = rule_for(folder)
        for line_number, line in enumerate((Path(root) / name).read_text().splitlines(), 1):
            match = re.match(r'\s*#\s*include\s*([<"])([^>"]+)[>"]', line)
            if not match:
                continue
            seen += 1
            kind, header = match.groups()
            place = f"{name}:{line_number}"
            if kind == '"' and header.split("/")[0] in tops:
                if not (Path(root) / header).exists() and Path(header).name not in generated:
                    faults.append(f"{place}: {header} does not exist")
                elif not any(below(header, f) for f in allowed):
                    faults.append(f"{place}: {own} may not include {header}; allowed: {', '.join(allowed)}")
            for pattern, homes in FENCES.items():
                ours = header.split("/")[0] in tops
                if not ours and re.match(pattern, header) and not any(below(folder, h) for h in homes):
                    faults.append(f"{place}: <{header}> belongs in {', '.join(homes)} only")
    for fault in faults:
        print(fault)
    print(f"{seen} includes read, {len(faults)} against the arrows")
    return 1 if faults or seen == 0 else 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1]))
