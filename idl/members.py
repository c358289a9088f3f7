#!/usr/bin/env python3
"""What the data model says of the members of its structs, for programs and documents.

  members.py --header FILE.idl STRUCT...   a C++ header with a table (text/members.h) of each struct and those in it
  members.py --schema                      docs/json/status.schema.json
  members.py --document                    docs/status-topics.md

Name, type and unit come from the IDL; the text is the comment behind the member and on the lines below it.
"""
import json
import os
import re
import sys
from dataclasses import dataclass

MEMBER = re.compile(r'\s*(?P<notes>(?:@\w+(?:\("[^"]*"\))?\s*)*)(?P<type>[\w:<>, ]+?)\s+(?P<name>\w+)(?:\[(?P<count>\d+)\])?;\s*(?://\s*(?P<text>.*))?$')
NUMBERS = {"octet": "octet", "unsigned short": "unsigned_short", "long": "signed_long", "unsigned long": "unsigned_long",
           "long long": "signed_long_long", "unsigned long long": "unsigned_long_long", "double": "real"}


@dataclass
class Member:
    """A member of a struct; `count` None: no array."""
    name: str
    type: str
    unit: str
    count: int
    text: str


def structs(path):
    """{name: [Member]} of one file, in its order; structs with a member of another kind (a sequence) are left out."""
    found, members = {}, None
    with open(path, encoding="utf-8") as file:
        lines = file.read().splitlines()
    for line in lines:
        if start := re.fullmatch(r"struct (\w+) \{", line):
            members = found.setdefault(start[1], [])
        elif line.startswith("}"):
            members = None
        elif members is not None and (more := re.fullmatch(r"\s*//\s*(.*)", line)) and members:
            members[-1].text += " " + more[1]
        elif members is not None and (member := MEMBER.match(line)):
            unit = re.search(r'@unit\("([^"]*)"\)', member["notes"])
            members.append(Member(member["name"], member["type"].strip(), unit[1] if unit else "",
                                  member["count"] and int(member["count"]), member["text"] or ""))
    return found


def with_nested(known, names):
    """The structs and, before each, those in it."""
    order = []

    def add(name):
        for member in known[name]:
            if member.type in known:
                add(member.type)
        if name not in order:
            order.append(name)

    for name in names:
        add(name)
    return order


def quoted(text):
    return '"' + text.replace("\\", "\\\\").replace('"', '\\"') + '"'


def table(module, known, name):
    """The C++ table of one struct."""
    c_name = f"{module}_{name}"
    lines = []
    for member in known[name]:
        kind, parts = member.type, "{}"
        if kind in known:
            kind, parts = "structure", f"members_of<{module}_{kind}>"
        elif kind.startswith("string<"):
            kind = "text"
        else:
            kind = NUMBERS.get(kind, "unsigned_long" if kind[0].isupper() else kind)  # an enumeration is its number
        of = f"{c_name}::{member.name}"
        count = member.count or 1
        if kind == "octet" and count == 16:
            kind, count = "identity", 1
        lines.append(f"    {{{quoted(member.name)}, {quoted(member.unit)}, MemberType::{kind}, offsetof({c_name}, {member.name}), "
                     f"sizeof({of}) / {count}, {member.count if count > 1 else 0}, {parts},\n     {quoted(member.text)}}},")
    return (f"inline constexpr Member k{module.capitalize()}{name}[] = {{\n" + "\n".join(lines) + "\n};\n"
            f"template <>\ninline constexpr std::span<const Member> members_of<{c_name}> = k{module.capitalize()}{name};\n")


def header(path, names):
    module = os.path.basename(path).removesuffix(".idl")
    known = structs(path)
    return (f'// Made by idl/members.py of {module}.idl.\n#pragma once\n\n#include <cstddef>\n#include <span>\n\n#include "{module}.h"\n'
            f'#include "text/members.h"\n\nnamespace text {{\n\n' + "\n".join(table(module, known, name) for name in with_nested(known, names))
            + "\n}  // namespace text\n")


# --- what `cansync status --json` writes

HERE = os.path.dirname(os.path.abspath(__file__))
COMMON = ("GatewayStatus", "BusStatus", "RealtimeStatus")
PROTOCOLS = {"cansync-master": ("cansync.idl", "MasterStatus"), "cansync-slave": ("cansync_slave.idl", "SlaveSideStatus"),
             "layer2": ("layer2.idl", "FrameStatus"), "j1939": ("j1939.idl", "NodeStatus")}
UNSIGNED = {"octet": 2**8 - 1, "unsigned short": 2**16 - 1, "unsigned long": None, "unsigned long long": None}


def key(member):
    """As text::key_of makes it."""
    return f"{member.name}_{member.unit}" if member.unit in ("ns", "ms", "permille") else member.name


def described(member, schema):
    unit = "" if member.unit in ("", "1", "value_unit") else f" ({member.unit})"
    return {**schema, "description": member.text + unit}


def object_schema(members, known):
    properties = {key(member): described(member, member_schema(member, known)) for member in members}
    return {"type": "object", "properties": properties, "required": list(properties), "additionalProperties": False}


def member_schema(member, known):
    if member.type in known:
        one = object_schema(known[member.type], known)
    elif member.type == "octet" and member.count == 16:
        return {"type": "string", "pattern": "^[0-9a-f]{32}$"}
    elif member.type.startswith("string<"):
        one = {"type": "string"}
    elif member.type == "boolean":
        one = {"type": "boolean"}
    elif member.type == "double":
        one = {"type": "number"}
    else:
        one = {"type": "integer"}
        if member.type in UNSIGNED:
            one["minimum"] = 0
            if UNSIGNED[member.type]:
                one["maximum"] = UNSIGNED[member.type]
    return {"type": "array", "items": one, "minItems": member.count, "maxItems": member.count} if member.count else one


def schema():
    """One property a line, as the other schemas have it."""
    def text(thing):
        return json.dumps(thing, ensure_ascii=False)

    kinds = []
    for title, kind in kind_schemas():
        properties = ",\n".join(f"      {text(name)}: {text(one)}" for name, one in kind["properties"].items())
        kinds.append(f'    {{"title": {text(title)}, "type": "object",\n     "properties": {{\n{properties}}},\n'
                     f'     "required": {text(kind["required"])},\n     "additionalProperties": false}}')
    return ('{\n  "$schema": "https://json-schema.org/draft/2020-12/schema",\n  "title": "cansync status --json",\n'
            '  "description": "The daemon and its bus. One object a line. Made by idl/members.py.",\n'
            '  "oneOf": [\n' + ",\n".join(kinds) + "]\n}\n")


def kind_schemas():
    """[(title, schema)] for each protocol."""
    common = structs(os.path.join(HERE, "gateway.idl"))
    kinds = []
    for protocol, (file, own) in PROTOCOLS.items():
        known = structs(os.path.join(HERE, file))
        members = [member for name in COMMON for member in common[name]]
        there = {member.name for member in members}
        members += [member for member in known[own] if member.name not in there]
        kinds.append((f"with bus.protocol = {protocol}", object_schema(members, known)))
    return kinds


# --- the tables of the document

HEAD = """# The status topics, member by member

Made by `idl/members.py --document` of the data model; a test compares the two. What the topics are for says
[dds-api.md](dds-api.md#actual-values-and-state), of a slave [cansync-slave.md](cansync-slave.md), of general frames [layer2.md](layer2.md), of J1939 [j1939.md](j1939.md). `cansync status --json` writes the members of the first three and of
the protocol's own under the names of the column JSON, `cansync slaves --json` and `timing --json` choose and reckon ([command-line.md](command-line-json.md)).
Members that are metrics stand in [metrics.md](metrics.md). Unit `1`: a plain number or raw code.
"""
DOCUMENTED = (("gateway.idl", COMMON), ("cansync.idl", ("MasterStatus", "ReferenceRelease", "ValueName", "SlaveStatus", "Timing", "SlotTiming")),
              ("cansync_slave.idl", ("SlaveSideStatus",)), ("layer2.idl", ("CanFrame", "FrameStatus", "TimerStatus", "ObjectStatus")), ("j1939.idl", ("NodeStatus",)))


def document():
    text = HEAD
    for file, names in DOCUMENTED:
        known = structs(os.path.join(HERE, file))
        for name in names:
            text += f"\n## {name}\n\n| member | type | unit | JSON | what |\n|---|---|---|---|---|\n"
            for member in known[name]:
                kind = member.type + (f"[{member.count}]" if member.count else "")
                text += f"| `{member.name}` | {kind} | {member.unit} | `{key(member)}` | {member.text} |\n"
    return text


def main():
    if sys.argv[1:] == ["--schema"]:
        sys.stdout.write(schema())
    elif sys.argv[1:] == ["--document"]:
        sys.stdout.write(document())
    elif len(sys.argv) > 3 and sys.argv[1] == "--header":
        sys.stdout.write(header(sys.argv[2], sys.argv[3:]))
    else:
        sys.exit(__doc__)


if __name__ == "__main__":
    main()
