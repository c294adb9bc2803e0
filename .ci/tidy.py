#!/usr/bin/python3
# SPDX-FileCopyrightText: The latticed authors
# SPDX-License-Identifier: Apache-2.0
"""usage: tidy.py FOLDER JOBS

Runs clang-tidy on the units of FOLDER/compile_commands.json, one for each target. Headers take most of its time, so the
targets of a top folder are checked as one unit, by the options of all. Where their names clash, or clang-tidy finds
something, each target is checked alone, and that alone counts. Generated code is left out.
"""
import json
import pathlib
import shlex
import subprocess
import sys
from concurrent.futures import ThreadPoolExecutor

ALONE = ("server/store/postgres/", "server/store/sqlite/")  # they use the same names
PAIRS = ("-I", "-isystem", "-include")  # their value is the next argument


class Unit:
    def __init__(self, entry, root, folder):
        self.path = pathlib.Path(entry["file"])
        self.options = self._options(shlex.split(entry["command"])[1:])
        base = folder if folder in self.path.parents else root
        # Such as core/mesh/CMakeFiles/latticed_mesh.dir/Unity/unity_0_cxx.cxx.
        self.place = self.path.relative_to(base).as_posix()

    def _options(self, arguments):
        options, rest = [], iter(arguments)
        for argument in rest:
            if argument == "-o":
                next(rest)
            elif argument in PAIRS:
                options.append((argument, next(rest)))
            elif argument not in ("-c", str(self.path)):
                options.append((argument,))
        return options

    @property
    def is_generated(self):
        return self.place.startswith("proto/") or self.place.endswith(".pb.cc")

    @property
    def is_alone(self):
        """Whether it is a program, or a file with options of its own, or one of the stores."""
        is_program = ("-fPIE",) in self.options
        return is_program or "/Unity/" not in self.place or self.place.startswith(ALONE)


def merged(name, units, folder):
    """Writes a unit with the sources of several, and a compile_commands.json beside it."""
    place = folder / "merged" / name
    place.mkdir(parents=True, exist_ok=True)
    path = place / f"{name}.cxx"
    path.write_text("".join(f'#include "{unit.path}"\n' for unit in units))
    options = dict.fromkeys(option for unit in units for option in unit.options)
    arguments = ["c++", *(word for option in options for word in option), "-c", str(path)]
    entry = {"directory": str(folder), "file": str(path), "arguments": arguments}
    (place / "compile_commands.json").write_text(json.dumps([entry]))
    return path, place


def tidy(path, database):
    """Returns whether clang-tidy finds nothing, and what it prints."""
    command = ["clang-tidy-14", "--quiet", "-p", database, "--extra-arg=-Wno-unknown-warning-option", path]
    run = subprocess.run(command, stdout=subprocess.PIPE, stderr=subprocess.DEVNULL, text=True)
    return run.returncode == 0, run.stdout


def main(folder, jobs):
    folder, root = pathlib.Path(folder).resolve(), pathlib.Path.cwd()
    entries = json.loads((folder / "compile_commands.json").read_text())
    units = [Unit(entry, root, folder) for entry in entries if entry["file"].endswith((".cc", ".cxx"))]
    groups, single = {}, []
    for unit in units:
        if unit.is_generated:
            continue
        if unit.is_alone:
            single.append(unit)
        else:
            groups.setdefault(unit.place.split("/")[0], []).append(unit)
    with ThreadPoolExecutor(jobs) as pool:
        largest_first = sorted(groups.items(), key=lambda group: -len(group[1]))
        together = [(name, pool.submit(tidy, *merged(name, group, folder))) for name, group in largest_first]
        alone = [pool.submit(tidy, unit.path, folder) for unit in single]
        for name, run in together:
            is_clean, text = run.result()
            if not is_clean:
                print(f"{name}: as one unit it fails, so its targets are checked alone:\n{text}", flush=True)
                alone += [pool.submit(tidy, unit.path, folder) for unit in groups[name]]
        results = [run.result() for run in alone]
    print("".join(text for _, text in results), end="")
    return 0 if all(is_clean for is_clean, _ in results) else 1


if __name__ == "__main__":
    sys.exit(main(sys.argv[1], int(sys.argv[2])))
