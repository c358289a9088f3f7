#!/usr/bin/env python3
"""Checks what is said of reply codes and causes in several places against the data model.

Usage: causes_check.py SOURCE_FOLDER | causes_check.py --self-test SOURCE_FOLDER | causes_check.py --table SOURCE_FOLDER
idl/gateway.idl is the one source: names, meaning, and whether asking again helps. Compared are the words in
lib/dds/denial.cpp and the tables of docs/dds-api.md. --table prints the documents' table of causes.
The self-test takes away each row of each of them in turn and fails if that is not found.
"""
import re
import sys

IDL, WORDS, DOCUMENT = "idl/gateway.idl", "lib/dds/denial.cpp", "docs/dds-api.md"
# Headings over the causes, and what documents and programs call them.
AGAIN = {
    "never": "never",
    "after a change": "after a change",
    "when the state is over that reason names": "when the state is over",
    "soon": "soon",
}


def enumerators(idl, name):
    """Name, heading and comment of each enumerator, in their order."""
    body = re.search(rf"^enum {name} {{\n(.*?)^}};", idl, re.S | re.M).group(1)
    heading, found = "", []
    for line in body.splitlines():
        mark = re.match(r"\s*// -- (.*?)(?::.*)?$", line)
        if mark:
            heading = AGAIN[mark.group(1)]
            continue
        member = re.match(r"\s*(\w+),?\s*// (.*)$", line)
        if not member:
            raise ValueError(f"{IDL}: not understood: {line.strip()}")
        found.append((member.group(1), heading, member.group(2)))
    return found


def word_of(cause):
    return cause.removeprefix("CAUSE_").lower()


def again_of(code, comment):
    """What the comment of a reply code says of asking again, as documents say it."""
    for words, said in (("never helps", "never"), ("look first", "look first"), ("`cause` says", "by cause"), ("no need", "–")):
        if words in comment:
            return said
    raise ValueError(f"{IDL}: {code}: does not say whether asking again helps")


def table(idl):
    """Rows of the document's table of causes."""
    rows = []
    for cause, again, comment in enumerators(idl, "RefusalCause"):
        if cause != "CAUSE_NONE":
            rows.append(f"| `{cause}` | `{word_of(cause)}` | {again} | {comment} |")
    return rows


def problems(texts):
    """One line for each place that differs from the data model."""
    idl, found = texts[IDL], []
    for row in table(idl):
        if row not in texts[DOCUMENT]:
            found.append(f"{DOCUMENT}: no row: {row}")
    known = {cause for cause, _, _ in enumerators(idl, "RefusalCause")}
    for cause in re.findall(r"^\| `(CAUSE_\w+)`", texts[DOCUMENT], re.M):
        if cause not in known:
            found.append(f"{DOCUMENT}: {cause} is not in the data model")
    for code, _, comment in enumerators(idl, "ReplyCode"):
        again = again_of(code, comment)
        if not re.search(rf"^\| `{code}` \| .* \| {again} \|$", texts[DOCUMENT], re.M):
            found.append(f"{DOCUMENT}: no row for {code} that ends with: {again}")
    for cause in known:
        if f'{{gateway_{cause}, "{word_of(cause)}"}}' not in texts[WORDS]:
            found.append(f'{WORDS}: {cause} has not the word "{word_of(cause)}"')
    return found


def self_test(texts):
    planted = 0
    for path, pattern in ((DOCUMENT, r"^\| `(?:CAUSE|REPLY)_\w+` \|.*\n"), (WORDS, r"^ *\{gateway_CAUSE_\w+, .*\n")):
        for row in re.finditer(pattern, texts[path], re.M):
            planted += 1
            if not problems({**texts, path: texts[path].replace(row.group(0), "")}):
                return [f"{path}: a missing row is not found: {row.group(0).strip()}"]
    planted_idl = texts[IDL].replace("  CAUSE_FIELD,", "  CAUSE_PLANTED,                // planted\n  CAUSE_FIELD,")
    if len(problems({**texts, IDL: planted_idl})) < 2:
        return [f"{IDL}: a new cause is not missed everywhere"]
    return [] if planted >= 60 else [f"only {planted} rows could be taken away"]


def main():
    option, source = (sys.argv[1], sys.argv[2]) if len(sys.argv) == 3 else ("", sys.argv[1])
    texts = {}
    for path in (IDL, WORDS, DOCUMENT):
        with open(f"{source}/{path}", encoding="utf-8") as file:
            texts[path] = file.read()
    if option == "--table":
        print("\n".join(table(texts[IDL])))
        return 0
    found = self_test(texts) if option == "--self-test" else problems(texts)
    for line in found:
        print(line)
    return 1 if found else 0


if __name__ == "__main__":
    sys.exit(main())
