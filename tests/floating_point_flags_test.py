#!/usr/bin/env python3
# Every compiler pass over this project's sources is told to round each operation as it is written.
# Usage: floating_point_flags_test.py BUILD_FOLDER SOURCE_FOLDER. What each flag is for: CMakeLists.txt.
import json
import pathlib
import re
import shlex
import sys

HOST = ["-ffp-contract=off"]
# nvcc compiles a .cu file for the device itself and hands the host's part to another compiler.
DEVICE = ["--fmad=false", "--prec-div=true", "--prec-sqrt=true", "--ftz=false", "-Xcompiler=-ffp-contract=off"]
# Any of these would let a compiler round otherwise again, take NaN and infinity for impossible, or flush denormal numbers.
FORBIDDEN = ["-ffast-math", "-Ofast", "-funsafe-math-optimizations", "-fassociative-math", "-freciprocal-math", "-mrecip",
             "-ffinite-math-only", "-fno-signed-zeros", "-mdaz-ftz", "-fcx-limited-range",
             "-fexcess-precision=fast", "--use_fast_math", "-use_fast_math", "--fmad=true", "--ftz=true", "--prec-div=false",
             "--prec-sqrt=false", "-ffp-contract=fast", "-ffp-contract=on"]
# Linking with one of these adds start-up code that flushes denormal numbers (GCC's crtfastmath.o).
FORBIDDEN_LINKING = ["-ffast-math", "-Ofast", "-funsafe-math-optimizations", "-mdaz-ftz"]
ROOMS = ["render/", "net/", "app/", "tests/"]


# In a unity build one entry is of several sources, which a file in the build folder includes.
UNITY = re.compile(r'^#include "(.*)"$', re.MULTILINE)


def compiled_by(entry):
    path = pathlib.Path(entry["directory"], entry["file"]).resolve()
    return [pathlib.Path(source).resolve() for source in UNITY.findall(path.read_text())] if path.parent.name == "Unity" else [path]


def faults_of(command, source):
    words = shlex.split(command)
    faults = [f"lacks {flag}" for flag in (DEVICE if source.endswith(".cu") else HOST) if flag not in words]
    return faults + [f"has {word}" for word in words if word.removeprefix("-Xcompiler=") in FORBIDDEN]


def main():
    build, sources = (pathlib.Path(argument).resolve() for argument in sys.argv[1:3])
    looked_at, rooms, faults, on_device = 0, set(), [], {"render": 0, "tests": 0}
    for entry in json.loads((build / "compile_commands.json").read_text()):
        for path in compiled_by(entry):
            if not path.is_relative_to(sources):
                continue
            name = path.relative_to(sources).as_posix()
            if path.suffix not in (".cpp", ".cu") or path.is_relative_to(build) or not name.startswith(tuple(ROOMS)):
                continue
            looked_at += 1
            if path.suffix == ".cu":
                on_device[name.split("/")[0]] += 1
            rooms.add(name.split("/")[0] + "/")
            faults += [f"{name}: {fault}" for fault in faults_of(entry["command"], name)]
    linked = 0
    for line in (build / "build.ninja").read_text().splitlines():
        key, _, value = line.strip().partition(" = ")
        if key in ("LINK_FLAGS", "FLAGS", "LINK_LIBRARIES"):
            linked += key == "LINK_LIBRARIES"
            faults += [f"build.ninja: links with {word}" for word in value.split() if word in FORBIDDEN_LINKING]
    faults += [f"no source of {room} is compiled" for room in ROOMS if room not in rooms]
    if on_device["tests"] > 0 and on_device["render"] < 20:
        faults.append(f"of render/ {on_device['render']} sources are compiled for devices")
    print("\n".join(faults) or f"{looked_at} sources are compiled, and {linked} programs and libraries linked, to round as they are written")
    return 1 if faults or looked_at < 100 or linked < 5 else 0


if __name__ == "__main__":
    sys.exit(main())
