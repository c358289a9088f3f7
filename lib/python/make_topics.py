"""Writes `cansync/topics.py`, a dataclass for each topic of the data model that a client can follow, out of the IDL.

    make_topics.py C_HEADER TOPICS_PY IDL...

Which topics there are, says `enum cansync_topic` of the C header; their members, units and comments are those of the IDL.
"""

import pathlib
import re
import sys

HEAD = '''"""What a daemon publishes, made of the data model (gateway.idl, cansync.idl).

Each class is one topic; docs/dds-api.md says who writes it when. ``dataclasses.asdict`` makes dictionaries of them.
"""

from __future__ import annotations

import dataclasses
import enum
import typing

from ._native import ffi as _ffi

_string = _ffi.string
_buffer = _ffi.buffer
'''
NUMBERS = {"boolean": "bool", "double": "float", "octet": "int"}
BRACES = re.compile(r"((?://[^\n]*\n)*)@appendable[^\n]*\n(struct|enum) (\w+) \{(.*?)\};", re.DOTALL)
MEMBER = re.compile(r"(?P<marks>(?:@\w+(?:\([^)]*\))? )*)(?P<type>\w[\w:<> ]*?) (?P<name>\w+)(?:\[(?P<many>\d+)\])?; *(?://(?P<note>[^\n]*(?:\n +//[^\n]*)*))?")


def words(comment):
    return " ".join(re.sub(r"\n\s*//", "\n", comment or "").replace("//", " ").split())


def camel(name):
    return "".join(word.capitalize() for word in name.split("_"))


class Model:
    """The structs and enumerations of the IDL files, by name: module, kind, comment, body."""

    def __init__(self, files):
        self.types = {}
        for file in files:
            text = file.read_text(encoding="utf-8")
            module = re.search(r"^module (\w+)", text, re.MULTILINE)[1]
            for comment, kind, name, body in BRACES.findall(text):
                self.types[name] = (module, kind, words(comment), body)

    def members(self, name):
        return [match.groupdict() for match in MEMBER.finditer(self.types[name][3])]

    def needed(self, name):
        """The struct with the types of its members, in the order of their use."""
        found = []
        if self.types[name][1] == "struct":
            for member in self.members(name):
                inner = member["type"].split("::")[-1]
                if inner in self.types:
                    found += [other for other in self.needed(inner) if other not in found]
        return [*found, name]

    def enumeration(self, name):
        _, _, comment, body = self.types[name]
        entries = re.findall(r"(\w+),?[ \t]*(?://([^\n]*(?:\n\s+//[^\n]*)*))?", re.sub(r"^\s*//[^\n]*\n", "", body, flags=re.MULTILINE))
        entries = [(entry, words(note)) for entry, note in entries]
        first = entries[0][0].split("_")[0] + "_"
        entries = [(entry.removeprefix(first), note) for entry, note in entries]
        lines = [f'\n\nclass {name}(enum.IntEnum):\n    """{comment or name}\n']
        lines += [f"    {entry}: {note}" for entry, note in entries if note]
        lines += ['    """\n'] + [f"    {entry} = {number}" for number, (entry, _) in enumerate(entries)]
        return "\n".join(lines) + "\n"

    def python_of(self, member):
        """(annotation, expression) of a member of the C struct `c`."""
        kind, many, place = member["type"], member["many"], f"c.{member['name']}"
        inner = kind.split("::")[-1]
        if kind.startswith("string"):
            return "str", f'_string({place}).decode("utf-8", "replace")'
        if kind == "octet" and many:
            return "bytes", f"bytes(_buffer({place}))"
        if inner in self.types:
            make = f"{inner}._of" if self.types[inner][1] == "struct" else inner
            if many:
                return f"tuple[{inner}, ...]", f"tuple([{make}(each) for each in {place}])"
            return inner, f"{make}({place})"
        plain = NUMBERS.get(kind, "int")
        return (f"tuple[{plain}, ...]", f"tuple({place})") if many else (plain, place)

    def structure(self, name):
        module, _, comment, _ = self.types[name]
        comment = re.sub(r'^Daemon -> clients\. Topic "\w+"; ', "", comment) or name
        members = self.members(name)
        lines = [f'\n\n@dataclasses.dataclass(slots=True)\nclass {name}:\n    """{comment[0].upper()}{comment[1:]}\n']
        for member in members:
            unit = re.search(r'@unit\("([^"]*)"\)', member["marks"])
            unit = f" [{unit[1]}]" if unit and unit[1] not in ("1", "value_unit") else ""
            note = words(member["note"])
            lines.append(f"    {member['name']}{unit}" + (f": {note}" if note else ""))
        lines.append('    """\n')
        lines += [f"    {member['name']}: {self.python_of(member)[0]}" for member in members]
        lines += ["\n    @classmethod\n    def _of(cls, c: typing.Any) -> typing.Self:", "        return cls("]
        lines += [f"            {self.python_of(member)[1]}," for member in members]
        lines.append("        )\n")
        lines.append(f'    _struct: typing.ClassVar[str] = "{module}_{name}"')
        return "\n".join(lines) + "\n"


def main():
    header, output, *files = map(pathlib.Path, sys.argv[1:])
    numbers = re.findall(r"CANSYNC_TOPIC_(\w+)\s*=\s*(\d+)", header.read_text(encoding="utf-8"))
    model = Model(files)
    parts, made = [HEAD], set()
    for name in (camel(topic) for topic, _ in numbers):
        for needed in model.needed(name):
            if needed not in made:
                made.add(needed)
                parts.append(model.enumeration(needed) if model.types[needed][1] == "enum" else model.structure(needed))
    parts.append("\n\n# Number of each topic in the C face.\nNUMBERS: dict[type, int] = {"
                 + ", ".join(f"{camel(topic)}: {number}" for topic, number in numbers) + "}\n")
    parts.append("\n__all__ = [" + ", ".join(f'"{name}"' for name in sorted(made)) + "]\n")
    pathlib.Path(output).write_text("".join(parts), encoding="utf-8")


main()
