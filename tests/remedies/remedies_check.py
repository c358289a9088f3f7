#!/usr/bin/env python3
"""Compares the list of remedies with the remedies in the sources and with the tests there are.

  remedies_check.py SOURCE_FOLDER [LIST]  exit 1 and one line per difference: a text with a remedy that has no row, a row
                                   whose text is nowhere (it was changed: carry the new remedy out), a row without a test or
                                   a reason, a test that is not there. LIST: tests/remedies/remedies.md
  remedies_check.py --rows SOURCE_FOLDER  prints the texts as rows, to begin new ones from
  remedies_check.py --self-test SOURCE_FOLDER  plants each difference and expects it to be found

Texts are the refusals with their causes (what is given with a `gateway_CAUSE_`, and the texts of the master's refusals),
the findings of `cansync doctor` that are not ok, and the entries of the journal catalog. Rules of rows and tests are those
of tests/cansync/rows_check.py.
"""
import pathlib
import re
import sys

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parent.parent / "cansync"))
import rows_check  # noqa: E402

LIST = "tests/remedies/remedies.md"
CATALOG = "systemd/cansyncd.catalog"
SECTIONS = ("refusals", "doctor", "catalog")
LITERAL = re.compile(r'"((?:[^"\\]|\\.)*)"')
CHARACTER = re.compile(r"'(?:\\.|[^'\\])'")
CLOSING = {"(": ")", "{": "}", "[": "]"}
# The master's refusals come as numbers; their texts are all the longer literals of these.
WORDS_OF_THE_MASTER = ("daemon/cansync/texts/refusal_text.cpp",)
MASTER_IN_PART = (("daemon/cansync/texts/bus_text.cpp", "reset_"), ("lib/cansync/dds/validate.cpp", "explain"))
DOCTOR = ("tools/cli/doctor", "tools/cli/j1939/status_part.cpp", "tools/cli/cansync_slave/status_part.cpp")
# Tables of the causes, without a text.
WITHOUT_TEXTS = ("lib/client/src/causes.cpp", "lib/dds/denial.cpp", "daemon/desk/rejections.h")
SHORTEST = 25


def uncommented(source):
    return re.sub(r'^\s*//.*$|\s//[^"\n]*$', "", source, flags=re.M)


def bracketed(source, begin):
    """What stands between the bracket at `begin` and its partner."""
    open_ones, at = [], begin
    while at < len(source):
        skipped = LITERAL.match(source, at) or CHARACTER.match(source, at)
        if skipped:
            at = skipped.end()
            continue
        if source[at] in CLOSING:
            open_ones.append(CLOSING[source[at]])
        elif open_ones and source[at] == open_ones[-1]:
            open_ones.pop()
            if not open_ones:
                return source[begin + 1:at]
        at += 1
    raise ValueError(f"a bracket does not close: {source[begin:begin + 60]}")


def arguments(inside):
    """Those between the commas of the outermost level."""
    found, depth, last, at = [], 0, 0, 0
    while at < len(inside):
        skipped = LITERAL.match(inside, at) or CHARACTER.match(inside, at)
        if skipped:
            at = skipped.end()
            continue
        depth += (inside[at] in "({[") - (inside[at] in ")}]")
        if inside[at] == "," and depth == 0:
            found.append(inside[last:at])
            last = at + 1
        at += 1
    return [one.strip() for one in [*found, inside[last:]]]


def joined(expression):
    """Literals beside each other as the compiler joins them."""
    return re.sub(r'"\s*\n\s*"', "", expression)


def words(expression):
    """The text of an expression: its literals, or itself where it has none."""
    literals = [one for one in LITERAL.findall(joined(expression)) if one.strip(" ,;")]
    text = " … ".join(one.replace('\\"', '"').strip() for one in literals)
    return text or re.sub(r"\s+", " ", expression)


def sources(root, *places):
    for place in places:
        path = root / place
        for file in [path] if path.is_file() else sorted(path.rglob("*.cpp")) + sorted(path.rglob("*.h")):
            yield file.relative_to(root).as_posix(), uncommented(file.read_text(encoding="utf-8"))


def refusals(root):
    found = []
    for path, source in sources(root, "lib", "daemon"):
        if path in WITHOUT_TEXTS:
            continue
        for match in re.finditer(r"[({]\s*(?:\w+, )?gateway_CAUSE_\w+,", source):
            parts = arguments(bracketed(source, match.start()))
            at = next(i for i, part in enumerate(parts) if part.startswith("gateway_CAUSE_"))
            cause = parts[at].removeprefix("gateway_CAUSE_").lower()
            if cause != "none" and len(parts) > at + 1:
                found.append(f"{cause}, {path}: {words(parts[at + 1])}")
    for path in WORDS_OF_THE_MASTER:
        found += long_literals(path, uncommented((root / path).read_text(encoding="utf-8")))
    for path, name in MASTER_IN_PART:
        source = uncommented((root / path).read_text(encoding="utf-8"))
        for match in re.finditer(rf"^std::string {name}\w*\([^{{;]*\) {{\n(.*?)^}}", source, re.S | re.M):
            found += long_literals(path, match[1])
    return found


def long_literals(path, source):
    literals = [one.strip(" ;").replace('\\"', '"') for one in LITERAL.findall(joined(source))]
    return [f"{path}: {one}" for one in literals if len(one) >= SHORTEST and not one.endswith(".h")]


def doctor(root):
    found = []
    for path, source in sources(root, *DOCTOR):
        if path.endswith(".h"):
            continue
        for match in re.finditer(r"\b(?:out|list)\.(warning|error|add_slave)\(|\bof\(Level::(error|warning)", source):
            parts = arguments(bracketed(source, source.index("(", match.start())))
            level = match[1] if match[1] in ("warning", "error") else re.search(r"\w+$", parts[0])[0]
            if level == "first":
                continue  # hands on what was found above
            parts = parts if match[1] in ("warning", "error") else (["slave"] if match[2] else []) + parts[1:]
            found.append(f"{level}: " + " / ".join(words(part) for part in parts))
    return found


def catalog(root):
    """Those that say more than that nothing is to be done."""
    found = []
    for entry in (root / CATALOG).read_text(encoding="utf-8").split("\n# ")[1:]:
        word = entry.split("\n", 1)[0]
        remedy = re.sub(r"\s+", " ", entry.split("\nRemedy: ", 1)[-1]).strip() if "\nRemedy: " in entry else ""
        if remedy and not re.match(r"None( is)? needed\.$", remedy):
            found.append(f"{word}: {remedy}")
    return found


def remedies(root):
    return {"refusals": refusals(root), "doctor": doctor(root), "catalog": catalog(root)}


def row_text(text):
    return text.replace("|", "\\|")


def rows_of(document):
    """Section, text and what stands beside it."""
    section = ""
    for line in document.splitlines():
        if line.startswith("## "):
            section = line[3:]
        match = re.match(r"^\| (.*\S) \| (.*) \|$", line)
        if match and section in SECTIONS and match[1] != "remedy":
            yield section, match[1], match[2]


def differences(document, there, tests, exists=lambda path: False):
    listed = {section: set() for section in SECTIONS}
    found = []
    for section, text, beside in rows_of(document):
        if text in listed[section]:
            found.append(f"{section}: two rows: {text}")
        listed[section].add(text)
        found += [f"{section}: {text}: {problem}" for problem in rows_check.problems_of_row(beside, tests, exists)]
    for section in SECTIONS:
        texts = {row_text(text) for text in there[section]}
        found += [f"{section}: no row: {text}" for text in sorted(texts - listed[section])]
        found += [f"{section}: no such text, carry the new one out: {text}" for text in sorted(listed[section] - texts)]
    return found


def self_test(root):
    there = remedies(root)
    if min(len(there[section]) for section in SECTIONS) < 50:
        return ["fewer texts than there are"]
    tests = {("A", "Helps")}
    document = "".join(f"## {section}\n" + "".join(f"| {row_text(text)} | `A.Helps` |\n" for text in dict.fromkeys(texts))
                       for section, texts in there.items())
    if differences(document, there, tests):
        return ["without a difference there are some: " + differences(document, there, tests)[0]]
    for line in document.splitlines():
        if line.startswith("| ") and not differences(document.replace(line + "\n", ""), there, tests):
            return ["a missing row is not found: " + line]
    for planted in ("| no text | `A.Helps` |\n", "| no text | not yet: there is no way to do it |\n"):
        if len(differences(document + planted, there, tests)) != 1:
            return ["a row without a text is not found"]
    if len(differences(document, there, set())) < len(document.splitlines()) - 10:
        return ["a test that is not there is not found"]
    return []


def main(options):
    if options[0] == "--self-test":
        found = self_test(pathlib.Path(options[1]))
        print("\n".join(found) or "each difference is found")
        return 1 if found else 0
    if options[0] == "--rows":
        for section, texts in remedies(pathlib.Path(options[1])).items():
            print(f"## {section}")
            for text in dict.fromkeys(texts):
                print(f"| {row_text(text)} | |")
        return 0
    root = pathlib.Path(options[0])
    document = pathlib.Path(options[1]).read_text(encoding="utf-8") if options[1:] else (root / LIST).read_text(encoding="utf-8")
    tests = rows_check.tests_in(root / "tests", ("*_test.cpp", "*_test.py"))
    found = differences(document, remedies(root), tests, lambda script: (root / script).is_file())
    rows = list(rows_of(document))
    count = {word: sum(word in beside for _, _, beside in rows) for word in ("declined: ", "not yet: ")}
    print("\n".join(found) or f"{len(rows)} remedies agree with the sources and their tests; "
          f"{count['declined: ']} cannot be carried out by a test, {count['not yet: ']} are not carried out yet")
    return 1 if found else 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
