"""Builds the Debian packages, installs them with apt in a fresh Debian, boots that with systemd as its first process in the
machine that has a time of its own (tests/kernel/machine.py), and runs the tests of the folder `inside` in it.

    run.py [--previous] [--keep FOLDER] [--install-only] [--lines N] [--gaps N] [--cuts N] [--upgrades N]
    --previous builds the packages that are upgraded, when an earlier run has not left them; without it those of this commit under
    a lower version stand for them then, for on a computer without them that takes half an hour;
    FOLDER keeps packages and root file system, to look at them, and is taken up again for the same commit; with --install-only
    nothing is booted; N lines made at random are set up, 2 when it is not given; the adapter is gone N times more than it is
    anyhow, 4 when it is not given; the power is cut N times, 6 when it is not given; the packages are upgraded N times while
    a line runs, once when it is not given

CANSYNC_SEED in the environment: as for tests/kernel/run_machine.py.
Needs the packages of tools/packages.txt and a Debian mirror; no rights. Exit code: 0 all well, 1 something is wrong, 77 this
computer cannot do it, with the reason.
"""

import argparse
import concurrent.futures
import contextlib
import hashlib
import os
import pathlib
import re
import shlex
import shutil
import signal
import subprocess
import sys
import tempfile
import time

HERE = pathlib.Path(__file__).resolve().parent
REPOSITORY = HERE.parent.parent
sys.path.insert(0, str(REPOSITORY / "tests/kernel"))
import debian_kernel  # noqa: E402  (its folder is named above)
import machine  # noqa: E402
import memory_root  # noqa: E402

SKIPPED = 77
COMMAND_LIMIT = 7200  # seconds; one step: building on a busy machine takes the longest
LIMIT = 3600  # seconds of this computer from power-on to power-off; four minutes are usual
# MiB. All files lie in it: waiting for a disk would be the only thing in the machine that takes as long as its host makes it take.
MEMORY = 3072
# What a gateway PC has, and what the tests look with.
DEBIAN = ("systemd", "systemd-sysv", "udev", "dbus", "iproute2", "kmod", "procps", "util-linux", "man-db", "python3",
          "bash-completion", "needrestart", "polkitd", "prometheus-node-exporter", "unattended-upgrades")
SHARED = ("kernel/unknown_line.py", "kernel/random_line.py", "kernel/canline.py", "end_to_end/gateway.py",
          "end_to_end/json_schemas.py", "end_to_end/wording.py")
NO_MIRROR = re.compile(r"E: (Failed to fetch|Unable to fetch|Unable to locate package)|Temporary failure resolving|Could not resolve")
# First process. What mounts a file system on demand is a module of Debian's kernel, and systemd asks for it before it loads any.
MODULES = (*debian_kernel.MODULES, "autofs4", "loop", "crc32c_generic", "ext4")
START = """#!/bin/sh
for module in /modules/*; do /usr/sbin/insmod "$module"; done
exec /lib/systemd/systemd systemd.show_status=0
"""


def run(*command, **options):
    """Runs a command; its output only when it fails."""
    done = subprocess.run([str(part) for part in command], text=True, stdout=subprocess.PIPE, stderr=subprocess.STDOUT,
                          check=False, timeout=COMMAND_LIMIT, **options)
    if done.returncode != 0:
        print(f"run.py: {' '.join(map(str, command))}: exit code {done.returncode}\n{done.stdout[-6000:]}")
        if NO_MIRROR.search(done.stdout):
            raise debian_kernel.Missing("the mirror of Debian cannot be reached, or has not what is asked for")
        sys.exit(1)
    return done.stdout.strip()


@contextlib.contextmanager
def stage(name):
    began = time.monotonic()
    print(f"-- {name}", flush=True)
    yield
    print(f"   {time.monotonic() - began:.0f} s", flush=True)


def git(*arguments):
    return subprocess.run(["git", "-C", REPOSITORY, *arguments], text=True, stdout=subprocess.PIPE,
                          stderr=subprocess.DEVNULL, check=False, timeout=60).stdout.strip()


def commit_before():
    """The commit that `upgraded_from` names; nothing in a clone that does not have it."""
    commit = (HERE / "upgraded_from").read_text(encoding="ascii").split()[0]
    return commit if git("cat-file", "-t", commit) == "commit" else None


def place_of_packages(commit):
    """Where its packages are kept, beside the compiler cache: what they are made of does not change."""
    cache = subprocess.run(["ccache", "--get-config", "cache_dir"], text=True, stdout=subprocess.PIPE, check=True, timeout=60).stdout.strip()
    return pathlib.Path(cache, f"packages-{git('rev-parse', commit)}")


def packages_before(commit, folder):
    """Its packages into `folder`."""
    kept = place_of_packages(commit)
    if not kept.exists():
        # Of those before it nobody looks at the debug symbols.
        run(REPOSITORY / "packaging/build", "--commit", commit, folder, env=dict(os.environ, DEB_BUILD_OPTIONS="noautodbgsym"))
        kept.parent.mkdir(parents=True, exist_ok=True)
        with tempfile.TemporaryDirectory(dir=kept.parent) as whole:
            copy = shutil.copytree(folder, pathlib.Path(whole, "packages"))
            with contextlib.suppress(OSError):  # another run was first
                copy.rename(kept)
    else:
        shutil.copytree(kept, folder)


def build(work, previous):
    """The packages of this commit and those before it."""
    run(REPOSITORY / "packaging/build", work / "new")
    before = commit_before()
    if before and (previous or place_of_packages(before).exists()):
        packages_before(before, work / "previous")
    else:
        why = "its packages are not kept here (run.py --previous)" if before else "is not in this clone"
        text = f"the commit of tests/packages/upgraded_from: {why}: upgraded from this one under a lower version"
        print(f"   {text}")
        machine.note(text)
        run(REPOSITORY / "packaging/build", "--suffix", "~before", work / "previous", env=dict(os.environ, DEB_BUILD_OPTIONS="noautodbgsym"))


def check(work):
    """lintian, without errors and warnings."""
    changes = next((work / "new").glob("*.changes"))
    run("lintian", "--allow-root", "--fail-on", "error,warning", "--tag-display-limit", "0", changes)


def make_repository(folder):
    """Lets apt take the packages of the folder for those of a maker named cansyncd."""
    index = subprocess.run(["dpkg-scanpackages", "."], cwd=folder, stdout=subprocess.PIPE, stderr=subprocess.DEVNULL, check=True, timeout=600).stdout
    (folder / "Packages").write_bytes(index)
    (folder / "Release").write_text(f"Origin: cansyncd\nSHA256:\n {hashlib.sha256(index).hexdigest()} {len(index)} Packages\n", encoding="ascii")


def lay_out(work):
    """What the fresh Debian gets besides Debian's: our packages, the new ones as a repository."""
    extra = work / "extra"
    for kind in ("new", "previous"):
        folder = extra / "srv/packages" / kind
        folder.mkdir(parents=True)
        for file in (work / kind).glob("*.deb"):
            if "-dbgsym_" not in file.name:
                shutil.copy(file, folder)
    make_repository(extra / "srv/packages/new")
    return extra


def install(work):
    """A fresh Debian with the packages installed by apt, as an archive that a kernel unpacks into its memory."""
    extra = lay_out(work)
    inside = (
        "apt-get install --yes --no-install-recommends /srv/packages/new/*.deb",
        # As the administrator does by docs/operations.md.
        "cp /usr/share/doc/cansyncd/examples/25-vcan0.* /etc/systemd/network/",
        "sed -e s/^Path=.*/OriginalName=vcan0/ -e /^Name=/d /usr/share/doc/cansyncd/examples/60-can-line1.link "
        ">/etc/systemd/network/20-vcan0.link",
        "systemctl enable systemd-networkd.service",
        "systemctl disable systemd-networkd-wait-online.service apt-daily.timer apt-daily-upgrade.timer unattended-upgrades.service "
        "prometheus-node-exporter.service",
        "systemctl mask systemd-binfmt.service e2scrub_reap.service",  # nothing for them in this kernel
        "systemctl mask serial-getty@ttyS0.service",  # the console shows the tests alone
        "systemctl enable cansync-proof.service",
        "echo cansync-proof >/etc/hostname",
    )
    run("mmdebstrap", "--variant=minbase", f"--include={','.join(DEBIAN)}", "--format=tar",
        "--aptopt=Acquire::Languages \"none\"", "--dpkgopt=force-unsafe-io",
        f"--customize-hook=copy-in {shlex.quote(f'{extra}/srv/packages')} /srv",
        f"--customize-hook=copy-in {shlex.quote(f'{HERE}/inside/cansync-proof.service')} /etc/systemd/system",
        *(f"--chrooted-customize-hook={command}" for command in inside), "bookworm", work / "root.tar",
        # No file is newer than the commit: the same packages are the same bytes.
        env=dict(os.environ, SOURCE_DATE_EPOCH=git("log", "-1", "--format=%ct")))
    run("bsdtar", "--format", "newc", "-cf", work / "root.part", f"@{work}/root.tar")
    (work / "root.tar").unlink()


def added(kernel, options):
    """What lies over the fresh Debian at each boot: the tests, what they share with those of tests/kernel, and the kernel's modules."""
    archive = memory_root.Archive()
    for path in (*sorted((HERE / "inside").glob("*.py")), *(REPOSITORY / "tests" / name for name in SHARED)):
        archive.add_file(path, f"proof/{path.name}")
    for name in ("lines", "gaps", "cuts", "upgrades"):
        if getattr(options, name) is not None:
            archive.add(f"proof/{name}", memory_root.FILE | 0o644, str(getattr(options, name)).encode())
    for number, module in enumerate(kernel.in_order(MODULES)):
        archive.add_file(module, f"modules/{number:03}-{os.path.basename(module)}")
    archive.add("init", memory_root.FILE | 0o755, START.encode())
    return archive.finish()


class Boot:
    """Boots what was installed, with systemd as the first process; as machine.in_courses asks for it."""

    name = "boot of the packages"

    def __init__(self, root, options):
        self.kernel = debian_kernel.fetch()
        self.archives = [root.read_bytes(), added(self.kernel, options)]
        self.began = time.monotonic()

    def show(self, line):
        print(f"{time.monotonic() - self.began:6.1f} {line}", flush=True)

    def __call__(self, seed):
        """The exit code of the tests inside; None: it did not end."""
        code = machine.boot(self.kernel, self.archives, MEMORY, LIMIT, self.show, seed)
        if code != 0:
            print(f"run.py: this course again: CANSYNC_SEED={seed} {shlex.join(sys.argv)}, with --keep FOLDER for the same packages")
        return code


def main():
    parser = argparse.ArgumentParser(description=__doc__.split("\n\n", 1)[0])
    parser.add_argument("--previous", action="store_true", help="build the packages that are upgraded, when they are not kept")
    parser.add_argument("--keep", type=pathlib.Path, help="folder that keeps packages and root file system")
    parser.add_argument("--install-only", action="store_true", help="end when the packages are installed, without a boot")
    parser.add_argument("--lines", type=int, help="lines made at random; 2 when it is not given")
    parser.add_argument("--gaps", type=int, help="times more that the adapter is gone; 4 when it is not given")
    parser.add_argument("--cuts", type=int, help="power cuts; 6 when it is not given")
    parser.add_argument("--upgrades", type=int, help="upgrades while a line runs; 1 when it is not given")
    options = parser.parse_args()
    with contextlib.ExitStack() as stack:
        if options.keep:
            work = options.keep.resolve()
            work.mkdir(parents=True, exist_ok=True)
        else:
            work = pathlib.Path(stack.enter_context(tempfile.TemporaryDirectory(prefix="cansync_packages_")))
        work.chmod(0o755)
        kept = f"root-{git('rev-parse', 'HEAD')}.cpio"
        if not (work / kept).exists():
            for left in (work / name for name in ("new", "previous", "extra")):
                shutil.rmtree(left, ignore_errors=True)
            for left in work.glob("root*"):
                left.unlink()
            with stage("build the packages of this commit; those before it"):
                build(work, options.previous)
            # Neither uses what the other makes.
            with stage("lintian; install them in a fresh Debian"), concurrent.futures.ThreadPoolExecutor() as threads:
                steps = [threads.submit(step, work) for step in (check, install)]
                for step in steps:
                    step.result()
            (work / "root.part").rename(work / kept)
        if options.install_only:
            return
        with stage("boot it and run the tests inside"):
            code = machine.in_courses(Boot(work / kept, options))
    if code is None:
        sys.exit(f"run.py: the machine ended without a result, or not within {LIMIT} s")
    sys.exit(code)


if __name__ == "__main__":
    signal.signal(signal.SIGTERM, lambda *_: sys.exit("run.py: stopped"))  # what it has laid down goes
    try:
        main()
    except debian_kernel.Missing as reason:
        print(f"run.py: cannot run: {reason}")
        sys.exit(SKIPPED)
