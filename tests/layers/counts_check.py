#!/usr/bin/env python3
"""Texts say numbers of things and durations in one way (lib/text/counts.h): no "1 slaves", no "3000ms".

  counts_check.py ROOT         exit 1 and one line per violation, when there is any in ROOT
  counts_check.py --self-test  plants each kind of violation and expects it to be found

Looked at are the texts of lib, daemon and tools: a plural right behind a placeholder, for which text::counted is there; a
unit that touches its number; and the durations of fmt/chrono.h, which touch theirs. Bounds ("up to {} bytes", "1..{} bytes",
"over {} bytes") are constants above one, and stay.
"""
import os
import re
import sys

from sources import load

NOUNS = """actions addresses answers attempts batches bits blocks buses bytes clients commands counts cycles daemons documents
drives edges entries errors events faults fields files folders frames identities intervals jobs levels lines looks marks
masters messages names nodes numbers options packets parameters participants places points profiles programs ranges records
replies reports requests restarts rows samples slaves steps telegrams times timers transfers turns values words writers"""
ADJECTIVES = "open|parameter|status|error|foreign|SYNC|further|more"
PLURAL = re.compile(r"(up to |over |less than |\.\.)?\{[^{}]*\} (?:(?:" + ADJECTIVES + r") )?(" + "|".join(NOUNS.split()) + r")\b(?!/| 0\.\.)")
GLUED = re.compile(r"\{[^{}]*\}(?:ms|us|ns|s)\b")
LITERALS = re.compile(r'"(?:[^"\\\n]|\\.)*"(?:\s*"(?:[^"\\\n]|\\.)*")*')
CHRONO = re.compile(r'#\s*include\s+[<"]fmt/chrono\.h')

# Who may write a date or a time of day.
OF_DATES = {"daemon/recorder/flight_files.cpp", "daemon/status/identity_watch.cpp"}
# "slave {} answers": a verb.
VERBS = re.compile(r"(?:slave|\{\}) \{[^{}]*\} (?:answers|times)\b|\{[^{}]*\} answers[,.;]? (?:but|for|with)\b")


def problems(files):
    found = []
    for path, text in sorted(files.items()):
        if CHRONO.search(text) and path not in OF_DATES:
            found.append(f"{path}: fmt/chrono.h   <- text::duration_text (text/counts.h)")
        for literal in LITERALS.finditer(text):
            line = text.count("\n", 0, literal.start()) + 1
            whole = re.sub(r'"\s*"', "", literal[0])
            for plural in PLURAL.finditer(VERBS.sub("", whole)):
                if not plural[1]:
                    found.append(f"{path}:{line}: {plural[0]}   <- text::counted (text/counts.h)")
            found += [f"{path}:{line}: {glued[0]}   <- text::duration_text (text/counts.h)" for glued in GLUED.finditer(whole)]
    return found


def self_test():
    planted = {
        "lib/a.cpp": 'format("{} slaves", n)',
        "lib/b.cpp": 'format("its {} open "\n       "requests are", n)',
        "lib/c.cpp": 'format("after {:.1f}s", t)',
        "lib/d.cpp": "#include <fmt/chrono.h>\n",
    }
    clean = {"lib/e.cpp": 'format("allowed: up to {} bytes, 1..{} bytes; slave {} answers at {} bit/s, {} ms", a, b, c, d, e)'}
    for path, text in planted.items():
        if len(problems({path: text})) != 1:
            sys.exit(f"{path}: found {problems({path: text})} instead of one violation")
    if problems(clean):
        sys.exit(f"found {problems(clean)} where there is nothing")


def main():
    if sys.argv[1:] == ["--self-test"]:
        self_test()
        return
    root = sys.argv[1]
    files = load(root, ("lib", "daemon", "tools/cli", "tools/simulator"))
    if len(files) < 100:
        sys.exit(f"only {len(files)} sources below {os.path.abspath(root)}")
    found = problems(files)
    print("\n".join(found))
    sys.exit(bool(found))


if __name__ == "__main__":
    main()
