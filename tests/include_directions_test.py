#!/usr/bin/env python3
# Includes keep their direction: a room uses only what lies below it, and a library stays in the room it is for.
# Usage: include_directions_test.py SOURCE_FOLDER. Rooms and their order: app/README.md, render/README.md.
import pathlib
import re
import sys

# From the ground up; each may include itself and those before it.
APP_ROOMS = ["app/picture", "app/shell", "app/scene", "app/frames", "app/experiment", "app/session", "app/ui", "app/commands"]
# Files that may lie in app/ itself.
APP_LOOSE = {"app/main.cpp"}

# Headers of other people that one room alone may know.
PRIVATE_LIBRARIES = {
    r"imgui|GLFW/": ["app/ui/"],
    r"CLI/": ["app/commands/", "app/main.cpp"],
    r"boost/asio|openssl/ssl": ["net/", "app/shell/interrupt.cpp"],
    r"cuda|cub/|thrust/": ["render/"],
    r"itk[A-Z]": ["render/volume/"],
    r"embree": ["render/warp/lbvh/"],
}


def room_of(path):
    """The room of APP_ROOMS, or the top-level folder."""
    for room in APP_ROOMS:
        if path.startswith(room + "/"):
            return room
    return path.split("/")[0]


def may_include(path, included):
    """Whether the file may include that project header; the reason if not."""
    top, target = path.split("/")[0], included.split("/")[0]
    if path.startswith("render/base/"):
        return included.startswith("render/base/") or "render/base is the ground: it includes nothing else of the project"
    if top == "render":
        return target == "render" or "render/ knows neither net/ nor app/"
    if top == "net":
        return target == "net" or included.startswith("render/base/") or "net/ knows of render/ its base alone"
    if top == "app" and target == "app":
        if path in APP_LOOSE:
            return True
        here, there = room_of(path), room_of(included)
        if here not in APP_ROOMS or there not in APP_ROOMS:
            return "it lies in no room"
        return APP_ROOMS.index(there) <= APP_ROOMS.index(here) or f"{there} is above {here}"
    return top == "app" and target in ("render", "net") or f"{target}/ is above {top}/"


def findings(root):
    """One line for each include that goes the wrong way."""
    sources = [p for folder in ("render", "net", "app") for p in sorted((root / folder).rglob("*")) if p.suffix in (".h", ".cpp", ".cu", ".cuh")]
    if len(sources) < 100:
        yield f"{root} holds {len(sources)} sources: this is not the project"
    for source in sources:
        path = source.relative_to(root).as_posix()
        if path.count("/") == 1 and path.startswith("app/") and path not in APP_LOOSE:
            yield f"{path}: lies loose in app/"
        for number, line in enumerate(source.read_text(encoding="utf-8").splitlines(), 1):
            include = re.match(r'\s*#\s*include\s*([<"])([^>"]+)[>"]', line)
            if not include:
                continue
            quote, name = include.groups()
            if name.startswith("."):
                yield f"{path}:{number}: includes {name}: includes begin at the project's root"
            if quote == '"' and "/" in name and (root / name).exists():
                answer = may_include(path, name)
                if answer is not True:
                    yield f"{path}:{number}: includes {name}: {answer}"
            for library, rooms in PRIVATE_LIBRARIES.items():
                if re.match(library, name) and not (root / name).exists() and not any(path.startswith(room) for room in rooms):
                    yield f"{path}:{number}: includes {name}, which is for {' '.join(rooms)}"


def main():
    problems = list(findings(pathlib.Path(sys.argv[1])))
    print("\n".join(problems) if problems else "every include keeps its direction")
    # The check itself: these would be refused.
    for path, included in [("net/a.cpp", "render/core/image.h"), ("render/a.cpp", "net/client.h"), ("render/base/a.h", "render/core/image.h"),
                           ("app/scene/a.h", "app/session/session.h"), ("app/experiment/a.cpp", "app/ui/window.h")]:
        assert may_include(path, included) is not True, (path, included)
    return 1 if problems else 0


if __name__ == "__main__":
    sys.exit(main())
