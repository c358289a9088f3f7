#!/usr/bin/env python3
"""Names every folder of the project with more files than fit on a screen: a newcomer reads its list at one look.

  folders_check.py ROOT   exit 1 and one line per folder; files of subfolders count there
  folders_check.py --self-test

A corpus of a fuzzer that grew over it is made smaller with libFuzzer's -set_cover_merge=1.
"""
import os
import sys
import tempfile

MOST = 45


def crowded(root):
    """[(folder, files)] of folders with more than MOST files; not of what builds and versions leave."""
    found = []
    for folder, below, files in os.walk(root):
        below[:] = sorted(name for name in below if name not in ("build", "__pycache__") and not name.startswith("."))
        if len(files) > MOST:
            found.append((os.path.relpath(folder, root), len(files)))
    return found


def self_test():
    with tempfile.TemporaryDirectory() as root:
        for folder, files in (("full", MOST), ("crowded", MOST + 1), ("build", MOST + 1), ("full/below", 1)):
            os.makedirs(os.path.join(root, folder), exist_ok=True)
            for number in range(files):
                open(os.path.join(root, folder, str(number)), "w").close()
        return crowded(root) == [("crowded", MOST + 1)]


def main():
    if len(sys.argv) != 2:
        sys.exit(f"usage: {sys.argv[0]} ROOT | --self-test")
    if sys.argv[1] == "--self-test":
        sys.exit(0 if self_test() else "the folders that were planted were not found")
    found = crowded(sys.argv[1])
    for folder, files in found:
        print(f"{folder}: {files} files; allowed: {MOST}")
    sys.exit(1 if found else 0)


main()
