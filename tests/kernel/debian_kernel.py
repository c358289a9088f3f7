"""Debian's current kernel, fetched and not installed: its image, and its modules in the order in which they are loaded."""

import glob
import lzma
import os
import re
import struct
import subprocess
import tempfile

CACHE = os.environ.get("CANSYNC_KERNEL_CACHE", os.path.expanduser("~/.cache/cansyncd-kernel"))
# kvaser_pci drives the emulated controllers; the queueing disciplines hold frames back on vcan, which itself never does, etf for
# bench/timed_slots; veth is a network cable, and udp_diag tells `ss` to which interface a socket is bound.
MODULES = ["udp_diag", "veth", "can", "can_raw", "can_bcm", "can_dev", "can_j1939", "vcan", "kvaser_pci", "sch_tbf", "sch_plug", "sch_etf"]
LONG = 300  # seconds; one command, a download too


class Missing(Exception):
    """What is needed cannot be had here; the text says why."""


def unpacked(image):
    """What this image unpacks when it is started, beside it (`payload_offset` of Linux' Documentation/x86/boot.rst): a machine that is
    emulated takes much longer for it than this computer does."""
    path = image.replace("vmlinuz-", "vmlinux-")
    if not os.path.exists(path):
        with open(image, "rb") as file:
            content = file.read()
        after_setup = (content[0x1F1] + 1) * 512
        offset, length = struct.unpack_from("<II", content, 0x248)
        with tempfile.NamedTemporaryFile(dir=os.path.dirname(image), delete=False) as work:
            work.write(lzma.LZMADecompressor().decompress(content[after_setup + offset:][:length]))
        os.chmod(work.name, 0o644)
        os.rename(work.name, path)
    return path


class Kernel:
    """The kernel in a folder that has boot/vmlinuz-* and lib/modules/*."""

    def __init__(self, folder):
        self.folder = folder
        self.image = unpacked(glob.glob(os.path.join(folder, "boot/vmlinuz-*"))[0])
        self.modules = self.in_order(MODULES)

    def in_order(self, names):
        """Paths of the modules of these names and all they depend on, each after what it needs; what the kernel has built in is left
        out."""
        files = {}
        for path in glob.glob(os.path.join(self.folder, "lib/modules/*/kernel/**/*.ko"), recursive=True):
            files[os.path.basename(path)[:-3].replace("-", "_")] = path
        order = []

        def add(name):
            if name not in files or files[name] in order:
                return
            with open(files[name], "rb") as file:
                depends = re.search(rb"\0depends=([^\0]*)\0", file.read())
            for other in depends.group(1).decode().split(",") if depends else []:
                add(other.replace("-", "_"))
            order.append(files[name])

        for name in names:
            add(name)
        return order


def ask(*command, **options):
    """What a command of apt says, in English."""
    try:
        return subprocess.run(command, capture_output=True, text=True, check=False, timeout=LONG, env=os.environ | {"LC_ALL": "C"}, **options)
    except subprocess.TimeoutExpired:
        raise Missing(f"{' '.join(command)} has not ended within {LONG} s") from None


def current():
    """The package that linux-image-amd64 depends on; where apt does not know, the newest in the cache folder. Raises Missing."""
    found = re.search(r"Depends: (linux-image-\S+-amd64)$", ask("apt-cache", "depends", "linux-image-amd64").stdout, re.MULTILINE)
    if found:
        return found.group(1)
    kept = sorted(glob.glob(os.path.join(CACHE, "linux-image-*-amd64")), key=os.path.getmtime)
    if not kept:
        raise Missing("apt-cache knows no linux-image-amd64; is the package list there (apt-get update)?")
    return os.path.basename(kept[-1])


def fetch():
    """Debian's current kernel, downloaded by apt when it is not in the cache folder; raises Missing."""
    package = current()
    folder = os.path.join(CACHE, package)
    if os.path.isdir(folder):
        return Kernel(folder)
    os.makedirs(CACHE, exist_ok=True)
    # Everything happens in a folder of its own, so that two tests at once do not see half a kernel.
    with tempfile.TemporaryDirectory(dir=CACHE) as work:
        os.chmod(work, 0o755)  # apt downloads as another user
        fetched = ask("apt-get", "download", package, cwd=work)
        if fetched.returncode != 0:
            raise Missing(f"{package} cannot be downloaded: {fetched.stderr.strip()}")
        unpacked = os.path.join(work, "unpacked")
        subprocess.run(["dpkg-deb", "-x", glob.glob(os.path.join(work, "*.deb"))[0], unpacked], check=True, timeout=LONG)
        try:
            os.rename(unpacked, folder)
        except OSError:
            if not os.path.isdir(folder):
                raise
    return Kernel(folder)
