#!/usr/bin/env python3
"""Compares the table of rules and tests in a document with the tests there are.

  rows_check.py DOCUMENT TESTS   exit 1 and one line per difference: a test (`Suite.Name`, or the path of a script)
                                 named in the table that is not there under TESTS; a test that carries a rule in its name (S16..., K8...) and is not in the
                                 table beside that rule, when the table has rules of that letter
  rows_check.py --self-test      plants each difference in made-up texts and expects it to be found
"""
import pathlib
import re
import sys

ROW = re.compile(r"^\| ((?:[DFKS]\d+)(?:, (?:[DFKS]\d+))*) \|(.*)$", re.M)
NAMED = re.compile(r"`(\w+)\.(\w+)`")
SCRIPT = re.compile(r"`(tests/[\w./]+)`")
TEST = re.compile(r"\bTEST(?:_[FP])?\(\s*(\w+),\s*(\w+)\s*\)")
RULE = re.compile(r"^([SK]\d+)[A-Z]\w*$")


def differences(document, sources, exists=lambda path: False):
    there = {pair for source in sources for pair in TEST.findall(source)}
    beside = {}
    found = []
    for rules, rest in ROW.findall(document):
        tests = NAMED.findall(rest)
        scripts = SCRIPT.findall(rest)
        found += [f"{rules}: there is no {script}" for script in scripts if not exists(script)]
        if not tests and not scripts:
            found.append(f"{rules}: no test is named")
        for pair in tests:
            if pair not in there:
                found.append(f"{rules}: there is no test {'.'.join(pair)}")
        for rule in rules.split(", "):
            beside.setdefault(rule, set()).update(tests)
    kinds = {rule[0] for rule in beside}
    for suite, name in sorted(there):
        rule = RULE.match(name)
        if rule and rule[1][0] in kinds and (suite, name) not in beside.get(rule[1], ()):
            found.append(f"{suite}.{name} does not stand beside {rule[1]}")
    return found


def self_test():
    good = "| S1 | text | `A.S1Does` |\n| S2, S3 | text | `A.Other` |\n"
    source = "TEST(A, S1Does) {}\nTEST_F(A, Other) {}\n"
    assert differences(good, [source]) == []
    assert len(differences(good, ["TEST(A, S1Does) {}"])) == 1
    assert len(differences(good, [source + "TEST_P(B, S3More) {}"])) == 1
    assert len(differences(good + "| S5 | text | `tests/a.py` |\n", [source])) == 1
    assert differences(good + "| S5 | text | `tests/a.py` |\n", [source], lambda path: True) == []
    assert len(differences(good + "| S4 | text | |\n", [source])) == 1
    print("each difference is found")


def main(arguments):
    if arguments == ["--self-test"]:
        return self_test()
    document, tests = map(pathlib.Path, arguments)
    sources = [path.read_text() for path in sorted(tests.rglob("*_test.cpp"))]
    text = document.read_text()
    found = differences(text, sources, lambda script: (tests.parent / script).is_file())
    print("\n".join(found) or f"{len(ROW.findall(text))} rows agree with their tests")
    return 1 if found else 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
