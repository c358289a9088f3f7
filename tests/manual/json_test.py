"""Every verb has a JSON schema that is one, its keys are those of docs/command-line-json.md, and it is run by a test of whole processes."""

import os
import re
import sys
import unittest

import jsonschema

from help_text import helps

TESTS = os.path.join(os.path.dirname(os.path.abspath(__file__)), "..")
sys.path.insert(0, os.path.join(TESTS, "end_to_end"))
from json_schemas import keys, kinds, problem, schemas

KEYS = os.path.join(TESTS, "..", "docs", "command-line-json.md")
# A verb that has nothing but verbs below it does nothing of its own.
VERBS = sorted(verb for verb, told in helps(os.environ["CANSYNC"]).items() if verb and (not told.verbs or told.arguments))


def documented_keys():
    """The keys of each verb's objects, from the table of docs/command-line-json.md: a list of lists for each verb."""
    found = {}
    with open(KEYS, encoding="utf-8") as file:
        table = file.read().split("| verb | objects | keys |\n")[1]
    for row in table.split("\n\n")[0].splitlines()[1:]:
        verbs, _, names = row.strip("|").split("|")
        names = names.replace("the same, as it was asked, then", " ".join(f"`{k}`" for k in found.get("map", [[]])[0]))
        for verb in re.findall("`([a-z0-9 ]+)`", verbs):
            found.setdefault(verb, []).append(re.findall("`([a-z_0-9]+)`", names))
    return found


def parts(schema, path="$"):
    """Every schema inside a schema, with where it is."""
    yield path, schema
    for name, one in schema.get("properties", {}).items():
        yield from parts(one, f"{path}.{name}")
    for number, one in enumerate(schema.get("oneOf", [])):
        yield from parts(one, f"{path}|{number}")
    if "items" in schema:
        yield from parts(schema["items"], path + "[]")


class Schemas(unittest.TestCase):
    def test_every_verb_has_one_and_no_other_has(self):
        self.assertGreater(len(VERBS), 20)
        self.assertEqual(sorted(schemas()), sorted(VERBS))

    def test_they_are_schemas(self):
        for verb, schema in schemas().items():
            jsonschema.Draft202012Validator.check_schema(schema)
            self.assertTrue(schema["title"].startswith(f"cansync {verb} --json"), schema["title"])

    def test_objects_are_closed_and_everything_is_described(self):
        for verb, schema in schemas().items():
            for path, part in parts(schema):
                where = f"{verb}: {path}"
                if part.get("type") == "object":
                    self.assertIs(part["additionalProperties"], False, where)
                    self.assertEqual(part["required"], list(part["properties"]), where)
                elif "oneOf" not in part and not path.endswith("[]"):
                    self.assertGreater(len(part["description"]), 3, where)
                    self.assertTrue({"type", "enum", "anyOf"} & set(part), where)

    def test_keys_are_those_of_the_documentation(self):
        told = documented_keys()
        self.assertEqual(sorted(told), sorted(VERBS))
        for verb in VERBS:
            self.assertEqual(told[verb], [keys(kind) for kind in kinds(verb)], verb)

    def test_wrong_objects_are_found(self):
        good = {"mode": "run", "force": True, "result": "done", "reason": "", "cause": None}
        self.assertIsNone(problem("mode", good))
        for wrong in ({**good, "result": "fine"}, {**good, "force": 1}, {**good, "more": 1}, {"mode": "run"},
                      dict(reversed(good.items()))):
            self.assertIsNotNone(problem("mode", wrong), wrong)


class EndToEnd(unittest.TestCase):
    def test_every_verb_is_run_by_a_test_of_whole_processes(self):
        text = ""
        folder = os.path.join(TESTS, "end_to_end")
        for name in os.listdir(folder):
            # The test of the help runs all verbs without looking at what they do.
            if name.endswith("_test.py") and name != "help_test.py":
                with open(os.path.join(folder, name), encoding="utf-8") as file:
                    text += file.read()
        ways = r"(?:run_verb|text|fails|json|one|run|start|expect|slaves|start_job\(\"\w+\",|Running\([\w.]+,)\(? ?"
        for verb in VERBS:
            words = verb.replace(" ", '", "')
            self.assertRegex(text, rf"\b{ways}\[?\"{words}\"", f"{verb} is run by no test in tests/end_to_end")


if __name__ == "__main__":
    unittest.main(argv=[sys.argv[0], "-v"])
