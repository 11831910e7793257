#!/usr/bin/env python3
"""Every test has a timeout: one that hangs would stop the whole suite. Usage: timeouts_test.py CTEST BUILD.

What ctest itself lists: CMake documentation, ctest(1), --show-only=json-v1."""
import json
import subprocess
import sys


def main() -> int:
    ctest, build = sys.argv[1:]
    listed = subprocess.run([ctest, "--test-dir", build, "--show-only=json-v1"], check=True, capture_output=True, text=True).stdout
    tests = json.loads(listed)["tests"]
    without = [test["name"] for test in tests if not any(entry["name"] == "TIMEOUT" and entry["value"] > 0 for entry in test.get("properties", []))]
    # A test that was not built yet stands in the list as NAME_NOT_BUILT, and has no properties.
    missing = [name for name in without if not name.endswith("_NOT_BUILT")]
    for name in missing:
        print(f"{name} has no TIMEOUT: give it one where it is added in tests/CMakeLists.txt")
    print(f"{len(tests) - len(without)} of {len(tests)} tests have a timeout, {len(without) - len(missing)} are not built")
    return 1 if missing or len(tests) == len(without) else 0


if __name__ == "__main__":
    sys.exit(main())
