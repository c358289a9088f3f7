"""Builds the Debian packages, installs them with apt in a fresh Debian, boots that under user-mode-linux with systemd as
its first process, and runs the tests of the folder `inside` in it.

    run.py [--keep FOLDER] [--lines N]     FOLDER keeps packages and root file system, to look at them, and is taken up
                                           again as it is; N lines made at random are set up, 2 when it is not given

Needs the packages of tools/packages.txt and a Debian mirror; no rights. Exit code: 0 all well, 1 something is wrong.
"""

import argparse
import concurrent.futures
import contextlib
import os
import pathlib
import shutil
import signal
import subprocess
import sys
import tempfile
import time

HERE = pathlib.Path(__file__).resolve().parent
REPOSITORY = HERE.parent.parent
sys.path.insert(0, str(REPOSITORY / "tests/uml"))
import run_uml  # noqa: E402  (its folder is named above)

COMMAND_LIMIT = 7200  # seconds; one step: building on a busy machine takes the longest
LIMIT = int(os.environ.get("CANSYNC_UML_LIMIT", "900"))  # seconds from power-on to power-off; two minutes are usual
BOOTS = 2  # what is wrong fails again; what a busy machine has held up for too long does not; tools/test ends with it
MEMORY = 640  # MiB
IMAGE = 2048  # MiB, sparse
# What a gateway PC has, and what the tests look with.
DEBIAN = ("systemd", "systemd-sysv", "udev", "dbus", "iproute2", "kmod", "procps", "util-linux", "man-db", "python3",
          "bash-completion", "needrestart", "polkitd")
SHARED = ("kernel/unknown_line.py", "kernel/random_line.py", "kernel/canline.py", "end_to_end/gateway.py",
          "end_to_end/json_schemas.py", "end_to_end/wording.py")
MODULES = ("kernel/net/can", "kernel/drivers/net/can", "kernel/fs/autofs", "modules.order", "modules.builtin",
           "modules.builtin.modinfo")


def run(*command, **options):
    """Runs a command; its output only when it fails."""
    done = subprocess.run([str(part) for part in command], text=True, stdout=subprocess.PIPE, stderr=subprocess.STDOUT,
                          check=False, timeout=COMMAND_LIMIT, **options)
    if done.returncode != 0:
        sys.exit(f"run.py: {' '.join(map(str, command))}: exit code {done.returncode}\n{done.stdout[-6000:]}")
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
    """The newest release before this commit, else its parent; nothing when neither can be packaged."""
    for commit in (git("describe", "--tags", "--abbrev=0", "--match=v*", "HEAD~1"), "HEAD~1"):
        if commit and git("ls-tree", "-d", commit, "packaging/debian"):
            return commit
    return None


def build(work):
    """The packages of this commit and those before it."""
    run(REPOSITORY / "packaging/build", work / "new")
    # Of those before it nobody looks at the debug symbols.
    quick = dict(os.environ, DEB_BUILD_OPTIONS="noautodbgsym")
    before = commit_before()
    if before:
        run(REPOSITORY / "packaging/build", "--commit", before, work / "previous", env=quick)
    else:
        print("   no earlier commit with packages here; upgrading from this one under a lower version")
        run(REPOSITORY / "packaging/build", "--suffix", "~before", work / "previous", env=quick)


def check(work):
    """lintian, without errors and warnings."""
    changes = next((work / "new").glob("*.changes"))
    run("lintian", "--allow-root", "--fail-on", "error,warning", "--tag-display-limit", "0", changes)


def find_modules():
    """Debian's modules of the kernel we boot."""
    folders = sorted(pathlib.Path("/usr/lib/uml/modules").glob("*"))
    if not folders:
        run_uml.skip("no modules in /usr/lib/uml/modules; the package user-mode-linux has them")
    return folders[-1]


def lay_out(work):
    """What the fresh Debian gets besides Debian's: our packages, and the kernel's modules."""
    extra = work / "extra"
    for kind in ("new", "previous"):
        folder = extra / "srv/packages" / kind
        folder.mkdir(parents=True)
        for file in (work / kind).glob("*.deb"):
            if "-dbgsym_" not in file.name:
                shutil.copy(file, folder)
    modules = find_modules()
    target = extra / "usr/lib/modules" / modules.name
    for name in MODULES:
        if (modules / name).is_dir():
            shutil.copytree(modules / name, target / name)
        else:
            target.mkdir(parents=True, exist_ok=True)
            shutil.copy(modules / name, target)
    return extra, modules.name


def install(work):
    """A fresh Debian with the packages installed by apt, as a file system image."""
    extra, release = lay_out(work)
    inside = (
        f"depmod {release}",
        "apt-get install --yes --no-install-recommends /srv/packages/new/*.deb",
        # As the administrator does by docs/operations.md.
        "cp /usr/share/doc/cansyncd/examples/25-vcan0.* /etc/systemd/network/",
        "sed -e s/^Path=.*/OriginalName=vcan0/ -e /^Name=/d /usr/share/doc/cansyncd/examples/60-can-line1.link "
        ">/etc/systemd/network/20-vcan0.link",
        "systemctl enable systemd-networkd.service",
        "systemctl disable systemd-networkd-wait-online.service apt-daily.timer apt-daily-upgrade.timer",
        "systemctl mask systemd-binfmt.service e2scrub_reap.service",  # nothing for them in this kernel
        "systemctl enable cansync-proof.service",
        "echo cansync-proof >/etc/hostname",
        f"mkdir /out; echo 'none /out hostfs {work}/out 0 0' >>/etc/fstab",
    )
    run("mmdebstrap", "--variant=minbase", f"--include={','.join(DEBIAN)}", "--format=tar",
        "--aptopt=Acquire::Languages \"none\"", "--dpkgopt=force-unsafe-io",
        f"--customize-hook=copy-in {extra}/srv/packages /srv",
        f"--customize-hook=copy-in {HERE}/inside/cansync-proof.service /etc/systemd/system",
        f"--customize-hook=copy-in {extra}/usr/lib/modules /usr/lib",
        *(f"--chrooted-customize-hook={command}" for command in inside), "bookworm", work / "root.tar")
    run("fakeroot", "sh", "-ec", "mkdir root; tar -xf root.tar -C root; truncate -s {0}M root.img; "
        "mke2fs -q -t ext4 -O ^has_journal -d root root.img; rm -rf root root.tar".format(IMAGE), cwd=work)


def lay_out_proof(proof, lines):
    """The tests for inside, and what they share with those of user-mode-linux."""
    shutil.copytree(HERE / "inside", proof, ignore=shutil.ignore_patterns("__pycache__"))
    for name in SHARED:
        shutil.copy(REPOSITORY / "tests" / name, proof)
    if lines:
        (proof / "lines").write_text(str(lines), encoding="ascii")


def boot(work, number, lines):
    """Boots the image, as it was installed, with systemd as the first process. The exit code of the tests inside."""
    out = work / "out"
    if out.exists():
        out.rename(work / f"out-{number - 1}")
    out.mkdir()
    lay_out_proof(out / "proof", lines)
    kernel = run_uml.find_program("linux.uml")
    command = [kernel, f"mem={MEMORY}M", f"ubda={work}/boot-{number}.cow,{work}/root.img", "root=/dev/ubda", "rw", "quiet",
               "con=null", "con0=null,fd:1", "ssl=null", f"uml_dir={work}/uml/", "umid=cansync",
               "init=/lib/systemd/systemd", "systemd.show_status=0"]
    registers = work / "uml_registers.so"  # that kernel does not know those of newer processors
    run("cc", "-shared", "-fPIC", "-O1", "-o", registers, REPOSITORY / "tests/uml/uml_registers.c")
    environment = dict(os.environ, TMPDIR=run_uml.memory_folder(), LD_PRELOAD=str(registers))
    process = subprocess.Popen(command, stdin=subprocess.DEVNULL, env=environment, start_new_session=True,
                               preexec_fn=run_uml.prefer)
    try:
        process.wait(LIMIT)
    except subprocess.TimeoutExpired:
        print(f"run.py: not done after {LIMIT} s, killed")
    finally:
        with contextlib.suppress(ProcessLookupError):
            os.killpg(process.pid, signal.SIGKILL)
        process.wait(60)  # after SIGKILL
    try:
        return int((out / "exit_code").read_text(encoding="ascii"))
    except (OSError, ValueError):
        print("run.py: the machine ended without a result")
        return 1


def tell_repeated(what):
    """For the last line of tools/test."""
    if path := os.environ.get("CANSYNC_REPEATED"):
        with open(path, "a", encoding="utf-8") as file:
            print(what, file=file)


def main():
    parser = argparse.ArgumentParser(description=__doc__.split("\n\n", 1)[0])
    parser.add_argument("--keep", type=pathlib.Path, help="folder that keeps packages and root file system")
    parser.add_argument("--lines", type=int, help="lines made at random; 2 when it is not given")
    options = parser.parse_args()
    with contextlib.ExitStack() as stack:
        if options.keep:
            work = options.keep.resolve()
            work.mkdir(parents=True, exist_ok=True)
            for old in (*work.glob("boot-*.cow"), *work.glob("out*")):
                shutil.rmtree(old) if old.is_dir() else old.unlink()
        else:
            work = pathlib.Path(stack.enter_context(tempfile.TemporaryDirectory(prefix="cansync_packages_")))
        work.chmod(0o755)
        if not (work / "root.img").exists():
            with stage("build the packages of this commit and of the one before"):
                build(work)
            # Neither uses what the other makes.
            with stage("lintian; install them in a fresh Debian"), concurrent.futures.ThreadPoolExecutor() as threads:
                steps = [threads.submit(step, work) for step in (check, install)]
                for step in steps:
                    step.result()
        for number in range(1, BOOTS + 1):
            with stage("boot it and run the tests inside"):
                code = boot(work, number, options.lines)
            if code == 0:
                if number > 1:
                    tell_repeated("the tests of the packages inside the booted machine")
                break
    sys.exit(code)


if __name__ == "__main__":
    main()
