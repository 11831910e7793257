#!/usr/bin/env python3
# The table of runs in tests/bench/README.md is what the reports in tests/bench/runs say: each is what `warpscope bench --json` printed.
# A run of today beside one of them: warpscope bench ... --against FILE.
"""Usage: runs_table.py SOURCE_FOLDER [--update]. Exit codes: 0 the table is theirs, 1 it is not."""
import json
import pathlib
import re
import sys

TABLE = re.compile(r"(<!-- table of runs -->\n)(.*?)(<!-- end of table -->)", re.DOTALL)


def figure(value):
    """Three digits, which is as many as runs agree in."""
    if value >= 99.5:
        return f"{value:.0f}"
    return f"{value:.{1 if value >= 9.95 else 2 if value >= 0.995 else 3}f}"


def with_spread(report, key):
    """A median, and half of what is between the quartiles."""
    spread = report.get(key.removesuffix("Ms") + "SpreadMs")
    if spread is None:
        return figure(report[key])
    return figure(report[key]) + (f" ±{0.5 * spread:.2g}" if spread >= 0.002 else " ±0.001" if spread >= 0.001 else "")


def rows_of(name, report):
    for backend in report["backends"]:
        what = f"{report['scene']}, {report['width']}x{report['height']}, {backend['device'].split(',')[0]}"
        server = "; ".join(f"{label} {with_spread(backend, key)}" for label, key in
                           (("march", "marchMs"), ("compaction", "compactMs"), ("copy", "copyMs"), ("encoding", "encodeMs"), ("decoding", "decodeMs")))
        yield f"| **{what}** (`{name}`) | | {server} | {backend['bytes'] / 1000:.0f} kB |"
        for technique in backend["techniques"]:
            rates = " ".join(figure(view["fps"]) for view in technique["views"])
            own = f", march {with_spread(technique, 'marchMs')}; encoding {with_spread(technique, 'encodeMs')}; decoding {with_spread(technique, 'decodeMs')}" if "marchMs" in technique else ""
            size = f"{technique['bytes'] / 1000:.0f} kB" if "bytes" in technique else ""
            yield f"| {technique['technique']} | {rates} | build {with_spread(technique, 'buildMs')}{own} | {size} |"


def main():
    folder = pathlib.Path(sys.argv[1]) / "tests" / "bench"
    page = folder / "README.md"
    text = page.read_text(encoding="utf-8")
    lines = ["| | pictures a second at 0, 10, 25, 45, -30 degrees | ms: medians and half of what is between the quartiles | a frame |", "|---|---|---|---|"]
    for file in sorted((folder / "runs").glob("*.json")):
        lines += rows_of(file.stem, json.loads(file.read_text(encoding="utf-8")))
    table = "\n".join(lines) + "\n"
    if len(TABLE.findall(text)) != 1:
        print("tests/bench/README.md: has no table of runs")
        return 1
    updated = TABLE.sub(lambda match: match[1] + table + match[3], text)
    if updated == text:
        print("the table of runs is what the runs say")
        return 0
    if "--update" not in sys.argv:
        print("tests/bench/README.md: the table of runs is not what tests/bench/runs say; run this with --update")
        return 1
    page.write_text(updated, encoding="utf-8")
    return 0


if __name__ == "__main__":
    sys.exit(main())
