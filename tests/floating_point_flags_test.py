#!/usr/bin/env python3
# Every compiler pass over this project's sources is told to round each operation as it is written.
# Usage: floating_point_flags_test.py BUILD_FOLDER SOURCE_FOLDER. What each flag is for: CMakeLists.txt.
import json
import pathlib
import shlex
import sys

HOST = ["-ffp-contract=off"]
# nvcc compiles a .cu file for the device itself and hands the host's part to another compiler.
DEVICE = ["--fmad=false", "--prec-div=true", "--prec-sqrt=true", "--ftz=false", "-Xcompiler=-ffp-contract=off"]
# Any of these would let a compiler round otherwise again.
FORBIDDEN = ["-ffast-math", "-Ofast", "-funsafe-math-optimizations", "-fassociative-math", "-freciprocal-math",
             "--use_fast_math", "-use_fast_math", "-ffp-contract=fast", "-ffp-contract=on"]
ROOMS = ["render/", "net/", "app/", "tests/"]


def faults_of(command, source):
    words = shlex.split(command)
    faults = [f"lacks {flag}" for flag in (DEVICE if source.endswith(".cu") else HOST) if flag not in words]
    return faults + [f"has {word}" for word in words if word.removeprefix("-Xcompiler=") in FORBIDDEN]


def main():
    build, sources = (pathlib.Path(argument).resolve() for argument in sys.argv[1:3])
    looked_at, faults = 0, []
    for entry in json.loads((build / "compile_commands.json").read_text()):
        path = pathlib.Path(entry["directory"], entry["file"]).resolve()
        if not path.is_relative_to(sources):
            continue
        name = path.relative_to(sources).as_posix()
        if path.suffix not in (".cpp", ".cu") or path.is_relative_to(build) or not name.startswith(tuple(ROOMS)):
            continue
        looked_at += 1
        faults += [f"{name}: {fault}" for fault in faults_of(entry["command"], name)]
    print("\n".join(faults) or f"{looked_at} sources are compiled to round as they are written")
    return 1 if faults or looked_at < 100 else 0


if __name__ == "__main__":
    sys.exit(main())
