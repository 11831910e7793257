#!/usr/bin/env python3
"""Every test has a timeout of MOST seconds at most: one that hangs would stop the whole suite. Usage: timeouts_test.py CTEST BUILD.

What ctest itself lists: CMake documentation, ctest(1), --show-only=json-v1."""
import json
import subprocess
import sys

MOST = 1500  # of the slowest, where compilers do not optimise
WATCH_THEMSELVES = ("Soak.", "fuzz.")  # they end shortly after the time that they are told to take


def main() -> int:
    ctest, build = sys.argv[1:]
    listed = subprocess.run([ctest, "--test-dir", build, "--show-only=json-v1"], check=True, capture_output=True, text=True).stdout
    tests = json.loads(listed)["tests"]
    limits = {test["name"]: next((entry["value"] for entry in test.get("properties", []) if entry["name"] == "TIMEOUT"), 0) for test in tests}
    without = [name for name, limit in limits.items() if limit <= 0]
    # A test that was not built yet stands in the list as NAME_NOT_BUILT, and has no properties.
    missing = [name for name in without if not name.endswith("_NOT_BUILT")]
    for name in missing:
        print(f"{name} has no TIMEOUT: give it one where it is added in tests/CMakeLists.txt")
    long = [name for name, limit in limits.items() if limit > MOST and not name.startswith(WATCH_THEMSELVES)]
    for name in long:
        print(f"{name} has a TIMEOUT of {limits[name]:g} s: {MOST} are the most")
    print(f"{len(tests) - len(without)} of {len(tests)} tests have a timeout, {len(without) - len(missing)} are not built")
    return 1 if missing or long or len(tests) == len(without) else 0


if __name__ == "__main__":
    sys.exit(main())
