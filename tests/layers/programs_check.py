#!/usr/bin/env python3
"""Programs that tests start are among what tools/test builds before it runs them.

  programs_check.py ROOT BUILD [--self-test]

tools/test builds some folders of the preset `dev` and runs the tests of some labels; a test whose environment or command
names a program of another folder works wherever everything was built, and fails where it was not. Needs Ninja (77: another
generator). The self-test leaves the folder of the tests of whole processes out and expects their programs to be missed.
"""
import json
import os
import re
import subprocess
import sys

LABELS = re.compile("unsanitized|end_to_end|kernel")  # what tools/test runs of the preset `dev`


def targets(root):
    """What tools/test builds of the preset `dev` when it builds not everything."""
    with open(os.path.join(root, "tools/test"), encoding="utf-8") as file:
        return re.search(r"^ *build dev ((?!all$).*)$", file.read(), re.M)[1].split()


def built(build, wanted):
    """Paths below the build folder that come into being, or are looked at, when `wanted` is built."""
    graph = subprocess.run(["ninja", "-t", "graph", *wanted], cwd=build, check=True, capture_output=True, text=True).stdout
    return set(re.findall(r'label="([^"]*)"', graph))


def properties(test, name):
    return [value for each in test["properties"] if each["name"] == name for value in each["value"]]


def words(test):
    """Everything in the command and the environment of a test that may be a path."""
    for text in test.get("command", []) + [pair.split("=", 1)[1] for pair in properties(test, "ENVIRONMENT")]:
        yield from text.split(":")


def missing(tests, build, there):
    """Lines of what tests need and is not built; folders count as there with anything in them."""
    folders = {os.path.dirname(path) for path in there}
    found = []
    for test in tests:
        if not any(LABELS.search(label) for label in properties(test, "LABELS")):
            continue
        for word in words(test):
            path = os.path.relpath(os.path.normpath(word), build) if os.path.isabs(word) else ""
            if path.startswith("tests/boots/"):
                continue  # a list of tests that are looked at by themselves
            if path not in ("", ".") and not path.startswith("..") and path not in there and not any(
                    folder == path or folder.startswith(path + "/") for folder in folders):
                found.append(f"{test['name']}: {path}")
    return found


def main():
    root, build = sys.argv[1:3]
    if not os.path.exists(os.path.join(build, "build.ninja")):
        sys.exit(77)
    tests = json.loads(subprocess.run(["ctest", "--show-only=json-v1"], cwd=build, check=True, capture_output=True,
                                      text=True).stdout)["tests"]
    wanted = targets(root)
    if sys.argv[3:] == ["--self-test"]:
        without = [target for target in wanted if target != "tests/end_to_end/all"]
        found = missing(tests, build, built(build, without))
        ok = len(without) == len(wanted) - 1 and len(found) > 2
        sys.exit(0 if ok else f"without the tests of whole processes these are missed: {found}")
    found = missing(tests, build, built(build, wanted))
    if found:
        sys.exit("\n".join([*found, f"not among what tools/test builds ({' '.join(wanted)}): have one of these build it"]))
    print(f"what the tests start is built by {len(wanted)} targets")


if __name__ == "__main__":
    main()
