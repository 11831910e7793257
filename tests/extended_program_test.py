#!/usr/bin/env python3
# A technique with two knobs that only a test registers turns up in help, refusals, pictures, JSON, a sweep, its CSV and its report.
# That it has widgets too: knob_widgets_test.cpp.
"""Usage: extended_program_test.py PROGRAM EXTENDED_PROGRAM. Exit codes: 0 passed, 1 failed."""
import csv
import json
import pathlib
import subprocess
import sys
import tempfile

SMALL = ["block", "--volume-size", "24x22x20", "--size", "48x40", "--quiet"]


class Failure(Exception):
    pass


def expect(condition, text):
    if not condition:
        raise Failure(text)


def run(program, *arguments, code=0):
    """The finished process; its exit code must be `code`."""
    process = subprocess.run([program, *arguments], capture_output=True, text=True, timeout=300, check=False)
    expect(process.returncode == code, f"{arguments}: exit code {process.returncode}\n{process.stderr}")
    return process


def check_options(program, extended):
    text = " ".join(run(extended, "shot", "--help").stdout.split())
    for words in ("--fog-density FLOAT", "Share of the light that the fog swallows (Beer 1852), 0 to 1, for fog; default: 0.25",
                  "--fog-tint NAME", "What colours are left: none red, for fog; default: none", "multihit fog"):
        expect(words in text, f"shot --help lacks '{words}': {text}")
    expect("fog" not in run(program, "shot", "--help").stdout, "the program itself has the technique")
    sweep = " ".join(run(extended, "sweep", "--help").stdout.split())
    for words in ("--fog-densities", "Shares of the light that the fog swallows", "--fog-tints"):
        expect(words in sweep, f"sweep --help lacks '{words}'")
    for value, words in (("2", "--fog-density must be between 0 and 1, not 2"), ("much", "'much' is no number")):
        said = run(extended, "shot", *SMALL, "--technique", "fog", "-o", "/dev/null", "--fog-density", value, code=2).stderr
        expect(words in said, f"{value}: {said}")
    said = run(extended, "shot", *SMALL, "--technique", "fog", "-o", "/dev/null", "--fog-tint", "rde", code=2).stderr
    expect("unknown fog tint 'rde'; did you mean 'red'?" in said, said)


def check_pictures(extended, folder):
    pictures = set()
    for arguments in ([], ["--fog-density", "0.75"], ["--fog-tint", "red"]):
        file = folder / "picture.png"
        run(extended, "shot", *SMALL, "--technique", "fog", "-o", str(file), *arguments)
        pictures.add(file.read_bytes())
    expect(len(pictures) == 3, "the knobs do not change the picture")


def check_compare(extended, folder):
    metrics = json.loads(run(extended, "compare", *SMALL, "--out", str(folder / "compare"), "--json", "--fog-tint", "red").stdout)
    expect(metrics["fogDensity"] == 0.25 and metrics["fogTint"] == "red", f"compare: {metrics.get('fogDensity')}, {metrics.get('fogTint')}")
    expect(any(row["technique"] == "fog" for row in metrics["rows"]), "compare has no row of it")


def check_sweep(extended, folder):
    out = folder / "sweep"
    arguments = ["sweep", *SMALL, "--out", str(out), "--techniques", "hold,fog", "--fog-densities", "0.125,0.5", "--fog-tints", "none,red",
                 "--server-sides", "48", "--angles", "0,10", "--links", "4g", "--instants", "1", "--draws", "1"]
    run(extended, *arguments)
    sweep = json.loads((out / "sweep.json").read_text())
    expect(sweep["plan"]["fogDensities"] == [0.125, 0.5] and sweep["plan"]["fogTints"] == ["none", "red"], f"plan: {sweep['plan']}")
    fog = {(row["fogDensity"], row["fogTint"]) for row in sweep["rows"] if row["technique"] == "fog"}
    expect(fog == {(0.125, "none"), (0.125, "red"), (0.5, "none"), (0.5, "red")}, f"rows: {fog}")
    others = {(row["fogDensity"], row["fogTint"]) for row in sweep["rows"] if row["technique"] != "fog"}
    expect(others == {(None, None)}, f"other techniques' rows: {others}")
    errors = {row["fogDensity"]: row["flip"] for row in sweep["rows"]
              if row["technique"] == "fog" and row["angleDeg"] == 0 and row["fogTint"] == "none" and not row["link"]}
    expect(errors[0.125] < errors[0.5], f"denser fog is no worse: {errors}")
    with (out / "sweep.csv").open(newline="") as file:
        rows = list(csv.DictReader(file))
    expect({row["fogTint"] for row in rows} == {"", "none", "red"} and {row["fogDensity"] for row in rows} == {"", "0.125", "0.5"}, "sweep.csv")
    report = (out / "report.html").read_text()
    for words in ("fog of density 0.125, red", "fog of density 0.5"):
        expect(words in report, f"the report lacks '{words}'")
    # The same plan from a file; and a sweep's file is something to choose by.
    plan = folder / "plan.json"
    plan.write_text(json.dumps({key: sweep["plan"][key] for key in ("techniques", "fogDensities", "fogTints", "angles", "links", "draws", "serverSides")}))
    again = json.loads(run(extended, "sweep", *SMALL, "--out", str(folder / "again"), "--plan", str(plan), "--json").stdout)
    expect([row["technique"] for row in again["rows"]] == [row["technique"] for row in sweep["rows"]], "the plan's file gives other rows")
    run(extended, "shot", *SMALL, "--technique", "auto", "--front", str(out / "sweep.json"), "--fog-density", "0.5", "-o", str(folder / "auto.png"))
    plan.write_text(json.dumps({"fogDensitys": [0.5]}))
    said = run(extended, "sweep", *SMALL, "--out", str(folder / "wrong"), "--plan", str(plan), code=1).stderr
    expect("did you mean 'fogDensities'" in said, said)


def main():
    program, extended = sys.argv[1:3]
    with tempfile.TemporaryDirectory() as name:
        folder = pathlib.Path(name)
        check_options(program, extended)
        check_pictures(extended, folder)
        check_compare(extended, folder)
        check_sweep(extended, folder)
    print("one technique more, with two knobs: help, refusals, pictures, JSON, sweep, CSV and report have it")


if __name__ == "__main__":
    try:
        main()
    except Failure as failure:
        print(f"FAILED: {failure}")
        sys.exit(1)
