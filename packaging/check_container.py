#!/usr/bin/env python3
"""Carries out the steps of the Containerfile on a root that debootstrap makes, without Podman or Docker, and uses the program in it.

    packaging/check_container.py FOLDER

FOLDER is the context: it has the wheel of the program. Needs root, debootstrap, and Debian's mirror; where one of them is missing, or
namespaces, mounts or device files are not permitted, it prints a line that begins with SKIPPED, and ends with 0. The mirror is that
of COLUMN_TWIN_DEBIAN_MIRROR or of this machine's apt, else deb.debian.org. Every base image is a minimal Debian, which stays in the
user's cache. The steps run by chroot in a mount and process namespace of their own, so that nothing
stays mounted and nothing goes on running; the program runs as the image's user, with a network of its own that has nothing but
loopback: `--version`, `simulate`, `demo`, and a node that is hit, stopped, and started again with its damage. An instruction that
this file does not know is an error. What only a container engine can show, such as the layers of the image, it cannot show.
"""

from __future__ import annotations

import json
import os
import re
import shlex
import shutil
import signal
import subprocess
import sys
import tempfile
import threading
import time
import urllib.request
from dataclasses import dataclass, field
from pathlib import Path

CONTAINERFILE = Path(__file__).resolve().parent / "container" / "Containerfile"
SUITE, DEFAULT_MIRROR = "bookworm", "http://deb.debian.org/debian"
MIRROR = "COLUMN_TWIN_DEBIAN_MIRROR"
PATH = "/usr/local/sbin:/usr/local/bin:/usr/sbin:/usr/bin:/sbin:/bin"
PATIENCE = 120.0
# Set for the second start of this program, in namespaces of its own.
INSIDE = "COLUMN_TWIN_CHECKS_CONTAINER"
# As a container engine does, for RUN alone.
PROXIES = [name for it in ("http_proxy", "https_proxy", "no_proxy") for name in (it, it.upper()) if name in os.environ]


class Fault(Exception):
    """Something that is not as the Containerfile promises."""


class Unavailable(Exception):
    """Something that the check needs and this machine does not have; it says nothing about the Containerfile."""


def instructions(text: str) -> list[tuple[str, str]]:
    """Each instruction with its arguments; continued lines are one."""
    lines = [line for line in text.splitlines() if not line.lstrip().startswith("#")]
    joined = re.sub(r"\\\n\s*", "", "\n".join(lines))
    found = [line.strip().partition(" ")[::2] for line in joined.splitlines() if line.strip()]
    return [(name.upper(), rest.strip()) for name, rest in found]


@dataclass
class Stage:
    """A root folder with what the instructions so far have set for it."""

    root: Path
    environment: dict[str, str] = field(default_factory=lambda: {"PATH": PATH})
    user: str = "0:0"
    folder: str = "/"
    volumes: list[str] = field(default_factory=list)
    entry: list[str] = field(default_factory=list)
    command: list[str] = field(default_factory=list)

    def line(self, arguments: list[str], user: str | None = None) -> list[str]:
        """The command line that runs this in the root, as the user, in the folder of the image."""
        inside = f'cd {shlex.quote(self.folder)} && exec "$@"'
        return ["chroot", f"--userspec={user or self.user}", str(self.root), "/bin/sh", "-c", inside, "sh", *arguments]

    def run(self, arguments: list[str]) -> None:
        print(f"{self.root.name}: {shlex.join(arguments)}", flush=True)
        environment = {**{it: os.environ[it] for it in PROXIES}, **self.environment, "DEBIAN_FRONTEND": "noninteractive"}
        done = subprocess.run(self.line(arguments), env=environment, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True, check=False)
        if done.returncode != 0:
            raise Fault(f"{shlex.join(arguments)} ended with {done.returncode}:\n{done.stdout}")

    def program(self, *arguments: str) -> list[str]:
        """The command line of the entry point, on a network that has nothing but loopback."""
        return ["nsenter", f"--net=/proc/{os.getpid()}/fd/{os.environ[INSIDE]}", *self.line([*self.entry, *arguments])]

    def environment_of_program(self) -> dict[str, str]:
        return {**self.environment, "ROS_AUTOMATIC_DISCOVERY_RANGE": "LOCALHOST", "ROS_DOMAIN_ID": "0"}

    def output(self, *arguments: str) -> str:
        """What the program prints; it has to end with 0."""
        try:
            done = subprocess.run(self.program(*arguments), env=self.environment_of_program(), stdout=subprocess.PIPE, stderr=subprocess.STDOUT,
                                  text=True, check=False, timeout=PATIENCE)
        except subprocess.TimeoutExpired as late:
            # Bytes, in spite of text=True.
            shown = late.output.decode(errors="replace") if isinstance(late.output, bytes) else late.output
            raise Fault(f"column-twin {shlex.join(arguments)} did not end within {PATIENCE:g} s:\n{shown or ''}") from None
        if done.returncode != 0:
            raise Fault(f"column-twin {shlex.join(arguments)} ended with {done.returncode}:\n{done.stdout}")
        return done.stdout


def copy(arguments: str, stage: Stage, stages: dict[str, Stage], context: Path) -> None:
    """COPY, also from another stage. Folders give their content, files keep their names in a folder that ends in `/`."""
    words = shlex.split(arguments)
    source_root = context
    if words[0].startswith("--from="):
        source_root = stages[words.pop(0).removeprefix("--from=")].root
    *sources, target = words
    if any(it.startswith("--") for it in words):
        raise Fault(f"COPY {arguments}: expected no other option than --from")
    place = stage.root / target.lstrip("/")
    for source in sources:
        matches = sorted(source_root.glob(source.lstrip("/")))
        if not matches:
            raise Fault(f"COPY {arguments}: nothing matches {source} in {source_root}; build the wheel with crates/python/tests/wheels.sh build")
        for path in matches:
            if path.is_dir():
                shutil.copytree(path, place, symlinks=True, dirs_exist_ok=True)
            else:
                into = place / path.name if target.endswith("/") else place
                into.parent.mkdir(parents=True, exist_ok=True)
                shutil.copy2(path, into)


def prepare(root: Path) -> None:
    """Names are resolved, and packages fetched, as they are now and not as they were when the root was made."""
    # As in the images of Debian: nobody needs these files after a loss of power.
    (root / "etc/dpkg/dpkg.cfg.d/unsafe-io").write_text("force-unsafe-io\n")
    (root / "etc/apt/sources.list").write_text(f"deb {os.environ[MIRROR]} {SUITE} main\n")
    if Path("/etc/resolv.conf").exists():
        (root / "etc/resolv.conf").unlink(missing_ok=True)
        shutil.copyfile("/etc/resolv.conf", root / "etc/resolv.conf")


def built(context: Path, base: Path, folder: Path) -> Stage:
    """The last stage of the Containerfile."""
    stages: dict[str, Stage] = {}
    arguments: dict[str, str] = {}
    stage: Stage | None = None
    for name, rest in instructions(CONTAINERFILE.read_text()):
        if name == "ARG" and stage is None:
            key, _, value = rest.partition("=")
            arguments[key] = value
            continue
        if name == "FROM":
            image, _, alias = rest.partition(" AS ")
            # Whatever image it is, this one takes its place; but it has to be the caller's choice.
            if image.strip("${}") not in arguments:
                raise Fault(f"FROM {rest}: expected a base image that a build argument names")
            stage = Stage(folder / (alias or "image"))
            stages[alias or "image"] = stage
            subprocess.run(["cp", "-a", str(base), str(stage.root)], check=True)
            prepare(stage.root)
            for place, kind in (("proc", "proc"), ("dev/shm", "tmpfs")):
                (stage.root / place).mkdir(parents=True, exist_ok=True)
                subprocess.run(["mount", "-t", kind, kind, str(stage.root / place)], check=True)
            continue
        if stage is None:
            raise Fault(f"{name} {rest}: expected ARG or FROM first")
        match name:
            case "RUN":
                stage.run(["/bin/sh", "-c", rest])
            case "COPY":
                copy(rest, stage, stages, context)
            case "ENV":
                stage.environment |= dict(it.split("=", 1) for it in shlex.split(rest))
            case "USER":
                stage.user = rest
            case "WORKDIR":
                stage.folder = rest
            case "VOLUME":
                stage.volumes.append(rest)
            case "ENTRYPOINT":
                stage.entry = json.loads(rest)
            case "CMD":
                stage.command = json.loads(rest)
            case "LABEL":
                pass
            case _:
                raise Fault(f"{name} {rest}: packaging/check_container.py does not know this instruction; teach it")
    if stage is None:
        raise Fault(f"{CONTAINERFILE}: expected a stage, found none")
    return stage


def version_of(wheel: Path) -> str:
    return wheel.name.split("-")[1]


def expect(condition: bool, expected: str, found: object) -> None:
    if not condition:
        raise Fault(f"expected {expected}; found:\n{found}")


def node(image: Stage, hit: bool) -> str:
    """Starts a node with the image's own folders, hits its column if asked, stops it, and returns its log."""
    line = image.program("run", "--ros-args", "-p", "record.mode:=always", "-p", "real_time.priority:=0", "-p", "real_time.lock_memory:=false")
    process = subprocess.Popen(line, env=image.environment_of_program(), stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True)
    watchdog = threading.Timer(PATIENCE, process.kill)
    watchdog.start()
    log: list[str] = []
    fault: Fault | None = None
    try:
        assert process.stdout is not None
        for text in process.stdout:
            log.append(text)
            if "is ready in domain" in text:
                try:
                    if hit:
                        print(image.output("impact", "--mass", "1500", "--velocity", "10"), end="")
                except Fault as found:
                    fault = found
                process.send_signal(signal.SIGINT)
        code = process.wait()
    finally:
        watchdog.cancel()
        process.kill()
        process.wait()
    if fault is not None:
        raise Fault(f"{fault}\nThe node logged, and ended with {code}:\n{''.join(log)}")
    expect(code == 0, "exit code 0 of the node after SIGINT", f"{code}\n{''.join(log)}")
    return "".join(log)


def check(image: Stage, version: str) -> None:
    """Uses the program as the image's user."""
    expect(re.fullmatch(r"[1-9]\d*:[1-9]\d*", image.user) is not None, "a user and a group by number that are not root", image.user)
    state = Path(image.environment["XDG_STATE_HOME"]) / "column_twin"
    expect(image.volumes == [str(state)], f"a volume for {state}", image.volumes)
    shown = image.output("--version")
    expect(version in shown, f"version {version}", shown)
    expect("Usage" in image.output(*image.command), "the help without arguments", image.command)
    simulated = image.output("simulate", "--mass", "1500", "--velocity", "10")
    print(simulated[:400])
    owner = {path: path.lstat().st_uid for path in (image.root / "usr/local").rglob("*")}
    expect(set(owner.values()) == {0}, "a program that its user cannot change", [str(path) for path, of in owner.items() if of != 0][:5])
    components = list((image.root / "usr/local").rglob("*.dist-info/sboms/*.json"))
    licences = list((image.root / "usr/local").rglob("*.dist-info/licenses/**/LICENSE*"))
    expect(bool(components) and bool(licences), "the list of components and the licences of the wheel", [components, licences])
    print(image.output("demo", "-o", "/tmp/demo"))
    first = node(image, hit=True)
    expect(str(state) in first, f"a log that names {state}", first)
    inside = image.root / str(state).lstrip("/")
    saved = list(inside.glob("state/*.json"))
    expect(len(saved) == 1 and len(list(inside.glob("recordings/*"))) == 1, f"the damage and a recording in {state}", list(inside.rglob("*")))
    again = node(image, hit=False)
    expect("restored" in again, "the damage restored by a second container", again)


def check_machine() -> None:
    """What the steps need is tried, because root has it on one machine and not in a container on another."""
    if os.geteuid() != 0:
        raise Unavailable(f"only root can change into a root folder; found user {os.geteuid()}")
    missing = [it for it in ("debootstrap", "unshare", "nsenter", "chroot", "mount", "mknod", "ip") if not shutil.which(it)]
    if missing:
        raise Unavailable(f"this machine lacks {', '.join(missing)}; on Debian: apt-get install debootstrap iproute2 util-linux")
    with tempfile.TemporaryDirectory() as folder:
        # The device file stands where those of the stages will: a file system can forbid their use.
        attempt = 'ip link set lo up; mknod "$1/null" c 1 3; echo >"$1/null"; mkdir "$1/m"; mount -t tmpfs tmpfs "$1/m"; chroot / true'
        line = ["unshare", "--mount", "--pid", "--net", "--fork", "--mount-proc", "sh", "-ec", attempt, "sh", folder]
        done = subprocess.run(line, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True, check=False)
    if done.returncode != 0:
        raise Unavailable(f"namespaces, mounts, device files or chroot are not permitted here: {done.stdout.strip() or done.returncode}")


def is_mirror(address: str) -> bool:
    """Whether packages of the suite come from there."""
    try:
        with urllib.request.urlopen(f"{address}/dists/{SUITE}/InRelease", timeout=20) as answer:
            return b"\nOrigin: Debian\n" in answer.read(2000)
    except (OSError, ValueError):
        return False


def mirror() -> str:
    """The mirror from which this machine takes its own packages, if it has Debian's, else the usual one."""
    folder = Path("/etc/apt")
    files = [folder / "sources.list", *sorted(folder.glob("sources.list.d/*.list")), *sorted(folder.glob("sources.list.d/*.sources"))]
    # Not by HTTPS: a minimal Debian has no certificates. Not the archive of security updates, whose address ends otherwise.
    found = [it for file in files if file.is_file()
             for it in re.findall(r"^(?:deb |URIs:)[^#\n]*?(http://\S+/debian)/?(?=\s|$)", file.read_text(errors="replace"), re.MULTILINE)]
    wanted = [os.environ[MIRROR]] if os.environ.get(MIRROR) else list(dict.fromkeys([*found, DEFAULT_MIRROR]))
    for address in wanted:
        if is_mirror(address):
            return address
    raise Unavailable(f"no mirror of Debian {SUITE} can be reached: {', '.join(wanted)}")


def minimal_root() -> Path:
    """A minimal Debian in the user's cache."""
    cache = Path(os.environ.get("XDG_CACHE_HOME") or Path.home() / ".cache") / "column_twin"
    root = cache / f"debian-{SUITE}"
    if not root.is_dir():
        cache.mkdir(parents=True, exist_ok=True)
        partial = Path(tempfile.mkdtemp(dir=cache))
        try:
            line = ["debootstrap", "--variant=minbase", SUITE, str(partial / "root"), os.environ[MIRROR]]
            done = subprocess.run(line, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True, check=False)
            if done.returncode != 0:
                log = partial / "root/debootstrap/debootstrap.log"
                print(done.stdout, *(log.read_text(errors="replace").splitlines()[-30:] if log.is_file() else []), sep="\n")
                raise Unavailable(f"{shlex.join(line)} ended with {done.returncode}; what it printed is above")
            (partial / "root").rename(root)
        finally:
            shutil.rmtree(partial, ignore_errors=True)
    return root


def in_own_namespaces(arguments: list[str]) -> int:
    """Starts this program again where its mounts and processes end with it, beside a network that has nothing but loopback."""
    network = subprocess.Popen(["unshare", "--net", "sh", "-c", "ip link set lo up && echo up && exec sleep infinity"], stdout=subprocess.PIPE)
    try:
        assert network.stdout is not None
        if network.stdout.readline() != b"up\n":
            raise Fault("cannot make a network namespace: run this as root, with iproute2 installed")
        # By a file that stays open: the number of the process means nothing in another process namespace.
        with open(f"/proc/{network.pid}/ns/net", "rb") as handle:
            environment = {**os.environ, INSIDE: str(handle.fileno())}
            return subprocess.run(["unshare", "--mount", "--pid", "--fork", "--mount-proc", "--kill-child", sys.executable, __file__, *arguments],
                                  env=environment, pass_fds=[handle.fileno()], check=False).returncode
    finally:
        network.kill()
        network.wait()


def main() -> int:
    if len(sys.argv) != 2:
        print(__doc__)
        return 2
    context = Path(sys.argv[1]).resolve()
    wheels = sorted(context.glob("column_twin_program-*.whl"))
    if len(wheels) != 1:
        print(f"expected one wheel of the program in {context}; found {len(wheels)}: crates/python/tests/wheels.sh build")
        return 2
    start = time.monotonic()
    try:
        if INSIDE not in os.environ:
            check_machine()
            os.environ[MIRROR] = mirror()
            minimal_root()
            return in_own_namespaces(sys.argv[1:])
        with tempfile.TemporaryDirectory() as folder:
            try:
                check(built(context, minimal_root(), Path(folder)), version_of(wheels[0]))
            finally:
                # Unmount first, so that removing the folder does not remove mounted files.
                for mount in sorted(Path("/proc/mounts").read_text().split(), reverse=True):
                    if mount.startswith(f"{folder}/"):
                        subprocess.run(["umount", "--lazy", mount], check=True)
    except Fault as fault:
        print(f"{CONTAINERFILE.name}: {fault}")
        return 1
    except Unavailable as reason:
        print(f"SKIPPED: the container image was not checked: {reason}")
        return 0
    print("the steps of the Containerfile make an image whose program runs, as its user, and keeps its damage: "
          f"{time.monotonic() - start:.0f} s from {os.environ[MIRROR]}")
    return 0


if __name__ == "__main__":
    sys.exit(main())
