"""A virtual PC with a Debian kernel and two CAN controllers (SJA1000) on one bus, for tests of real drivers.

It runs in QEMU without KVM. The kernel comes from the Debian package that linux-image-amd64 depends on; it is
unpacked into a cache folder, not installed. The host's file system is the guest's, read-only, so that programs run
in the guest as they were built; one folder is shared in both directions at /mnt. Needs no right of its own.
"""

import glob
import os
import re
import shutil
import subprocess
import tempfile

from priority import prefer_realtime

CACHE = os.environ.get("CANSYNC_KERNEL_CACHE", os.path.expanduser("~/.cache/cansyncd-kernel"))
MODULES = ["virtio_pci", "9pnet_virtio", "9p", "can", "can_raw", "can_dev", "kvaser_pci"]
BUSYBOX = "/bin/busybox"
LONG = 300  # seconds; one command, a download too
QEMU = "qemu-system-x86_64"

INIT = """#!/bin/busybox sh
b=/bin/busybox
$b mkdir -p /proc /root
$b mount -t proc proc /proc
for module in $($b cat /modules/order); do $b insmod /modules/$module || echo "insmod $module failed"; done
$b mount -t 9p -o trans=virtio,version=9p2000.L,ro,cache=loose,msize=262144 host /root
$b mount -t 9p -o trans=virtio,version=9p2000.L,rw,cache=none,msize=262144 shared /root/mnt
$b mount -t proc proc /root/proc
$b mount -t sysfs sysfs /root/sys
$b mount -t devtmpfs dev /root/dev
$b mkdir -p /root/dev/shm /root/dev/pts
$b mount -t tmpfs tmpfs /root/dev/shm
$b mount -t devpts devpts /root/dev/pts
$b mount -t tmpfs tmpfs /root/run
$b mkdir -p /root/run/tmp
$b ip link set lo up
$b chroot /root /usr/bin/env -i PATH=/usr/sbin:/usr/bin:/sbin:/bin HOME=/run TMPDIR=/run/tmp /bin/sh /mnt/command
echo $? > /root/mnt/exit_code
$b poweroff -f
"""


class Missing(Exception):
    """The machine cannot be had here; the text says why."""


def kernel_folder():
    """Folder with boot/vmlinuz-* and lib/modules/* of Debian's current kernel, fetched when it is not there."""
    depends = subprocess.run(["apt-cache", "depends", "linux-image-amd64"], capture_output=True, text=True, check=False,
                             timeout=LONG)
    found = re.search(r"Depends: (linux-image-\S+-amd64)$", depends.stdout, re.MULTILINE)
    if not found:
        raise Missing("apt-cache knows no linux-image-amd64; is the package list there (apt-get update)?")
    package = found.group(1)
    folder = os.path.join(CACHE, package)
    if os.path.isdir(folder):
        return folder
    os.makedirs(CACHE, exist_ok=True)
    # Everything happens in a folder of its own, so that two tests at once do not see half a kernel.
    with tempfile.TemporaryDirectory(dir=CACHE) as work:
        os.chmod(work, 0o755)  # apt downloads as another user
        fetched = subprocess.run(["apt-get", "download", package], cwd=work, capture_output=True, text=True, check=False,
                                 timeout=LONG)
        if fetched.returncode != 0:
            raise Missing(f"{package} cannot be downloaded: {fetched.stderr.strip()}")
        unpacked = os.path.join(work, "unpacked")
        subprocess.run(["dpkg-deb", "-x", glob.glob(os.path.join(work, "*.deb"))[0], unpacked], check=True,
                       timeout=LONG)
        try:
            os.rename(unpacked, folder)
        except OSError:
            if not os.path.isdir(folder):
                raise
    return folder


def modules_in_order(kernel):
    """Paths of MODULES and all they depend on, each after what it needs; what the kernel has built in is left out."""
    files = {}
    for path in glob.glob(os.path.join(kernel, "lib/modules/*/kernel/**/*.ko"), recursive=True):
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

    for module in MODULES:
        add(module)
    return order


class Archive:
    """A cpio archive (newc) as the kernel unpacks it into its first file system."""

    def __init__(self):
        self.data = b""
        self.number = 0

    def add(self, name, mode, content=b""):
        self.number += 1
        fields = [self.number, mode, 0, 0, 1, 0, len(content), 0, 0, 0, 0, len(name) + 1, 0]
        head = b"070701" + b"".join(b"%08X" % field for field in fields) + name.encode() + b"\0"
        self.data += head + b"\0" * (-len(head) % 4) + content + b"\0" * (-len(content) % 4)

    def finish(self):
        self.add("TRAILER!!!", 0)
        return self.data


def initramfs(kernel):
    archive = Archive()
    for folder in ("bin", "dev", "modules", "proc", "root"):
        archive.add(folder, 0o040755)
    with open(BUSYBOX, "rb") as file:
        archive.add("bin/busybox", 0o100755, file.read())
    archive.add("init", 0o100755, INIT.encode())
    names = []
    for path in modules_in_order(kernel):
        names.append(os.path.basename(path))
        with open(path, "rb") as file:
            archive.add("modules/" + names[-1], 0o100644, file.read())
    archive.add("modules/order", 0o100644, "\n".join(names).encode())
    return archive.finish()


def need_tools():
    """Raises Missing for the first thing that is not there."""
    if not shutil.which(QEMU):
        raise Missing(f"{QEMU} is not installed (Debian package qemu-system-x86)")
    for module in ("virtfs",):
        helped = subprocess.run([QEMU, "-help"], capture_output=True, text=True, check=False, timeout=LONG)
        if module not in helped.stdout:
            raise Missing(f"{QEMU} was built without {module}")
    if not os.path.exists(BUSYBOX):
        raise Missing(f"{BUSYBOX} is not there (Debian package busybox-static)")
    linked = subprocess.run(["ldd", BUSYBOX], capture_output=True, text=True, check=False, timeout=LONG)
    if linked.returncode == 0 and "=>" in linked.stdout:
        raise Missing(f"{BUSYBOX} is not statically linked (Debian package busybox-static)")


def run(command, shared, timeout, show=print):
    """Boots, runs the shell script `command` in the guest with `shared` (a folder) at /mnt, and shuts down.

    Returns the script's exit code; None when the guest ended without one. `show` gets each line of the console.
    """
    need_tools()
    kernel = kernel_folder()
    with open(os.path.join(shared, "command"), "w", encoding="utf-8") as file:
        file.write(command)
    with tempfile.TemporaryDirectory() as work:
        initrd = os.path.join(work, "initrd")
        with open(initrd, "wb") as file:
            file.write(initramfs(kernel))
        arguments = [QEMU, "-machine", "pc", "-accel", "tcg,thread=multi", "-cpu", "max", "-smp", "2", "-m", "768"]
        arguments += ["-nodefaults", "-display", "none", "-serial", "stdio", "-no-reboot"]
        arguments += ["-kernel", glob.glob(os.path.join(kernel, "boot/vmlinuz-*"))[0], "-initrd", initrd]
        arguments += ["-append", "console=ttyS0 quiet panic=-1 mitigations=off no_timer_check tsc=reliable clocksource=tsc"]
        arguments += ["-object", "can-bus,id=bus", "-device", "kvaser_pci,canbus=bus", "-device", "kvaser_pci,canbus=bus"]
        share = "local,security_model=none,multidevs=remap"
        arguments += ["-virtfs", f"{share},path=/,mount_tag=host,readonly=on"]
        arguments += ["-virtfs", f"{share},path={shared},mount_tag=shared"]
        with subprocess.Popen(
            arguments, stdin=subprocess.DEVNULL, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, start_new_session=True,
            preexec_fn=prefer_realtime
        ) as machine:
            # `timeout` of the whole machine, also while it is silent.
            watchdog = subprocess.Popen(["sh", "-c", f"sleep {timeout}; kill -9 {machine.pid}"], start_new_session=True)
            try:
                for line in machine.stdout:
                    show(line.decode(errors="replace").rstrip())
            finally:
                os.killpg(watchdog.pid, 15)
                watchdog.wait(LONG)
                machine.kill()
    try:
        with open(os.path.join(shared, "exit_code"), encoding="utf-8") as file:
            return int(file.read())
    except OSError:
        return None
