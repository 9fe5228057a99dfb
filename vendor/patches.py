#!/usr/bin/env python3
"""The corrections of the vendored crates, one patch each, against the crates as they were published.

    vendor/patches.py check           # the published crates with all patches are the vendored ones, byte for byte
    vendor/patches.py unpack FOLDER   # each crate as a git repository, one commit for each patch, to work on the corrections
    vendor/patches.py pack FOLDER     # the vendored crates and the patches from these repositories

vendor/patches/CRATE holds the patches in their order, and `left_out`, the files of the published crate that are not vendored. A patch
begins with its description: a title, an empty line, and what is wrong, how it shows and what the patch does. `git apply` and `patch -p1`
read it as it is. Needs git, and cargo for the published crates, which it looks for in its registry before it downloads them.
"""

import os
import re
import shutil
import subprocess
import sys
import tarfile
import tempfile
from pathlib import Path

VENDOR = Path(__file__).resolve().parent
PATCHES = VENDOR / "patches"

# The names of the vendored crates, which are those of their folders, with the versions that the corrections are for.
CRATES = {"rustdds": "0.15.1", "ros2-client": "0.12.1"}

# Between the description of a patch and its changes.
SEPARATOR = "---\n"

# What stands before the published crate in a repository of `unpack`.
PUBLISHED = "The crate as it was published"


class Fault(Exception):
    """What is wrong, and what to do about it."""


def git(folder, *arguments, text=None):
    # Neither the settings of the user nor those of the machine change what git writes.
    environment = os.environ | {"GIT_CONFIG_GLOBAL": os.devnull, "GIT_CONFIG_SYSTEM": os.devnull, "GIT_CEILING_DIRECTORIES": str(folder.parent)}
    identity = ["-c", "user.name=column_twin", "-c", "user.email=", "-c", "core.autocrlf=false", "-c", "commit.gpgsign=false"]
    done = subprocess.run(["git", "-C", folder, *identity, *arguments], input=text, capture_output=True, text=True, env=environment)
    if done.returncode != 0:
        raise Fault(f"git {arguments[0]} failed in {folder}:\n{done.stderr.strip()}")
    return done.stdout


def cargo(*arguments, folder=None):
    done = subprocess.run(["cargo", *arguments], capture_output=True, text=True, cwd=folder)
    if done.returncode != 0:
        raise Fault(f"cargo {arguments[0]} failed:\n{done.stderr.strip()}")
    return done.stdout


def archive(crate):
    """The published crate as cargo keeps it."""
    home = Path(os.environ.get("CARGO_HOME", Path.home() / ".cargo"))
    name = f"{crate}-{CRATES[crate]}.crate"
    find = lambda: next(home.glob(f"registry/cache/*/{name}"), None)
    if find() is None:
        with tempfile.TemporaryDirectory() as folder:
            manifest = Path(folder, "Cargo.toml")
            manifest.write_text(f'[package]\nname = "download"\n[dependencies]\n{crate} = "={CRATES[crate]}"\n[workspace]\n')
            Path(folder, "src").mkdir()
            Path(folder, "src/lib.rs").touch()
            cargo("fetch", "--quiet", "--target", "x86_64-unknown-linux-gnu", "--manifest-path", str(manifest))
    found = find()
    if found is None:
        raise Fault(f"expected {name} in {home}/registry/cache after cargo fetch; found none")
    return found


def files_of(folder):
    """The files below a folder by their paths, with their content; the repository of `unpack` is not among them."""
    paths = (path for path in folder.rglob("*") if path.is_file() and path.relative_to(folder).parts[0] != ".git")
    return {str(path.relative_to(folder)): path.read_bytes() for path in paths}


def published(crate, folder):
    """Writes the published crate into an empty folder, without what is left out."""
    with tempfile.TemporaryDirectory() as unpacked:
        with tarfile.open(archive(crate)) as crate_file:
            crate_file.extractall(unpacked, filter="data")
        shutil.copytree(Path(unpacked, f"{crate}-{CRATES[crate]}"), folder, dirs_exist_ok=True)
    for line in (PATCHES / crate / "left_out").read_text().splitlines():
        path = folder / line
        if path.is_dir():
            shutil.rmtree(path)
        elif path.is_file():
            path.unlink()
        else:
            raise Fault(f"vendor/patches/{crate}/left_out names {line}, which {crate} {CRATES[crate]} does not have; remove the line")


def patches_of(crate):
    return sorted((PATCHES / crate).glob("*.patch"))


def description_of(patch):
    text = patch.read_text()
    description, separator, changes = text.partition("\n" + SEPARATOR)
    title, gap, body = description.partition("\n\n")
    if not (separator and changes.startswith("diff --git ") and gap and body.strip() and "\n" not in title):
        raise Fault(f"{patch}: expected a title, an empty line, a description, a line `---`, and changes")
    return description + "\n"


def apply(patch, folder):
    description_of(patch)
    try:
        git(folder, "apply", "--index", "--whitespace=nowarn", str(patch))
    except Fault as fault:
        raise Fault(f"{patch.relative_to(VENDOR.parent)} does not apply after those before it: {fault}") from fault


def repository(crate, folder):
    """A repository of the published crate, with a commit for each patch."""
    folder.mkdir(parents=True)
    published(crate, folder)
    git(folder, "init", "--quiet", "--initial-branch", "corrections")
    git(folder, "add", "--all", "--force")
    git(folder, "commit", "--quiet", "--message", PUBLISHED)
    for patch in patches_of(crate):
        apply(patch, folder)
        git(folder, "commit", "--quiet", "--file", "-", text=description_of(patch))


def check():
    faults = []
    for crate, version in CRATES.items():
        with tempfile.TemporaryDirectory() as folder:
            patched = Path(folder, crate)
            repository(crate, patched)
            expected, found = files_of(patched), files_of(VENDOR / crate)
        for path in sorted(expected.keys() | found.keys()):
            if expected.get(path) != found.get(path):
                faults.append(
                    f"vendor/{crate}/{path} differs from {crate} {version} with all patches"
                    if path in expected and path in found
                    else f"vendor/{crate}/{path} is {'missing' if path in expected else 'neither published nor made by a patch'}"
                )
        print(f"{crate} {version} with {len(patches_of(crate))} patches: {len(found)} files compared")
        # In a folder of its own, where no Cargo.lock names an older version.
        with tempfile.TemporaryDirectory() as elsewhere:
            newest = re.search(r"^version: (\S+)", cargo("info", "--quiet", crate, folder=elsewhere), re.MULTILINE)
        if newest is None:
            raise Fault(f"expected a line `version: ...` of cargo info {crate}; found none")
        if newest[1] != version:
            print(f"{crate} {newest[1]} has been published: look which corrections it has, and vendor it with the others")
    if faults:
        raise Fault("\n".join([*faults, "change the corrections with vendor/patches.py unpack and pack"]))


def unpack(folder):
    for crate in CRATES:
        if (folder / crate).exists():
            raise Fault(f"{folder / crate} exists; choose another folder")
        repository(crate, folder / crate)
        print(f"{folder / crate}: change its commits with git rebase --interactive, then run: vendor/patches.py pack {folder}")


def file_name(number, title):
    words = re.findall(r"[a-z0-9_]+", title.lower().replace("'", ""))
    return f"{number:02}_{'_'.join(words)}.patch"


def pack(folder):
    for crate in CRATES:
        source = folder / crate
        if git(source, "status", "--porcelain"):
            raise Fault(f"{source} has changes that are not committed; commit them")
        first, *corrections = git(source, "rev-list", "--reverse", "HEAD").split()
        if git(source, "log", "-1", "--format=%s", first).strip() != PUBLISHED:
            raise Fault(f"{source} does not begin with the published crate; make it with: vendor/patches.py unpack FOLDER")
        for patch in patches_of(crate):
            patch.unlink()
        for number, commit in enumerate(corrections):
            description = git(source, "log", "-1", "--format=%B", commit).strip("\n")
            changes = git(source, "diff", "--no-color", "--no-ext-diff", "--diff-algorithm=histogram", f"{commit}~", commit)
            # The hashes of blobs say nothing here, and their length depends on the repository.
            changes = re.sub(r"^index [0-9a-f]+\.\.[0-9a-f]+.*\n", "", changes, flags=re.MULTILINE)
            patch = PATCHES / crate / file_name(number, description.splitlines()[0])
            patch.write_text(f"{description}\n{SEPARATOR}{changes}")
            description_of(patch)
        shutil.rmtree(VENDOR / crate)
        for path, content in files_of(source).items():
            target = VENDOR / crate / path
            target.parent.mkdir(parents=True, exist_ok=True)
            target.write_bytes(content)
        print(f"{crate}: {len(corrections)} patches")


def main():
    match sys.argv[1:]:
        case ["check"]:
            check()
        case ["unpack", folder]:
            unpack(Path(folder).resolve())
        case ["pack", folder]:
            pack(Path(folder).resolve())
        case _:
            raise Fault(__doc__.strip())


if __name__ == "__main__":
    try:
        main()
    except Fault as fault:
        sys.exit(str(fault))
