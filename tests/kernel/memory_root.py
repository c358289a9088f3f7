"""The file system of the machine: everything the tests need of this computer, in the machine's memory.

Waiting for a disk would be the only thing in the machine that takes as long as its host makes it take.
"""

import functools
import glob
import os
import re
import subprocess
import tempfile

from debian_kernel import LONG, Missing

REPOSITORY = os.path.dirname(os.path.dirname(os.path.dirname(os.path.abspath(__file__))))
# Where the repository is inside, wherever it is here: with the same bytes in memory the same seed is the same course everywhere.
INSIDE = "/project"
# Debian packages, each with those that it depends on within FAMILIES.
PACKAGES = ("bash", "can-utils", "coreutils", "findutils", "grep", "hostname", "iproute2", "libddsc0debian", "mawk", "ncurses-base", "openssl",
            "python3", "python3-can", "python3-cffi-backend", "python3-jsonschema", "python3-prometheus-client", "python3-pyte", "sed", "strace", "util-linux")
FAMILIES = re.compile(r"(lib)?python3")
NOT_NEEDED = re.compile(r"/usr/share/(doc|man|info|locale|lintian|doc-base)/|/usr/lib/python3[.0-9]*/(idlelib|lib2to3|pydoc_data)/")
PROGRAMS = ("awk", "busybox", "sh")  # which of several is chosen here
# Files and folders of the repository.
PLACES = ("bench", "config", "docs", "tests/bench", "tests/client", "tests/end_to_end", "tests/fastdds", "tests/kernel", "tests/manual", "tests/pictures",
          "tests/python", "tools/completions", "tools/demo", "tools/demos", "tools/examples", "tools/security")
MERGED = ("bin", "sbin", "lib", "lib64")  # Debian has them in /usr
FILE, FOLDER, LINK = 0o100000, 0o040755, 0o120777


class Archive:
    """A cpio archive (newc) as the kernel unpacks it into its first file system."""

    def __init__(self):
        self.parts = []
        self.names = set()

    def add(self, name, mode, content=b"", changed=0):
        """One entry, its folders before it. `changed`: when, in s: Python compares it with what it compiled."""
        name = name.lstrip("/")
        if name.split("/")[0] in MERGED and "/" in name:
            name = "usr/" + name
        if not name or name in self.names:
            return
        self.add(os.path.dirname(name), FOLDER)
        self.names.add(name)
        fields = [len(self.names), mode, 0, 0, 1, changed, len(content), 0, 0, 0, 0, len(name) + 1, 0]
        head = b"070701" + b"".join(b"%08X" % field for field in fields) + name.encode() + b"\0"
        self.parts += [head, b"\0" * (-len(head) % 4), content, b"\0" * (-len(content) % 4)]

    def add_file(self, path, name=None):
        """A file of this computer, under its own path or another; of a link what it leads to as well."""
        path = os.fspath(path)
        if name is None and os.path.islink(path):
            real = os.path.realpath(path)
            self.add(path, LINK, real.encode())
            path = real
        # Python looks at when a source was changed; nothing at when this computer got the others.
        changed = int(os.stat(path).st_mtime) if path.endswith(".py") else 0
        with open(path, "rb") as file:
            self.add(name or path, mode_of(path), file.read(), changed)

    def finish(self):
        self.add("TRAILER!!!", 0)
        return b"".join(self.parts)


def mode_of(path):
    return FILE | (0o755 if os.access(path, os.X_OK) else 0o644)


def inside(text):
    """With the paths of the repository that it has inside."""
    return re.sub(rf"{re.escape(REPOSITORY)}(?![\w.-])", INSIDE, text)


def output(*command):
    return subprocess.run(command, capture_output=True, text=True, check=False, timeout=LONG).stdout


def package_closure():
    """Names of PACKAGES and of what they depend on within FAMILIES."""
    names, open_ones = set(), list(PACKAGES)
    while open_ones:
        name = open_ones.pop()
        if name in names:
            continue
        names.add(name)
        depends = output("dpkg-query", "--show", "--showformat=${Pre-Depends}, ${Depends}", name)
        open_ones += [other for other in re.findall(r"[a-z0-9.+-]+(?=[ ,:|(]|$)", depends) if FAMILIES.match(other)]
    return sorted(names)


def package_files():
    states = output("dpkg-query", "--show", "--showformat=${Package} ${db:Status-Status}\n", *PACKAGES).splitlines()
    missing = [name for name in PACKAGES if f"{name} installed" not in states]
    if missing:
        raise Missing(f"not installed: {' '.join(missing)}; tools/install_packages does it")
    files = {path for path in output("dpkg-query", "--listfiles", *package_closure()).splitlines()
             if os.path.isfile(path) and not NOT_NEEDED.search(path)}
    # What Python has compiled of them is in no package's list.
    return files | {compiled for folder in {os.path.dirname(path) for path in files if path.endswith(".py")}
                    for compiled in glob.glob(f"{folder}/__pycache__/*.pyc")}


def find_program(name):
    for folder in ("/usr/bin", "/usr/sbin", "/bin", "/sbin"):
        path = os.path.join(folder, name)
        if os.path.exists(path):
            return path
    raise Missing(f"{name} is missing; tools/install_packages installs it")


def is_elf(path):
    with open(path, "rb") as file:
        return file.read(4) == b"\x7fELF"


def libraries(paths):
    """Every shared library that these programs and libraries need."""
    found = re.findall(r"^\s+(?:\S+ => )?(/.+) \(0x", output("ldd", *sorted(paths)), re.MULTILINE)
    return set(map(os.path.normpath, found))


@functools.cache
def files_of_debian():
    return frozenset(package_files() | set(map(find_program, PROGRAMS)))


def files_of_repository():
    """Those of PLACES that git knows or would add; all where there is no git."""
    listed = output("git", "-C", REPOSITORY, "ls-files", "-z", "--cached", "--others", "--exclude-standard", "--", *PLACES)
    places = [os.path.join(REPOSITORY, place) for place in PLACES]
    found = [os.path.join(REPOSITORY, name) for name in listed.split("\0") if name] or [
        os.path.join(folder, name) for place in places for folder, _, names in os.walk(place) for name in names]
    return set(filter(os.path.isfile, found))


def content(path):
    """What a file of the repository is inside: a program without what a debugger needs, a text with the paths that are right there."""
    if is_elf(path):
        with tempfile.NamedTemporaryFile() as small:
            subprocess.run(["strip", "-o", small.name, path], check=True, timeout=LONG)
            return small.read()
    with open(path, "rb") as file:
        return inside(file.read().decode(errors="surrogateescape")).encode(errors="surrogateescape")


def make(files, modules, start):
    """The archive: `files` (ours), `modules` of the kernel, the shell script `start` as the first process; raises Missing."""
    archive = Archive()
    for name in MERGED:
        archive.add(name, LINK, f"usr/{name}".encode())
    for name in ("dev", "proc", "sys", "run", "tmp"):
        archive.add(name, FOLDER)
    archive.add("etc/passwd", FILE | 0o644, b"root:x:0:0:root:/run:/bin/sh\n")
    archive.add("etc/hosts", FILE | 0o644, b"127.0.0.1 localhost machine\n")
    archive.add("init", FILE | 0o755, inside(start).encode())
    paths = files_of_debian() | files_of_repository() | set(files)
    paths |= libraries(filter(is_elf, paths))
    for path in sorted(paths):
        if path.startswith(f"{REPOSITORY}/"):
            archive.add(inside(path), mode_of(path), content(path))
        else:
            archive.add_file(path)
    for module in modules:
        archive.add_file(module, f"modules/{os.path.basename(module)}")
    archive.add("modules/order", FILE | 0o644, "\n".join(map(os.path.basename, modules)).encode())
    return archive.finish()
