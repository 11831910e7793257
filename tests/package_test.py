"""What `cmake --install` and cpack leave: every file in its place, a program that runs from there and needs nothing of the build folder, a man
page that knows every command and option; a package with its dependencies. Usage: package_test.py installed|packed CMAKE BUILD_FOLDER VERSION."""
import gzip
import os
import re
import shutil
import subprocess
import sys
import tempfile

SKIPPED = 77
FILES = ["bin/warpscope", "share/applications/warpscope.desktop", "share/icons/hicolor/scalable/apps/warpscope.svg", "share/man/man1/warpscope.1.gz",
         "share/doc/warpscope/copyright", "share/doc/warpscope/README.md", "share/doc/warpscope/app/README.md", "share/doc/warpscope/assets/pictures/window.png", "share/doc/warpscope/changelog.gz",
         "share/doc/warpscope/examples/scenes/shells.json"]
MPI_LIBRARY = "lib/warpscope/warpscope_mpi.so"  # where the program looks for it
# Opened by name while the program runs: no tool can find them in it.
LOADED = ["libgl1-mesa-dri", "libosmesa6", "libxcursor1", "libxi6", "libxrandr2"]


def run(*command, **more):
    result = subprocess.run(command, capture_output=True, text=True, timeout=300, **more)
    assert result.returncode == 0, f"{' '.join(command)} ended with {result.returncode}: {result.stdout[-2000:]}{result.stderr[-2000:]}"
    return result.stdout


def names_of(help_text, heading):
    """What stands first in each line below the heading."""
    lines = help_text.split(f"\n{heading}:\n", 1)[1].splitlines()
    block = lines[:lines.index("")] if "" in lines else lines
    return [line.split()[0] for line in block if re.match(r" {2}\S", line)]


def check_installation(prefix, version):
    for file in FILES:
        assert os.path.getsize(os.path.join(prefix, file)) > 0, f"{file} is empty"
    program = os.path.join(prefix, "bin/warpscope")
    # Nothing of the machine's settings: what is found, is found by what was installed.
    said = run(program, "--version", cwd="/", env={"PATH": "/usr/bin:/bin"})
    assert said.strip() == version, f"--version says {said.strip()!r}, not {version}"
    dynamic = run("readelf", "--dynamic", program)
    paths = re.findall(r"Library r(?:un)?path: \[(.*)\]", dynamic)
    assert all(path.startswith("$ORIGIN/") for path in paths), f"the program looks for libraries in {paths}"
    return program


def check_man_page(prefix, program, version):
    path = os.path.join(prefix, "share/man/man1/warpscope.1.gz")
    with gzip.open(path, "rt", encoding="utf-8") as file:
        page = file.read()
    assert f'"warpscope {version}"' in page.splitlines()[0], page.splitlines()[0]
    text = page.replace("\\-", "-")
    commands = names_of(run(program, "--help"), "Subcommands")
    assert len(commands) >= 8, commands
    options = 0
    for command in commands:
        assert f".SH WARPSCOPE {command.upper()}\n" in text, f"the man page leaves {command} out"
        section = text.split(f".SH WARPSCOPE {command.upper()}\n", 1)[1].split("\n.SH ", 1)[0]
        for option in re.findall(r"^ {2}(-\S+)", run(program, command, "--help"), re.M):
            # Help writes --name=default.
            assert re.search(rf"^\\fB{re.escape(option)}[\\ ]", section, re.M), f"the man page's {command} leaves {option} out"
            options += 1
    assert options > 50, options
    if shutil.which("man") and shutil.which("groff"):
        shown = subprocess.run(["man", "--warnings", "-E", "UTF-8", "-l", path], capture_output=True, text=True, timeout=60,
                               env=dict(os.environ, MANWIDTH="100", MAN_KEEP_FORMATTING="", LC_ALL="C.UTF-8"))
        assert shown.returncode == 0 and not shown.stderr.strip(), f"man complains: {shown.stderr}"


def check_desktop_file(prefix):
    path = os.path.join(prefix, "share/applications/warpscope.desktop")
    with open(path, encoding="utf-8") as file:
        entries = dict(line.strip().split("=", 1) for line in file if "=" in line)
    assert entries["Exec"].split()[0] == entries["TryExec"] == "warpscope", entries
    assert os.path.exists(os.path.join(prefix, f"share/icons/hicolor/scalable/apps/{entries['Icon']}.svg")), entries["Icon"]
    if shutil.which("desktop-file-validate"):
        assert not run("desktop-file-validate", path).strip()


def check_installed(cmake, build, folder, version):
    run(cmake, "--install", build, "--prefix", folder)
    program = check_installation(folder, version)
    hasMpi = os.path.exists(os.path.join(build, "warpscope_mpi.so"))
    assert os.path.exists(os.path.join(folder, MPI_LIBRARY)) == hasMpi, f"{MPI_LIBRARY} is{'' if not hasMpi else ' not'} installed"
    check_man_page(folder, program, version)
    check_desktop_file(folder)


def check_permissions(listed):
    assert not re.search(r"^.....w|^.{8}w", listed, re.M), f"others than root may write to files of the package:\n{listed}"


def check_packed(cmake, build, folder, version):
    for tool in ("dpkg-shlibdeps", "dpkg-deb", "file"):
        if not shutil.which(tool):
            print(f"Skipped: {tool} is not installed (Debian: dpkg-dev, file).")
            sys.exit(SKIPPED)
    run(os.path.join(os.path.dirname(cmake), "cpack"), "--config", os.path.join(build, "CPackConfig.cmake"), "-B", folder, cwd=folder)
    packages = [name for name in os.listdir(folder) if name.endswith(".deb")]
    own = [name for name in packages if name.startswith(f"warpscope_{version}_")]
    forMpi = [name for name in packages if name.startswith(f"warpscope-mpi_{version}_")]
    hasMpi = os.path.exists(os.path.join(build, "warpscope_mpi.so"))
    assert len(own) == 1 and len(forMpi) == hasMpi and len(packages) == 1 + hasMpi, packages
    package = os.path.join(folder, own[0])
    depends = run("dpkg-deb", "--field", package, "Depends")
    assert "mpi" not in depends, f"the package demands MPI: {depends}"
    for name in LOADED + ["libc6", "libegl1"]:
        assert re.search(rf"(^|, ){re.escape(name)}( |,|$)", depends), f"the package does not depend on {name}: {depends}"
    assert "cuda" not in depends and "nvidia" not in depends, f"the package demands NVIDIA's driver: {depends}"
    listed = run("dpkg-deb", "--contents", package)
    for file in FILES:
        assert f"./usr/{file}\n" in listed, f"the package leaves {file} out"
    assert MPI_LIBRARY not in listed, f"the package has what needs MPI:\n{listed}"
    check_permissions(listed)
    if hasMpi:
        package = os.path.join(folder, forMpi[0])
        depends = run("dpkg-deb", "--field", package, "Depends")
        for name in [f"warpscope (= {version})", "libopenmpi3", "openmpi-bin"]:
            assert re.search(rf"(^|, ){re.escape(name)}( |,|$)", depends), f"the package for MPI does not depend on {name}: {depends}"
        assert run("dpkg-deb", "--field", package, "Description") != run("dpkg-deb", "--field", os.path.join(folder, own[0]), "Description")
        listed = run("dpkg-deb", "--contents", package)
        files = re.findall(r"^-.* \./usr/(\S+)$", listed, re.M)
        assert sorted(files) == sorted([MPI_LIBRARY, "share/doc/warpscope-mpi/changelog.gz", "share/doc/warpscope-mpi/copyright"]), files
        check_permissions(listed)


def main():
    what, cmake, build, version = sys.argv[1:]
    with tempfile.TemporaryDirectory() as folder:
        {"installed": check_installed, "packed": check_packed}[what](cmake, build, folder, version)


main()
