#!/usr/bin/env python3
"""Checks what is said of reply codes and causes in several places against the data model.

Usage: causes_check.py SOURCE_FOLDER | causes_check.py --self-test SOURCE_FOLDER | causes_check.py --table SOURCE_FOLDER
idl/gateway.idl is the one source: names, meaning, and whether asking again helps. Compared are the words in
lib/dds/denial.cpp, the client library's table and C header, the tables of docs/dds-api.md, and the table of the
requests that provoke each cause. --table prints the documents' table of causes.
The self-test takes away each row of each of them in turn and fails if that is not found.
"""
import json
import os
import re
import sys

IDL, WORDS, DOCUMENT = "idl/gateway.idl", "lib/dds/denial.cpp", "docs/dds-api.md"
CLIENT, FACE, PROVOKED = "lib/client/src/causes.cpp", "lib/client/include/cansync/cansync_c_base.h", "tests/client/refusals.json"
SOURCES = (IDL, WORDS, DOCUMENT, CLIENT, FACE, PROVOKED)
# Headings over the causes, and what documents and programs call them.
AGAIN = {
    "never": "never",
    "after a change": "after a change",
    "when the state is over that reason names": "state over",
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
            rows.append(f"| `{cause}` | {again}: {comment} |")
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
    return found + client_problems(texts) + provoked_problems(texts)


def client_problems(texts):
    """Of the C++ and the C face."""
    found = []
    for number, (cause, again, _) in enumerate(enumerators(texts[IDL], "RefusalCause")):
        retry = {"after a change": "after_change", "state over": "when_state_over"}.get(again, again or "never")
        if f"{{gateway_{cause}, RefusalCause::{word_of(cause)}, Retry::{retry}}}" not in texts[CLIENT]:
            found.append(f"{CLIENT}: no row for {cause} with Retry::{retry}")
        if not re.search(rf"^ *CANSYNC_{cause} =\s+{number}\b", texts[FACE], re.M):
            found.append(f"{FACE}: CANSYNC_{cause} is not {number}")
    said = {"never": "never", "look first": "look_first", "–": "never", "by cause": "never"}
    for code, _, comment in enumerators(texts[IDL], "ReplyCode"):
        row = f"CodeRow{{ReplyCode::{code.removeprefix('REPLY_').lower()}, Retry::{said[again_of(code, comment)]}}}"
        if row not in texts[CLIENT]:
            found.append(f"{CLIENT}: no row {row}")
    return found


def provoked_problems(texts):
    """Every cause is in the table of provoked requests, or names the test where it is decided."""
    found, table = [], json.loads(texts[PROVOKED])
    decided = {row["cause"]: row for row in table["decided"]}
    listed = {row["cause"] for row in table["provoked"] + table["without_library"]} | set(decided)
    known = {word_of(cause) for cause, _, _ in enumerators(texts[IDL], "RefusalCause")} - {"none"}
    found += [f"{PROVOKED}: nothing provokes '{cause}'" for cause in sorted(known - listed)]
    found += [f"{PROVOKED}: '{cause}' is no cause" for cause in sorted(listed - known)]
    for cause, row in decided.items():
        path, suite, case = re.match(r"(\S+): (\w+)\.(\w+)$", row["test"]).groups()
        path = os.path.join(texts["source"], path)
        text = open(path, encoding="utf-8").read() if os.path.exists(path) else ""
        body = re.search(rf"^TEST(?:_F|_P)?\({suite}, {case}\) {{(.*?)^}}", text, re.S | re.M)
        if not body or not re.search(rf"CAUSE_{cause.upper()}\b|RefusalCause::{cause}\b", body.group(1)):
            found.append(f"{PROVOKED}: '{cause}': {row['test']} does not look at it")
    return found


def self_test(texts):
    planted = 0
    if problems(texts):
        return ["without a violation there are some: see the check itself"]
    for path, pattern in (
        (DOCUMENT, r"^\| `(?:CAUSE|REPLY)_\w+` \|.*\n"),
        (WORDS, r"^ *\{gateway_CAUSE_\w+, .*\n"),
        (CLIENT, r"^ *(?:\{gateway_CAUSE_|CodeRow\{ReplyCode::(?!no_reply|no_daemon))\w+, .*\n"),
        (FACE, r"^ *CANSYNC_CAUSE_\w+ = *\n? *\d+"),
        (PROVOKED, r'"cause": "(?!wrong_state|read_only|slave_not_configured)\w+"'),
    ):
        for row in re.finditer(pattern, texts[path], re.M):
            planted += 1
            gone = '"cause": "planted"' if path == PROVOKED else ""
            found = problems({**texts, path: texts[path].replace(row.group(0), gone)})
            if path == PROVOKED:
                found = [line for line in found if "nothing provokes" in line]
            if not found:
                return [f"{path}: a missing row is not found: {row.group(0).strip()}"]
    planted_idl = texts[IDL].replace("  CAUSE_FIELD,", "  CAUSE_PLANTED,                // planted\n  CAUSE_FIELD,")
    if len({line.split(":")[0] for line in problems({**texts, IDL: planted_idl})}) < 5:
        return [f"{IDL}: a new cause is not missed everywhere"]
    return [] if planted >= 150 else [f"only {planted} rows could be taken away"]


def main():
    option, source = (sys.argv[1], sys.argv[2]) if len(sys.argv) == 3 else ("", sys.argv[1])
    texts = {"source": source}
    for path in SOURCES:
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
