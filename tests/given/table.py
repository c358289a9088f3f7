#!/usr/bin/env python3
"""The table of what may be given to a daemon and what may happen to it (table.toml).

  table.py --header FILE   the cells for given_test.cpp
  table.py --document      docs/what-is-given.md
  table.py --check FILE    that document is made of the table as it is; exit code 1: it is not
A row without a cell for each column, or with one that there is no column for, is an error: exit code 1.
"""
import contextlib
import io
import pathlib
import sys
import textwrap
import tomllib

HERE = pathlib.Path(__file__).parent


def read():
    table = tomllib.loads((HERE / "table.toml").read_text(encoding="utf-8"))
    wrong = []
    for name, row in table["row"].items():
        cells = row["cell"]
        for column in table["column"]:
            if column not in cells:
                wrong.append(f"row {name}: no cell for column {column}")
        for column, cell in cells.items():
            if column not in table["column"]:
                wrong.append(f"row {name}: cell {column}: there is no such column")
            elif set(cell) not in ({"bus", "giver", "others"}, {"bus", "giver", "others", "why"}, {"none"}):
                wrong.append(f"row {name}: cell {column}: has {sorted(cell)}; wanted: bus, giver, others, or none")
    if wrong:
        sys.exit("\n".join(f"table.toml: {line}" for line in wrong))
    return table


def quoted(text):
    return '"' + text.replace("\\", "\\\\").replace('"', '\\"') + '"'


def header(table):
    print("// Made by table.py of table.toml.\n#pragma once\n\n#include <string_view>\n\nnamespace given {\n")
    print("struct Cell {\n  std::string_view row;\n  std::string_view column;\n  std::string_view bus;  ///< empty: it "
          "cannot happen\n  std::string_view giver;\n  std::string_view others;\n};\n")
    print("inline constexpr Cell kCells[] = {")
    for name, row in table["row"].items():
        for column in table["column"]:
            cell = row["cell"][column]
            texts = [name, column] + [cell.get(what, "") for what in ("bus", "giver", "others")]
            print("    {" + ", ".join(quoted(text) for text in texts) + "},")
    print("};\n\n}  // namespace given")


def document(table):
    tested = sum("none" not in row["cell"][column] for row in table["row"].values() for column in table["column"])
    wrap = lambda text: print(textwrap.fill(text, 120), end="\n\n")
    print("# What is given, and when it ends\n")
    print("<!-- Made by tests/given/table.py of tests/given/table.toml. -->\n")
    for paragraph in table["text"].strip().split("\n\n"):
        wrap(" ".join(paragraph.split()).replace("TESTED", str(tested)))
    print("| happening | what it is |\n|---|---|")
    for column in table["column"].values():
        print(f"| {column['title']} | {column['what']} |")
    protocol = None
    for name, row in table["row"].items():
        if row["protocol"] != protocol:
            protocol = row["protocol"]
            print(f"\n## {protocol}")
        print(f"\n### {row['title']}\n")
        wrap(" ".join(row["what"].split()))
        print("| happening | on the bus | to the giver | to all, as events |\n|---|---|---|---|")
        for column, about in table["column"].items():
            cell = row["cell"][column]
            if "none" in cell:
                print(f"| {about['title']} | cannot happen: {cell['none']} | | |")
            else:
                why = f" ({cell['why']})" if "why" in cell else ""
                others = cell["others"] if cell["others"] == "nothing" else \
                    ", ".join(f"`{code}`" for code in cell["others"].split(", "))
                print(f"| {about['title']} | {cell['bus']}{why} | {cell['giver']} | {others} |")


def text_of(make, table):
    out = io.StringIO()
    with contextlib.redirect_stdout(out):
        make(table)
    return out.getvalue()


def main(action, *file):
    table = read()
    if action == "--header":
        pathlib.Path(*file).write_text(text_of(header, table), encoding="utf-8")
    elif action == "--document":
        document(table)
    elif action == "--check" and pathlib.Path(*file).read_text(encoding="utf-8") != text_of(document, table):
        sys.exit(f"{file[0]} is not what the table says; make it: tests/given/table.py --document > {file[0]}")


if __name__ == "__main__":
    main(*sys.argv[1:])
