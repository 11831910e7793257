#!/usr/bin/env python3
# Files that are dragged onto the real window by another program, one and several at once.
# Xvfb; the other program speaks the XDND protocol itself (x_client.py).
"""Usage: drop_test.py PROGRAM. Exit codes: 0 passed, 1 failed, 77 skipped."""
import json
import os
import shutil
import sys
import tempfile

import window_test as ui
import x_client

LENGTH = 24
RED = {"points": [{"value": value, "color": [1, 0, 0], "alpha": alpha} for value, alpha in ((0, 0), (100, 0), (255, 0.5))]}


def write_ball(path):
    middle = (LENGTH - 1) / 2
    places = range(LENGTH)
    with open(path, "wb") as file:
        file.write(bytes(200 if (x - middle) ** 2 + (y - middle) ** 2 + (z - middle) ** 2 < 90 else 0 for z in places for y in places for x in places))


def is_all_red(region):
    """True if there is something, and what is no grey of the window's is red."""
    tinted = [region[i:i + 3] for i in range(0, len(region), 3 * 5) if max(region[i:i + 3]) - min(region[i:i + 3]) > 60]
    return len(tinted) > 50 and all(pixel[0] > 2 * max(pixel[1], pixel[2]) for pixel in tinted)


def drop(display, program, *paths):
    place = program.middle_of_panel(0)  # there is no window manager, and the window is as large as the screen
    if not x_client.drop_files(display.name, program.window, place, paths):
        raise ui.Failure(f"the window does not take {paths}")


def run(executable):
    with ui.Display(1280, 800) as display, tempfile.TemporaryDirectory() as folder:
        home = os.path.join(folder, "ünder a blank")  # which URIs write as %C3%BC and %20
        os.mkdir(home)
        ball, other = (os.path.join(home, f"{name}_{LENGTH}x{LENGTH}x{LENGTH}_uint8.raw") for name in ("ball", "other"))
        function, text = os.path.join(home, "red.json"), os.path.join(home, "list.txt")
        write_ball(ball)
        shutil.copy(ball, other)
        with open(function, "w", encoding="utf-8") as file:
            json.dump(RED, file)
        with open(text, "w", encoding="utf-8") as file:
            file.write("nothing that is a volume")
        program = ui.Program(display, [executable, "view", *ui.SCENE, "--left", "hold", "--right", "spheres"])
        program.find_window()
        program.wait_for_panels("both panels show something")

        def title():
            return display.run("xdotool", "getwindowname", program.window).stdout.decode()

        drop(display, program, ball)
        program.wait_until("the volume that was dropped", lambda: "ball" in title())
        program.wait_for_panels("its pictures")
        if any(is_all_red(region) for region in program.settled()):
            raise ui.Failure("it is red by itself, so that nothing is to be seen of what follows")

        drop(display, program, function, other)  # what is about a scene first, as a file manager's order by name may have it
        program.wait_until("the second volume", lambda: "other" in title())
        program.wait_until("its transfer function, dropped with it", lambda: all(is_all_red(region) for region in program.regions()))

        before = title()
        drop(display, program, text)
        program.settled()
        if title() != before or not all(is_all_red(region) for region in program.regions()):
            raise ui.Failure("a file that is no volume changed what is on show")
        program.key("ctrl+q")
        program.ends("Ctrl-Q")


def main():
    missing = [tool for tool in ("Xvfb", "xdotool", "import") if shutil.which(tool) is None]
    if missing:
        print("skipped: not installed: " + " ".join(missing))
        return ui.SKIPPED
    try:
        run(sys.argv[1])
    except (ui.Failure, TimeoutError) as failure:
        print(failure)
        return 1
    return 0


if __name__ == "__main__":
    sys.exit(main())
