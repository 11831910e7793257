"""Writes warpscope(1), gzipped, from what the program's own --help says of itself and of every command, so that the two cannot differ.
Usage: man_page.py PROGRAM VERSION OUTPUT. Macros: groff's man(7)."""
import gzip
import os
import re
import subprocess
import sys

COLUMN = 30  # where --help begins to explain; farther to the right than any entry begins

# What --help does not say.
EXIT_STATUS = [("0", "Success."), ("1", "Failure: one line on standard error says why."), ("2", "The command line was not understood.")]
ENVIRONMENT = [
    ("DISPLAY, WAYLAND_DISPLAY", "Where the window opens. Without a display, warpscope without a command writes the comparison of the default scene to ./out."),
    ("XDG_DATA_HOME", "The certificate that serve makes on first use is kept in the folder warpscope in there; without the variable, in "
     "~/.local/share/warpscope. The folder and what is in it belong to the user and are closed to others."),
    ("WARPSCOPE_URL", "The URL of a server that view, shot and compare take frames from where neither --connect, --url-file nor a scene is given."),
]
EXAMPLES = [
    ("warpscope view shells", "Opens a built-in scene in the window."),
    ("warpscope compare shells --out out", "Writes every technique in every view, a montage and metrics.json."),
    ("warpscope shot head_256x256x128_uint8.raw --technique spheres --view-angle 15 -o head.png", "Writes one picture of a volume file."),
    ("warpscope serve shells --listen 0.0.0.0:4711", "Serves a scene; the URL that it prints is what view, shot and compare take as --connect."),
]


def help_of(program, *command):
    result = subprocess.run([program, *command, "--help"], capture_output=True, text=True, timeout=60,
                            env=dict(os.environ, LC_ALL="C.UTF-8"))
    if result.returncode != 0 or not result.stdout.strip():
        sys.exit(f"man_page.py: `warpscope {' '.join(command)} --help` ended with {result.returncode} and said: {result.stderr.strip() or 'nothing'}")
    return result.stdout


def parse(text):
    """(description, usage, {heading: [(entry, explanation)]})"""
    lines = text.rstrip().splitlines()
    usages = [i for i, line in enumerate(lines) if line.startswith("Usage: ")]
    if len(usages) != 1:
        sys.exit(f"man_page.py: expected one line 'Usage: ' in a help, found {len(usages)}:\n{text}")
    sections, entries = {}, None
    for line in lines[usages[0] + 1:]:
        if not line.strip():
            continue
        if not line.startswith(" "):
            entries = sections.setdefault(line.strip().rstrip(":"), [])
        elif entries is None:
            sys.exit(f"man_page.py: '{line.strip()}' stands under no heading")
        elif len(line) - len(line.lstrip()) < COLUMN:
            # An entry that reaches into the explanations' column has its own on the next line.
            entry, _, explanation = re.sub(r" {2,}", "\0", line.strip(), count=1).partition("\0")
            entries.append([entry, explanation])
        elif entries:
            entries[-1][1] = f"{entries[-1][1]} {line.strip()}".strip()
    return " ".join(line.strip() for line in lines[:usages[0]]).strip(), lines[usages[0]][len("Usage: "):], sections


def plain(text):
    """Text that troff takes for nothing but text; hyphens stay what a user can copy."""
    text = text.replace("\\", "\\e").replace("-", "\\-")
    return "\\&" + text if text[:1] in (".", "'") else text


def entries_of(pairs):
    return [line for entry, explanation in pairs for line in (".TP", f"\\fB{plain(entry)}\\fR", plain(explanation or "\\&"))]


def page(program, version):
    description, usage, sections = parse(help_of(program))
    commands = sections.pop("Subcommands", [])
    if not commands:
        sys.exit("man_page.py: the program's help lists no commands")
    title = "what image warping does to the pictures of a remote volume renderer"
    out = [f'.TH WARPSCOPE 1 "" "warpscope {version}" "User Commands"', ".SH NAME", f"warpscope \\- {plain(title)}", ".SH SYNOPSIS",
           f"\\fB{plain(usage.split()[0])}\\fR {plain(usage.partition(' ')[2])}", ".SH DESCRIPTION", plain(description)]
    for heading, entries in sections.items():
        out += [f".SH {heading.upper()}", *entries_of(entries)]
    out += [".SH COMMANDS", "Without a command, warpscope opens the window, as view does.", *entries_of(commands)]
    for name, explanation in commands:
        _, usage, sections = parse(help_of(program, name))
        out += [f".SH WARPSCOPE {name.upper()}", plain(explanation) + ".", ".PP", f"\\fB{plain(usage)}\\fR"]
        for heading, entries in sections.items():
            out += [f".SS {heading}", *entries_of(entries)]
    out += [".SH EXIT STATUS", *entries_of(EXIT_STATUS), ".SH ENVIRONMENT", *entries_of(ENVIRONMENT), ".SH EXAMPLES", *entries_of(EXAMPLES)]
    return "\n".join(out) + "\n"


def main():
    if len(sys.argv) != 4:
        sys.exit(__doc__)
    program, version, output = sys.argv[1:]
    content = page(program, version).encode()
    with open(output, "wb") as file:
        file.write(gzip.compress(content, 9, mtime=0))


main()
