#!/usr/bin/env python3
# What the real window does while its own server marches: pictures of the display a second, and milliseconds of a march, camera moving.
# Xvfb and llvmpipe, a pointer that drags in circles (xdotool); figures are `view --report`'s. A measurement, not a test.
"""Usage: window_bench.py [--scene NAME] [--size WxH] [--left T] [--right T] [--seconds N] [--runs N] [--rest S] PROGRAM... [-- OPTION...]

Of each program, in turns: framesPerSecond and the longest gap of the display, pictures a second of both panels, median and longest march.
--rest S: the pointer rests every second for S seconds. What follows -- is for every program's `view`."""
import argparse
import json
import math
import os
import subprocess
import sys
import tempfile
import time

sys.path.insert(0, os.path.join(os.path.dirname(os.path.abspath(__file__)), "..", "ui"))
import window_test as ui  # noqa: E402

PERIOD_S = 4.0       # of a circle of the pointer
RADIUS_PX = 60
STEP_S = 0.008       # between two moves of the pointer: twice as often as the display draws
OPENING_S = 3.0      # for the scene, before the pointer moves


def circle(seconds, rest_s):
    """One command of xdotool that drags for so long."""
    command = ["xdotool", "mousedown", "1"]
    before, passed = (RADIUS_PX, 0), 0.0
    while passed < seconds:
        passed += STEP_S
        angle = 2.0 * math.pi * passed / PERIOD_S
        now = (round(RADIUS_PX * math.cos(angle)), round(RADIUS_PX * math.sin(angle)))
        if now != before:
            command += ["mousemove_relative", "--", str(now[0] - before[0]), str(now[1] - before[1])]
        before = now
        isSecondOver = int(passed) != int(passed - STEP_S)
        command += ["sleep", str(rest_s if rest_s > 0.0 and isSecondOver else STEP_S)]
    return command + ["mouseup", "1"]


def measured(program, arguments, view_options):
    with tempfile.TemporaryDirectory() as folder, ui.Display(1280, 1024) as display:
        report = os.path.join(folder, "report.json")
        window = ui.Program(display, [program, "view", arguments.scene, "--left", arguments.left, "--right", arguments.right, "--size", arguments.size,
                                      "--report", report, *view_options])
        window.find_window()
        time.sleep(OPENING_S)
        window.point(window.middle_of_panel(0))
        display.run(*circle(arguments.seconds, arguments.rest))
        window.key("Escape")
        window.process.wait(timeout=30)
        with open(report, encoding="utf-8") as file:
            return json.load(file)


def main():
    own, view_options = sys.argv[1:], []
    if "--" in own:
        own, view_options = own[:own.index("--")], own[own.index("--") + 1:]
    parser = argparse.ArgumentParser()
    parser.add_argument("--scene", default="vessels")
    parser.add_argument("--size", default="800x600")
    parser.add_argument("--left", default="spheres")
    parser.add_argument("--right", default="splats")
    parser.add_argument("--seconds", type=float, default=8.0)
    parser.add_argument("--runs", type=int, default=3)
    parser.add_argument("--rest", type=float, default=0.0)
    parser.add_argument("programs", nargs="+")
    arguments = parser.parse_args(own)
    for run in range(arguments.runs):
        for program in arguments.programs:
            figures = measured(program, arguments, view_options)
            marches = figures.get("movingMarchMs") or {}
            pictures = figures.get("picturesPerSecond") or []
            print(f"{run} {program}: display {figures['framesPerSecond']:.1f}/s, longest gap {figures['gapMs']['longest']:.0f} ms; "
                  f"panels {', '.join(f'{rate:.1f}' for rate in pictures)}/s; march {marches.get('median', float('nan')):.0f} ms, "
                  f"longest {marches.get('longest', float('nan')):.0f}; frames {figures['framesReceived']}; "
                  f"age {figures['ageMs']['median']:.0f} ms", flush=True)


if __name__ == "__main__":
    main()
