"""The schemas in docs/json, and objects of `cansync VERB --json` compared with them."""

import functools
import json
import os
import re

FOLDER = os.path.join(os.path.dirname(os.path.abspath(__file__)), "..", "..", "docs", "json")
END = ".schema.json"


@functools.cache
def schemas():
    """The schema of each verb; that of a verb of two words, "can dump", is can-dump.schema.json."""
    found = {}
    for folder, _, names in sorted(os.walk(FOLDER)):
        for name in sorted(names):
            if name.endswith(END):
                with open(os.path.join(folder, name), encoding="utf-8") as file:
                    found[name.removesuffix(END).replace("-", " ")] = json.load(file)
    return found


def kinds(verb):
    """The kinds of objects a verb writes, each a schema."""
    schema = schemas()[verb]
    return schema.get("oneOf", [schema])


def keys(kind):
    """The keys of a kind of object, in their order."""
    return list(kind["properties"])


@functools.cache
def _validator(verb, number):
    # Brought in late: programs that only start a daemon need it not.
    import jsonschema

    return jsonschema.Draft202012Validator(kinds(verb)[number])


def problem(verb, found):
    """What is wrong with an object of a verb; None when nothing is."""
    for number, kind in enumerate(kinds(verb)):
        if list(found) == keys(kind):
            wrong = next(_validator(verb, number).iter_errors(found), None)
            return wrong and f"{wrong.json_path}: {wrong.message}"
    return f"{list(found)} are not the keys of docs/json/{verb.replace(' ', '-')}{END}"


def verb_of(arguments):
    """The verb on a command line; None: none with objects."""
    words = list(map(str, arguments))
    firsts = {name.split()[0] for name in schemas()}
    verb = next((word for word in words if word in firsts), None)
    second = next((f"{verb} {word}" for word in words[words.index(verb) + 1:] if not word.startswith("-")), "") if verb else ""
    return second if second in schemas() else verb if verb in schemas() else None


def expect(arguments, found):
    """An object that `cansync` wrote with these arguments is as its schema says. A batch writes those of any verb."""
    verb = verb_of(arguments)
    verbs = [verb, *(other for other in schemas() if other != verb)] if verb == "batch" else [verb]
    problems = [problem(one, found) for one in verbs]
    if None not in problems:
        raise AssertionError(f"{arguments}: {problems[0]}\n{found}")


def expect_lines(arguments, out):
    """Whatever was written with --json is objects, one a line, as the schema says. `out`: bytes."""
    words = list(map(str, arguments))
    verb = verb_of(words)
    if verb is None or {"--help", "--complete"} & set(words) or not ("--json" in words or verb == "batch"):
        return
    for line in out.decode(errors="replace").splitlines():
        # A batch may have lines without --json.
        if verb != "batch" or "--json" in words or re.match(r"^\{.*\}$", line):
            expect(words, json.loads(line))
