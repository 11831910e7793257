#!/usr/bin/env python3
# The table of hard cases in README.md is what the tests found: the same rows, held to the same bounds.
# The tests leave their rows in a folder, one JSON file a test: record.h.
"""Usage: table.py check|update|clear RECORDS_FOLDER README.
Exit codes: 0 done, 1 the table is not what was found, 2 usage.

`clear` empties the folder before a run. Rows of a backend that was not run stay as they are in the README, as long as
the CPU has a row of that case, function, oracle and bound."""
import json
import pathlib
import re
import sys

BEGIN, END = "<!-- what the stability tests found -->\n", "<!-- end of what they found -->\n"
HEAD = ("| case | what | oracle | worst error seen | bound | backend |\n"
        "|---:|---|---|---|---|---|\n")


def number(value):
    """Three digits, the last rounded up for an error that is not 0."""
    return "0" if value == 0 else f"{value:.3g}"


def row_of(record):
    """The cells of a record."""
    unit = f" {record['unit']}" if record["unit"] else ""
    bound = "exact" if record["bound"] == 0 else number(record["bound"]) + unit
    worst = number(record["worst"]) if isinstance(record["worst"], (int, float)) else record["worst"]
    if record["bound"] == 0 and not record["worst"]:
        worst = "none"
    return (str(record["case"]), record["what"], record["oracle"], worst, bound, record["backend"])


def key(row):
    """What must be the same in the README and in a run: all but the worst error."""
    return row[:3] + row[4:]


def order(row):
    return (int(row[0]), row[1], row[2], row[5] != "cpu")


def rows_found(folder):
    rows = {}
    for file in sorted(folder.glob("*.json")):
        for record in json.loads(file.read_text(encoding="utf-8")):
            row = row_of(record)
            if any("|" in cell for cell in row):
                sys.exit(f"{file.name}: a cell of the table cannot hold a bar: {row}")
            if key(row) in rows and rows[key(row)] != row:
                sys.exit(f"{file.name}: another test has recorded {row[1]} of case {row[0]} by {row[2]} already")
            rows[key(row)] = row
    return rows


def rows_written(text):
    found = re.search(re.escape(BEGIN) + "(.*?)" + re.escape(END), text, re.DOTALL)
    if not found:
        sys.exit(f"the README lacks the line {BEGIN.strip()} or {END.strip()}")
    rows = {}
    for line in found[1].splitlines()[2:]:
        row = tuple(cell.strip() for cell in line.strip().strip("|").split("|"))
        if len(row) != 6:
            sys.exit(f"not a row of the table: {line}")
        rows[key(row)] = row
    return rows


def kept(written, found):
    """Rows of backends that were not run, whose twins on the CPU were."""
    backends_run = {row[5] for row in found.values()}
    on_cpu = {row[:3] + (row[4],) for row in found.values() if row[5] == "cpu"}
    return {k: row for k, row in written.items() if row[5] not in backends_run and row[:3] + (row[4],) in on_cpu}


def main():
    if len(sys.argv) != 4 or sys.argv[1] not in ("check", "update", "clear"):
        print(__doc__, file=sys.stderr)
        return 2
    what, folder, page = sys.argv[1], pathlib.Path(sys.argv[2]), pathlib.Path(sys.argv[3])
    if what == "clear":
        for file in folder.glob("*.json"):
            file.unlink()
        return 0
    found = rows_found(folder)
    if not found:
        print(f"{folder} holds no records: run the tests first, with ctest -L stability")
        return 1
    text = page.read_text(encoding="utf-8")
    written = rows_written(text)
    if what == "update":
        rows = sorted({**kept(written, found), **found}.values(), key=order)
        table = HEAD + "".join("| " + " | ".join(row) + " |\n" for row in rows)
        old = re.compile(re.escape(BEGIN) + "(.*?)" + re.escape(END), re.DOTALL)
        fresh = old.sub(lambda _: BEGIN + table + END, text)
        page.write_text(fresh, encoding="utf-8")
        print(f"{len(rows)} rows, {len(found)} of them of this run")
        return 0
    problems = [f"not in the README: {' | '.join(found[k])}" for k in found if k not in written]
    stay = kept(written, found)
    lost = [row for k, row in written.items() if k not in found and k not in stay]
    problems += [f"in the README, but no test found it: {' | '.join(row)}" for row in lost]
    if problems:
        problems.append(f"after a run of all of them: python3 tests/stability/table.py update {folder} {page}")
    said = f"{len(found)} rows are as {page.name} says, {len(stay)} of backends that are not here stay"
    print("\n".join(problems) if problems else said)
    return 1 if problems else 0


if __name__ == "__main__":
    sys.exit(main())
