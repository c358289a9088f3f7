#!/usr/bin/env python3
"""Breaks each rule of the table in each protocol (mutants.toml) and sees whether given_test finds it.

  mutants.py --check           each mutant changes exactly one place of the source
  mutants.py [WORDS]           tries them, or those whose `what` has the words, in a copy under build/mutants
Exit code: 0 all are found; 1 one is not, does not build, or has no place in the source.
"""
import os
import pathlib
import shutil
import subprocess
import sys
import tomllib

HERE = pathlib.Path(__file__).resolve().parent
TOP = HERE.parent.parent
COPY = TOP / "build" / "mutants"
LONGEST_S = 300  # of the tests; a mutant that hangs is found


def run(command, **more):
    return subprocess.run(command, cwd=COPY, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True, check=False,
                          **more)


def copy():
    """The tree as it is, without builds; what is the same keeps its time, so that it is not built again."""
    files = subprocess.run(["git", "ls-files", "--cached", "--others", "--exclude-standard"], cwd=TOP, check=True,
                           capture_output=True, text=True).stdout.splitlines()
    for name in files:
        source, target = TOP / name, COPY / name
        if not source.is_file() or (target.is_file() and target.read_bytes() == source.read_bytes()):
            continue
        target.parent.mkdir(parents=True, exist_ok=True)
        shutil.copy(source, target)


def build():
    """None, or what the compiler said."""
    made = run(["cmake", "--build", "--preset", "dev", "--target", "given_test"])
    return None if made.returncode == 0 else made.stdout


def found():
    """A test has failed, or never ended."""
    try:
        return run(["build/dev/tests/given/given_test", "--gtest_brief=1"], timeout=LONGEST_S).returncode != 0
    except subprocess.TimeoutExpired:
        return True


def survivors(mutants):
    copy()
    os.environ |= {"CCACHE_BASEDIR": str(COPY), "CCACHE_NOHASHDIR": "1"}
    prepared = run(["cmake", "--preset", "dev"])
    wrong = prepared.stdout if prepared.returncode != 0 else build()
    if wrong is not None or found():
        sys.exit(f"without a mutant: {wrong or 'given_test fails'}")
    lived = []
    for mutant in mutants:
        path = COPY / mutant["file"]
        text = path.read_text(encoding="utf-8")
        path.write_text(text.replace(mutant["old"], mutant["new"]), encoding="utf-8")
        wrong = build()
        result = f"does not build: {wrong}" if wrong is not None else "found" if found() else "NOT FOUND"
        path.write_text(text, encoding="utf-8")
        print(f"rule {mutant['rule']}, {mutant['protocol']}: {mutant['what']}: {result}", flush=True)
        if result != "found":
            lived.append(mutant["what"])
    return lived


def main(words):
    mutants = tomllib.loads((HERE / "mutants.toml").read_text(encoding="utf-8"))["mutant"]
    wrong = [f"{one['what']}: its text stands {count} times in {one['file']}, wanted once" for one in mutants
             if (count := (TOP / one["file"]).read_text(encoding="utf-8").count(one["old"])) != 1]
    if wrong:
        sys.exit("mutants.toml: " + "\n".join(wrong))
    if words == ["--check"]:
        return
    lived = survivors([one for one in mutants if " ".join(words) in one["what"]])
    if lived:
        sys.exit(f"{len(lived)} of the mutants are not found: " + "; ".join(lived))


if __name__ == "__main__":
    main(sys.argv[1:])
