"""A portable build on every level of instructions that this machine has: the loader takes the best by itself, and samples and pictures are the same
on all, bit for bit; and the tests of single parts on those that the loader would not take. Usage: levels_test.py PROGRAM LIBRARY_FOLDER UNIT_TESTS.
Skipped where the machine has one level alone."""
import json
import math
import os
import subprocess
import sys
import tempfile

SKIPPED = 77
LOADER = "/lib64/ld-linux-x86-64.so.2"  # the name that the x86-64 psABI gives it
LEVELS = ["x86-64", "x86-64-v2", "x86-64-v3", "x86-64-v4"]  # each has what those before it have
LIBRARY = "libwarpscope_render.so"
# What the processor must have for a level, as /proc/cpuinfo calls it.
NEEDS = {"x86-64-v2": ["sse4_2", "popcnt"], "x86-64-v3": ["avx2", "fma", "bmi2", "f16c", "movbe"],
         "x86-64-v4": ["avx512f", "avx512bw", "avx512cd", "avx512dq", "avx512vl"]}
PICTURES = [["--technique", technique, "--view-angle", "20"] for technique in ("reference", "hold", "points", "spheres", "splats", "multihit", "rotate", "segments", "proxy")]
SCENES = [["vessels"], ["marschner-lobb", "--heuristic", "expected"], ["shells", "--radius", "opacity", "--step", "0.37"]]


def run(program, *arguments, level=None):
    """By the loader's own choice, or with no other level than this one to choose."""
    loader = [LOADER, "--glibc-hwcaps-mask", level] if level else []
    result = subprocess.run([*loader, program, *arguments], capture_output=True, text=True, timeout=300)
    assert result.returncode == 0, f"{level or 'the best level'}: {' '.join(arguments)} ended with {result.returncode}: {(result.stderr or result.stdout)[-1000:]}"
    return result.stdout


def contents(path):
    with open(path, "rb") as file:
        return file.read()


def level_of(program, level=None):
    return json.loads(run(program, "info", "--json", level=level))["instructionSet"]


def outputs(program, level, folder):
    """name: bytes of everything that must be the same; and compare's figures."""
    os.mkdir(folder)
    made = {}
    for number, scene in enumerate(SCENES):
        for options in PICTURES:
            name = f"{number}-{options[1]}.png"
            run(program, "shot", *scene, *options, "--via", "lbvh", "--backend", "cpu", "--size", "201x157", "-o", f"{folder}/{name}", level=level)
            made[name] = contents(f"{folder}/{name}")
        run(program, "export", *scene, "--backend", "cpu", "--size", "201x157", "--ply", f"{folder}/{number}.ply", level=level)
        made[f"{number}.ply"] = contents(f"{folder}/{number}.ply")
    run(program, "compare", "vessels", "--size", "201x157", "--via", "lbvh", "--backend", "cpu", "--color", "jpeg", "--out", f"{folder}/compare",
        level=level)
    with open(f"{folder}/compare/metrics.json", encoding="utf-8") as file:
        rows = json.load(file)["rows"]
    return made, rows


def check_figures(level, rows, expected):
    """Metrics are sums over vectors, in an order that depends on how long these are: alike, not the same."""
    assert len(rows) == len(expected) > 20
    for row, other in zip(rows, expected):
        for key in ("bytes", "samples", "holeFraction"):
            assert row[key] == other[key], f"{level}: {key} of {row['technique']} is {row[key]}, not {other[key]}"
        for key, tolerance in (("psnrDb", 1e-3), ("ssim", 1e-5), ("flip", 1e-5)):
            a, b = row[key], other[key]
            assert (a is None and b is None) or math.isclose(a, b, abs_tol=tolerance), f"{level}: {key} of {row['technique']} is {a}, not {b}"


def main():
    program, libraries, unit_tests = sys.argv[1:]
    with open("/proc/cpuinfo", encoding="utf-8") as file:
        flags = next(line for line in file if line.startswith("flags")).split()
    levels = [level for level in LEVELS if level == LEVELS[0] or (os.path.exists(f"{libraries}/glibc-hwcaps/{level}/{LIBRARY}") and
                                                                  all(flag in flags for flag in NEEDS[level]))]
    for level in levels:
        found = level_of(program, level)
        assert found == level, f"where the loader may take {level} alone, the library is for {found}"
    assert level_of(program) == levels[-1], f"the loader takes {level_of(program)} where {levels[-1]} is there"
    if len(levels) == 1:
        print("Skipped: this processor has none of the levels beyond x86-64.")
        sys.exit(SKIPPED)
    with tempfile.TemporaryDirectory() as folder:
        expected, rows = outputs(program, levels[0], f"{folder}/{levels[0]}")
        for level in levels[1:]:
            made, others = outputs(program, level, f"{folder}/{level}")
            different = [name for name in expected if made[name] != expected[name]]
            assert not different, f"{level} makes other files than {levels[0]}: {' '.join(different)}"
            check_figures(level, others, rows)
    for level in levels[:-1]:
        run(unit_tests, "--gtest_brief=1", level=level)
    print(f"{len(expected)} pictures and clouds are the same on {' '.join(levels)}")


main()
