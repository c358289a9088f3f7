#!/usr/bin/env python3
"""Checks the data model: every numeric member has @unit, every struct and enum is @appendable.

Usage: idl_units_check.py FILE.idl | idl_units_check.py --self-test FILE.idl
The self-test plants one violation of each kind in a copy of the text and fails if one is not found.
"""
import re
import sys

NUMBER = re.compile(r"\b(octet|char|short|long|float|double|u?int(?:8|16|32|64)(?:_t)?)\b")
MEMBER = re.compile(r"^\s*(?P<annotations>(?:@\w+(?:\([^)]*\))?\s*)*)(?P<type>[^@;]+?)\s+(?P<name>\w+)(?:\[\w+\])*\s*;")
UNIT = re.compile(r'@unit\("[^"]+"\)')


def problems(text):
    """One line of text for each violation."""
    found = []
    lines = [line.split("//")[0].rstrip() for line in text.splitlines()]
    inside = False
    for number, line in enumerate(lines, 1):
        kind = re.match(r"^(struct|enum)\s+(\w+)", line)
        if kind:
            before = next((lines[i] for i in range(number - 2, -1, -1) if lines[i].strip()), "")
            if "@appendable" not in before:
                found.append(f"line {number}: {kind.group(1)} {kind.group(2)} is not @appendable")
            inside = kind.group(1) == "struct"
            continue
        if line.startswith("}"):
            inside = False
        if not inside or not line.strip():
            continue
        member = MEMBER.match(line)
        if not member:
            found.append(f"line {number}: not understood: {line.strip()}")
            continue
        # Bytes of a sequence are data, not a quantity.
        plain = re.sub(r"sequence<[^>]*>", "", member.group("type"))
        if NUMBER.search(plain) and not UNIT.search(member.group("annotations")):
            found.append(f'line {number}: {member.group("name")} is a number without @unit; use @unit("1") for a plain one')
    return found


def self_test(text):
    """Every number's unit and every @appendable in turn is taken away; each must be found."""
    planted = 0
    for match in list(re.finditer(r'@unit\("[^"]+"\) ', text)) + list(re.finditer(r"@appendable", text)):
        if "//" in text[text.rfind("\n", 0, match.start()) : match.start()]:
            continue
        planted += 1
        if not problems(text[: match.start()] + text[match.end() :]):
            line = text.count("\n", 0, match.start()) + 1
            return [f"violation planted in line {line} ({match.group(0).strip()}) was not found"]
    return [] if planted >= 10 else [f"only {planted} violations could be planted"]


def main():
    test = sys.argv[1] == "--self-test"
    path = sys.argv[2 if test else 1]
    with open(path, encoding="utf-8") as file:
        text = file.read()
    found = self_test(text) if test else problems(text)
    for problem in found:
        print(f"{path}: {problem}", file=sys.stderr)
    return 1 if found else 0


if __name__ == "__main__":
    sys.exit(main())
