#!/usr/bin/env python3
"""One state has one word: texts and documents do not use those of the manuals in place of ours.

  words_check.py ROOT         exit 1 and one line per violation, when there is any in ROOT
  words_check.py --self-test  plants each kind of violation and expects it to be found

Looked at are the texts of lib, daemon and tools, the documents, and the headers that are installed but for those of the function
blocks, which speak as the manuals do; other comments are free. The table in docs/cansync-protocol.md
("words for the operating states") has both; that document and those of the manuals' rules may quote the manuals.
"""
import os
import re
import sys

from sources import load

WORDS = {
    r"waiting for start": "stop",
    r"set-up(?! of\b)": "setup",
    r"setting up synchronous operation": "setup",
    r"(?:active|synchronous) operation": "run",
}
FOUND = re.compile("|".join(f"({word})" for word in WORDS), re.IGNORECASE)
LITERALS = re.compile(r'R"\(.*?\)"|"(?:[^"\\\n]|\\.)*"(?:\s*"(?:[^"\\\n]|\\.)*")*', re.DOTALL)
DOCUMENTS = ("README.md", "docs", "config", "systemd", "packaging")
INSTALLED = "lib/client/include"
QUOTES = {"docs/cansync-protocol.md", "docs/cansync-conformance.md", "docs/cansync-slave.md", "docs/cansync-cluster.md"}


def said(place, text):
    """One line for each of the manuals' words in a text."""
    for found in FOUND.finditer(re.sub(r"\s+", " ", text)):
        ours = list(WORDS.values())[next(i for i, part in enumerate(found.groups()) if part)]
        yield f"{place}: {found[0]}   <- {ours} (docs/cansync-protocol.md, words for the operating states)"


def problems(sources, documents):
    found = []
    for path, text in sorted(sources.items()):
        for literal in LITERALS.finditer(text):
            whole = re.sub(r'"\s*"', "", literal[0])
            found += said(f"{path}:{text.count(chr(10), 0, literal.start()) + 1}", whole)
    for path, text in sorted(documents.items()):
        if path not in QUOTES:
            # Wrapped lines belong together; comment marks stand between them.
            found += said(path, re.sub(r"\n[#.\\\"/* ]*", " ", text))
    return found


def documents_of(root):
    files = {}
    for place in DOCUMENTS:
        path = os.path.join(root, place)
        walked = os.walk(path) if os.path.isdir(path) else [(root, (), [place])]
        for folder, _, names in walked:
            for name in names:
                if name.endswith((".md", ".toml", ".mdoc", ".catalog", ".service")):
                    whole = os.path.join(folder, name)
                    with open(whole, encoding="utf-8") as file:
                        files[os.path.relpath(whole, root)] = file.read()
    for path, text in load(root, (INSTALLED,)).items():
        if "/function_blocks/" not in path:
            files[path] = text
    return files


def self_test():
    for sources, documents in (
        ({"lib/a.cpp": 'f("the line is in active "\n  "operation");'}, {}),
        ({"lib/a.cpp": 'f(R"(while the line is\nwaiting for start)");'}, {}),
        ({}, {"docs/a.md": "The line stays in set-up."}),
        ({}, {"config/a.toml": "# as long as it is\n# waiting for start"}),
        ({}, {"lib/client/include/a.h": "/// Enables active\n/// operation."}),
    ):
        if len(problems(sources, documents)) != 1:
            sys.exit(f"{sources} {documents}: found {problems(sources, documents)} instead of one violation")
    clean = problems({"lib/a.cpp": '/// In set-up.\nf("setup, run, stop");'}, {"docs/cansync-protocol.md": "set-up mode"})
    if clean:
        sys.exit(f"found {clean} where there is nothing")


def main():
    if sys.argv[1:] == ["--self-test"]:
        self_test()
        return
    root = sys.argv[1]
    sources = load(root, ("lib", "daemon", "tools/cli", "tools/simulator"))
    documents = documents_of(root)
    if len(sources) < 100 or len(documents) < 20:
        sys.exit(f"only {len(sources)} sources and {len(documents)} documents below {os.path.abspath(root)}")
    found = problems(sources, documents)
    if found:
        print("\n".join(found))
    sys.exit(bool(found))


if __name__ == "__main__":
    main()
