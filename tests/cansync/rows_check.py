#!/usr/bin/env python3
"""Compares the table of rules and tests in a document with the tests there are.

  rows_check.py DOCUMENT TESTS [LAST]
                                 exit 1 and one line per difference: a test (`Suite.Name`, or the path of a script)
                                 named in the table that is not there under TESTS; a test that carries a rule in its name (S16..., K8...) and is not in the
                                 table beside that rule, when the table has rules of that letter; with LAST, a row H1..LAST that is
                                 missing, or of another letter: L60 for L1..L60. A row may have `declined:`, `open:` or `not yet:`
                                 and a reason in place of a test; those not met yet are counted
  rows_check.py --self-test      plants each difference in made-up texts and expects it to be found
"""
import pathlib
import re
import sys

ROW = re.compile(r"^\| ((?:[DFHJKLS]\d+)(?:, (?:[DFHJKLS]\d+))*) \|(.*)$", re.M)
NAMED = re.compile(r"`(\w+)\.(\w+)`")
SCRIPT = re.compile(r"`(tests/[\w./]+)`")
TEST = re.compile(r"\bTEST(?:_[FP])?\(\s*(\w+),\s*(\w+)\s*\)")
PYTHON_CLASS = re.compile(r"^class (\w+)\b")
PYTHON_TEST = re.compile(r"^    def (test_\w+)\b")
REASON = re.compile(r"\b(declined|open|not yet): \S.{15,}")
RULE = re.compile(r"^([SKL]\d+)[A-Z]\w*$")
NOT_YET = re.compile(r"^\| ((?:[DFHJKLS]\d+)(?:, (?:[DFHJKLS]\d+))*) \|.*\bnot yet: ", re.M)


def tests_of(source):
    """Pairs of suite and name, of googletest and of unittest."""
    found = set(TEST.findall(source))
    suite = None
    for line in source.splitlines():
        if match := PYTHON_CLASS.match(line):
            suite = match[1]
        elif (match := PYTHON_TEST.match(line)) and suite:
            found.add((suite, match[1]))
    return found


def tests_in(folder, kinds):
    """Pairs of suite and name of every test below `folder` in files of these kinds."""
    return {pair for kind in kinds for path in folder.rglob(kind) for pair in tests_of(path.read_text(encoding="utf-8"))}


def problems_of_row(rest, there, exists):
    """What is wrong with what stands beside a rule; `there`: pairs of suite and name of the tests there are."""
    tests, scripts = NAMED.findall(rest), SCRIPT.findall(rest)
    found = [f"there is no {script}" for script in scripts if not exists(script)]
    if not tests and not scripts and not REASON.search(rest):
        found.append("no test is named")
    return found + [f"there is no test {'.'.join(pair)}" for pair in tests if pair not in there]


def differences(document, there, exists=lambda path: False, last=0, letter="H"):
    beside = {}
    found = []
    for rules, rest in ROW.findall(document):
        tests = NAMED.findall(rest)
        found += [f"{rules}: {problem}" for problem in problems_of_row(rest, there, exists)]
        for rule in rules.split(", "):
            beside.setdefault(rule, set()).update(tests)
    found += [f"{letter}{row} has no row" for row in range(1, last + 1) if f"{letter}{row}" not in beside]
    kinds = {rule[0] for rule in beside}
    for suite, name in sorted(there):
        rule = RULE.match(name)
        if rule and rule[1][0] in kinds and (suite, name) not in beside.get(rule[1], ()):
            found.append(f"{suite}.{name} does not stand beside {rule[1]}")
    return found


def self_test():
    good = "| S1 | text | `A.S1Does` |\n| S2, S3 | text | `A.Other` |\n"
    source = "TEST(A, S1Does) {}\nTEST_F(A, Other) {}\n"
    assert differences(good, tests_of(source)) == []
    assert len(differences(good, tests_of("TEST(A, S1Does) {}"))) == 1
    assert len(differences(good, tests_of(source + "TEST_P(B, S3More) {}"))) == 1
    assert len(differences(good + "| S5 | text | `tests/a.py` |\n", tests_of(source))) == 1
    assert differences(good + "| S5 | text | `tests/a.py` |\n", tests_of(source), lambda path: True) == []
    assert len(differences(good + "| S4 | text | |\n", tests_of(source))) == 1
    python = "class A(B):\n    def test_one(self):\n"
    row = "| H1 | text | `A.test_one` |\n"
    assert differences(row, tests_of(python), last=1) == []
    assert len(differences(row, tests_of(python), last=2)) == 1
    assert len(differences(row, tests_of("class C:\n    def test_one(self):\n"), last=1)) == 1
    assert differences("| H1 | text | declined: nobody can want it |\n", set(), last=1) == []
    assert len(differences("| H1 | text | declined: no |\n", set(), last=1)) == 1
    row = "| L1 | text | not yet: nobody has built it |\n"
    assert differences(row, set(), last=1, letter="L") == []
    assert len(differences(row, set(), last=2, letter="L")) == 1
    assert len(differences(row, tests_of("TEST(A, L2Does) {}"), letter="L")) == 1
    assert NOT_YET.findall(row) == ["L1"]
    print("each difference is found")


def main(arguments):
    if arguments == ["--self-test"]:
        return self_test()
    document, tests = map(pathlib.Path, arguments[:2])
    word = arguments[2] if len(arguments) > 2 else "0"
    letter, last = (word[0], int(word[1:])) if word[0].isalpha() else ("H", int(word))
    kinds = ("*_test.cpp", "*_test.py") if last else ("*_test.cpp",)
    text = document.read_text()
    found = differences(text, tests_in(tests, kinds), lambda script: (tests.parent / script).is_file(), last, letter)
    not_yet = len([row for rows in NOT_YET.findall(text) for row in rows.split(", ")])
    print("\n".join(found) or f"{len(ROW.findall(text))} rows agree with their tests, {not_yet} of them not met yet")
    return 1 if found else 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
