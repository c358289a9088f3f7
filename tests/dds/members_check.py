#!/usr/bin/env python3
"""The table of members that idl/members.py makes has every member of the status topics, and what is made of it is not old.

Usage: members_check.py ROOT
"""
import importlib.util
import os
import re
import subprocess
import sys
import unittest

ROOT = os.path.abspath(sys.argv.pop(1))
SCRIPT = os.path.join(ROOT, "idl", "members.py")
spec = importlib.util.spec_from_file_location("members", SCRIPT)
members = importlib.util.module_from_spec(spec)
sys.modules["members"] = members
spec.loader.exec_module(members)


def text_of(*path):
    with open(os.path.join(ROOT, *path), encoding="utf-8") as file:
        return file.read()


def names_in(idl, struct):
    """The names before each ';' of a struct, found in another way than by the script."""
    body = re.search(rf"struct {struct} {{(.*?)\n}};", text_of("idl", idl), re.DOTALL)[1]
    return re.findall(r"(\w+)(?:\[\d+\])?;", re.sub(r"//.*", "", body))


def tables():
    """(IDL file, struct) of every table: those that idl/CMakeLists.txt asks for."""
    for name, structs in re.findall(r"set\(MEMBERS_(\w+) ([^)]*)\)", text_of("idl", "CMakeLists.txt")):
        for struct in structs.split():
            yield f"{name}.idl", struct


class Members(unittest.TestCase):
    def test_every_member_is_in_its_table_with_a_text(self):
        self.assertGreaterEqual(len(list(tables())), 7)
        for idl, struct in tables():
            known = members.structs(os.path.join(ROOT, "idl", idl))
            header = members.header(os.path.join(ROOT, "idl", idl), [struct])
            for one in members.with_nested(known, [struct]):
                self.assertEqual([member.name for member in known[one]], names_in(idl, one), one)
                for member in known[one]:
                    self.assertIn(f'{{"{member.name}", ', header, one)
                    self.assertGreater(len(member.text), 3, f"{one}.{member.name} has no text behind it in idl/{idl}")

    def test_a_topic_of_state_has_a_table(self):
        topics = {struct for idl in os.listdir(os.path.join(ROOT, "idl")) if idl.endswith(".idl")
                  for struct in re.findall(r"struct (\w+Status) {", text_of("idl", idl))}
        self.assertEqual(topics - {struct for _, struct in tables()}, set())

    def test_no_two_members_of_a_status_have_one_key(self):
        for title, kind in members.kind_schemas():
            self.assertEqual(len(kind["required"]), len(set(kind["required"])), title)
            own = dict(members.PROTOCOLS.values())
            every = [name for topic in members.COMMON for name in names_in("gateway.idl", topic)]
            protocol = title.rsplit(" ", 1)[1]
            every += names_in(*members.PROTOCOLS[protocol])
            # The start of the daemon is told by the protocol's own status, too.
            self.assertEqual(len(kind["required"]), len(every) - (every.count("daemon") - 1), own)

    def test_what_is_made_of_it_is_not_old(self):
        for option, path in (("--schema", ("docs", "json", "status.schema.json")), ("--document", ("docs", "status-topics.md"))):
            made = subprocess.run([sys.executable, "-B", SCRIPT, option], capture_output=True, text=True, check=True).stdout
            self.assertEqual(made, text_of(*path), f"python3 idl/members.py {option} > {'/'.join(path)}")


if __name__ == "__main__":
    unittest.main(argv=[sys.argv[0], "-v"])
