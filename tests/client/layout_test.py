#!/usr/bin/env python3
"""Programs that are built against the library hold its structs: size, members and offsets stay while the soname does.

Usage: layout_test.py BUILD [--write]. Compares every public struct and class of the headers, and those of the data
model that they give by value, with layouts.txt. What may grow is given by pointer or with its size, or the soname
(SOVERSION of lib/client/shared.cmake) is raised; then --write takes the new layouts. Without that it takes new structs
alone. Exit code: 0 the same; 1 not, with what differs; 2 the headers cannot be read.
"""

import pathlib
import re
import subprocess
import sys
import tempfile

HERE = pathlib.Path(__file__).resolve().parent
SOURCES = HERE.parent.parent
HEADERS = SOURCES / "lib/client/include"
KEPT = HERE / "layouts.txt"
DATA_MODEL = ("cansync.h", "gateway.h")

Layouts = dict[str, list[str]]


def soname() -> str:
    """libcansync.so.1."""
    found = re.search(r"SOVERSION (\d+)", (SOURCES / "lib/client/shared.cmake").read_text())
    assert found, "lib/client/shared.cmake has no SOVERSION"
    return f"libcansync.so.{found[1]}"


def names_in(header: pathlib.Path) -> list[str]:
    """The structs and classes that it defines at the outermost level, with their namespaces."""
    # A namespace of one line, for a declaration alone, is closed without a comment.
    text = re.sub(r"^namespace [\w:]+ \{\n.*\n\}\n", "", header.read_text(), flags=re.MULTILINE)
    text = re.sub(r"^template .*\n.*\n", "", text, flags=re.MULTILINE)
    spaces: list[str] = []
    names = []
    for line in text.splitlines():
        if space := re.match(r"namespace ([\w:]+) \{$", line):
            spaces.append(space[1])
        elif line.startswith("}  // namespace"):
            spaces.pop()
        elif found := re.match(r"(?:typedef )?(?:struct|class) (?:CANSYNC_\w+ )?(\w+)(?: final)?(?: :[^;{]*)?\s*\{?$", line):
            names.append("::".join([*spaces, found[1]]))
    return names


def layouts(build: pathlib.Path) -> Layouts:
    """Of each struct its size and members, one a line, as the compiler lays them out."""
    headers = sorted(HEADERS.rglob("*.h"))
    model = [build / "idl" / name for name in DATA_MODEL]
    # Sequences of the data model are guarded, and may be declared twice.
    names = sorted({name for header in headers + model for name in names_in(header)})
    text = "".join(f"#include <{header.relative_to(HEADERS)}>\n" for header in headers)
    text += "".join(f"constexpr auto size_{i} = sizeof({name});\n" for i, name in enumerate(names))
    with tempfile.NamedTemporaryFile("w", suffix=".cpp") as source:
        source.write(text)
        source.flush()
        made = subprocess.run(["clang++", "-std=c++20", f"-I{HEADERS}", f"-I{build / 'idl'}", "-fsyntax-only", "-Xclang",
                               "-fdump-record-layouts", source.name], capture_output=True, text=True, check=False)
    if made.returncode != 0:
        print(made.stderr, file=sys.stderr)
        sys.exit(2)
    found: Layouts = {}
    for block in made.stdout.split("*** Dumping AST Record Layout\n")[1:]:
        lines = block.splitlines()
        name = re.sub(r"^ *0 \| (?:struct|class|union) ", "", lines[0]).removesuffix(" (empty)")
        if name not in names:
            continue
        members = [match for line in lines[1:] if (match := re.match(r" *([\d:-]+) \|   (\S.*)$", line))]
        size = re.search(r"sizeof=(\d+)", block)
        assert size
        found[name] = [f"size {size[1]}"] + [f"{match[1]} {match[2]}" for match in members]
    missing = set(names) - set(found)
    assert not missing, f"the compiler gives no layout of {sorted(missing)}"
    return found


def kept() -> tuple[str, Layouts]:
    """The soname that layouts.txt is of, and what it says."""
    if not KEPT.exists():
        return "", {}
    lines = KEPT.read_text().splitlines()
    of: Layouts = {}
    name = ""
    for line in lines[1:]:
        if line.startswith("  "):
            of[name].append(line.strip())
        else:
            name = line
            of[name] = []
    return lines[0], of


def difference(before: list[str], after: list[str]) -> str:
    """The lines that are there on one side alone."""
    return "".join(f"    was {line}\n" for line in before if line not in after) + "".join(
        f"    is  {line}\n" for line in after if line not in before)


def main() -> int:
    """Compares, or writes."""
    now = layouts(pathlib.Path(sys.argv[1]))
    of, before = kept()
    changed = [name for name in before if now.get(name) != before[name]]
    new = [name for name in now if name not in before]
    if of == soname() and changed:
        for name in changed:
            print(f"{name}:\n{difference(before[name], now.get(name, []))}", end="")
        print(f"a program built with {of} would read these wrongly: give what grows by pointer or with its size, or raise "
              "SOVERSION in lib/client/shared.cmake and call this with --write")
        return 1
    if "--write" in sys.argv[2:]:
        KEPT.write_text(soname() + "\n" + "".join(f"{name}\n" + "".join(f"  {line}\n" for line in now[name])
                                                  for name in sorted(now)))
        return 0
    if of != soname() or new:
        print(f"{KEPT.name} is of {of}, the library {soname()}; new: {', '.join(new) or 'none'}; call this with --write")
        return 1
    return 0


if __name__ == "__main__":
    sys.exit(main())
