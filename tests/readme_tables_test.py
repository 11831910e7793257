#!/usr/bin/env python3
# The READMEs' tables of knobs, commands and the like are what the program prints; its options, as far as they name them, are real.
# A table stands between <!-- warpscope info --table NAME --> and <!-- end of table -->.
"""Usage: readme_tables_test.py PROGRAM SOURCE_FOLDER [--update]. Exit codes: 0 passed, 1 failed."""
import pathlib
import re
import subprocess
import sys

TABLE = re.compile(r"(<!-- warpscope info --table (\S+) -->\n)(.*?)(<!-- end of table -->)", re.DOTALL)
# Options of other programs that the READMEs quote.
FOREIGN = {"--glibc-hwcaps-mask", "--test-dir", "--preset", "--build", "--install", "--prefix", "--target", "--yes", "--update", "--gtest_filter", "--clock-control", "--legs", "--long", "--no-deps", "--require-hashes",
           "--bind-to", "--map-by", "--hostfile", "--mpi", "--oversubscribe"}


def output(program, *arguments):
    return subprocess.run([program, *arguments], capture_output=True, text=True, timeout=60, check=True).stdout


def known_options(program):
    """Every option of every command."""
    options = set()
    commands = re.findall(r"^  (\w+) ", output(program, "--help").split("Subcommands:")[1], re.MULTILINE)
    for text in [output(program, "--help")] + [output(program, command, "--help") for command in commands]:
        options.update(re.findall(r"--[a-z][a-z0-9-]*", text))
    return options


def main():
    program, root = sys.argv[1], pathlib.Path(sys.argv[2])
    pages = sorted(p for p in root.rglob("README.md") if "build" not in p.relative_to(root).parts[0])
    problems, seen = [], set()
    options = known_options(program)
    for page in pages:
        name = page.relative_to(root).as_posix()
        text = page.read_text(encoding="utf-8")

        def fresh(match):
            seen.add(match[2])
            return match[1] + output(program, "info", "--table", match[2]) + match[4]

        updated = TABLE.sub(fresh, text)
        if updated != text:
            if "--update" in sys.argv:
                page.write_text(updated, encoding="utf-8")
            else:
                problems.append(f"{name}: a table is not what the program prints; run this test with --update")
        for option in sorted(set(re.findall(r"(?<![\w-])--[a-z][a-z0-9-]+", updated)) - options - FOREIGN):
            problems.append(f"{name}: no command knows {option}")
    for table in ("commands", "heuristics", "knobs", "link-keys", "links", "radii", "techniques"):
        if table not in seen:
            problems.append(f"no README has the table {table}")
    lines = (root / "README.md").read_text(encoding="utf-8").count("\n")
    if lines > 120:
        problems.append(f"README.md has {lines} lines: what newcomers do not need stands in the READMEs of the rooms")
    print("\n".join(problems) if problems else "tables and options of the READMEs are the program's")
    return 1 if problems else 0


if __name__ == "__main__":
    sys.exit(main())
