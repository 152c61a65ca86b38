#!/usr/bin/env python3
# SPDX-License-Identifier: MIT
"""Plants mistakes in copies of the sources, one at a time, and names those that no test of their room finds.

usage: run.py --check | run.py FOLDER [ROOM...]

Records are in rooms/ROOM.txt:

    in lib/light kernels/light
    green-only specular gets no lobe
        - specular[1] > 0.0F
        + specular[1] > 1.0F
        test golden_pins light

A line that begins with "in" names the folders or files whose text the records after it change; those that are not
there are left out, as long as one is. A record is a name, a piece of text that occurs exactly once in them, what takes
its place, and the tests, of which one must fail: programs of the build with their arguments; --gpu-path, as the last
of them, runs it by the kernels for GPUs. In a text, \\n is the end of a line. Where the text of a record is not found,
or found again, the run ends with an error, so that no record outlives the code that it is about.

--check reads the records alone, without a build. FOLDER holds the copy and its build; a second run there is quicker.
"""

import os
import re
import shutil
import subprocess
import sys
import threading
import time
from dataclasses import dataclass, field
from pathlib import Path

HERE = Path(__file__).resolve().parent
ROOT = HERE.parent.parent
ROOMS_LEAST = 8  # records of a room
SUFFIXES = {".c", ".h", ".cl", ".clh", ".cpp"}
TEST_SECONDS = 400  # a mistake may make a test hang
PINS = "golden_pins"  # ends at its first difference
GPU_PATH = "--gpu-path"
# Where a kernel or a shader does not compile, any test fails.
NO_MISTAKE = ("SVO_COMPILE_FAILED", "does not compile")


class WrongRecord(Exception):
    """A record that cannot be planted."""


@dataclass
class Mutant:
    """A mistake: a line of text, what takes its place, and the tests of which one must fail."""

    room: str
    name: str
    places: list[str]
    line: int
    old: str = ""
    new: str = ""
    tests: list[list[str]] = field(default_factory=list)

    def fail(self, why: str) -> WrongRecord:
        return WrongRecord(f"tests/mutants/rooms/{self.room}.txt:{self.line}: {self.name}: {why}")

    def find(self, root: Path) -> Path:
        """The one file that has the text, once."""
        found = []
        for path in files_of(root, self.places):
            found += [path] * path.read_text(encoding="utf-8").count(self.old)
        if len(found) != 1:
            raise self.fail(f"the text occurs {len(found)} times in {' '.join(self.places)}")
        return found[0]


def files_of(root: Path, places: list[str]) -> list[Path]:
    files = []
    for place in places:
        path = root / place
        if path.is_dir():
            files += sorted(p for p in path.rglob("*") if p.suffix in SUFFIXES)
        elif path.is_file():
            files.append(path)
    return files


def read_room(path: Path) -> list[Mutant]:
    mutants: list[Mutant] = []
    places: list[str] = []
    for number, text in enumerate(path.read_text(encoding="utf-8").splitlines(), 1):
        words = text.split()
        if not words or text.startswith("#"):
            continue
        if text.startswith("in "):
            places = words[1:]
        elif not text.startswith(" "):
            mutants.append(Mutant(path.stem, text, places, number))
        elif words[0] in ("-", "+"):
            setattr(mutants[-1], "old" if words[0] == "-" else "new", text.strip()[1:].strip().replace("\\n", "\n"))
        elif words[0] == "test":
            mutants[-1].tests.append(words[1:])
        else:
            raise WrongRecord(f"{path}:{number}: '{words[0]}' is none of in, -, + and test")
    return mutants


def known_programs() -> set[str]:
    """The programs of tests, as their CMakeLists.txt name them."""
    texts = [path.read_text(encoding="utf-8") for path in (ROOT / "tests").rglob("CMakeLists.txt")]
    return {name for text in texts for name in re.findall(r"svocl_test\((\w+)", text)}


def read_records() -> list[Mutant]:
    """All records, each with its text in the sources and with tests that there are."""
    programs = known_programs()
    mutants = []
    wrong = []
    for path in sorted(HERE.glob("rooms/*.txt")):
        room = read_room(path)
        if len(room) < ROOMS_LEAST:
            wrong.append(f"{path.name}: {len(room)} records are below {ROOMS_LEAST}")
        mutants += room
    for mutant in mutants:
        try:
            if not mutant.old or not mutant.tests or mutant.old == mutant.new:
                raise mutant.fail("a record has a line of text, another one in its place, and a test")
            mutant.find(ROOT)
            for test in mutant.tests:
                if test[0] not in programs:
                    raise mutant.fail(f"there is no test {test[0]}")
        except WrongRecord as why:
            wrong.append(str(why))
    if wrong:
        raise WrongRecord("\n".join(wrong))
    return mutants


class Copy:
    """A copy of the sources and its build."""

    def __init__(self, folder: Path) -> None:
        self.source = folder / "source"
        self.build = folder / "build"
        self.log = folder / "build.log"
        self.environment = dict(os.environ)
        # Most of the time would go into optimizing kernels that run once.
        self.environment["POCL_EXTRA_BUILD_FLAGS"] = "-cl-opt-disable"
        self.environment["POCL_CACHE_DIR"] = str(folder / "kernels")
        folder.mkdir(parents=True, exist_ok=True)
        (folder / "kernels").mkdir(exist_ok=True)

    def refresh(self) -> None:
        """Copies what differs, so that only that is compiled again, and removes what is gone."""
        listed = subprocess.run(
            ["git", "ls-files", "-z", "--cached", "--others", "--exclude-standard"],
            cwd=ROOT,
            check=True,
            stdout=subprocess.PIPE,
            text=True,
        ).stdout
        names = {name for name in listed.split("\0") if name and (ROOT / name).is_file()}
        for name in names:
            old, new = ROOT / name, self.source / name
            if not new.exists() or old.read_bytes() != new.read_bytes():
                new.parent.mkdir(parents=True, exist_ok=True)
                shutil.copy(old, new)
        for path in [p for p in self.source.rglob("*") if p.is_file()]:
            if str(path.relative_to(self.source)) not in names:
                path.unlink()

    def command(self, *words: str) -> bool:
        with self.log.open("w", encoding="utf-8") as log:
            return subprocess.run(words, stdout=log, stderr=subprocess.STDOUT, check=False).returncode == 0

    def configure(self) -> None:
        if (self.build / "build.ninja").exists():
            return
        options = ["-G", "Ninja", "-DCMAKE_BUILD_TYPE=Release", "-DSVOCL_TESTS=ON", "-DSVOCL_SAMPLES=OFF"]
        if not self.command("cmake", "-S", str(self.source), "-B", str(self.build), *options):
            sys.exit(self.log.read_text(encoding="utf-8"))

    def compile(self, programs: set[str]) -> bool:
        return self.command("cmake", "--build", str(self.build), "--target", *sorted(programs))

    def run(self, test: list[str]) -> tuple[bool, str]:
        """Whether a test passes, and what it printed until its first failure."""
        found = [p for p in (self.build / "tests").rglob(test[0]) if p.is_file() and os.access(p, os.X_OK)]
        if not found:
            sys.exit(f"run.py: the build has no program {test[0]}")
        program = max(found, key=lambda path: path.stat().st_mtime)  # an older one is where it stood once
        first = ["--first"] if test[0] == PINS else []
        path = {"SVOCL_TEST_PATH": "gpu"} if test[-1] == GPU_PATH else {}
        printed = []
        with subprocess.Popen(
            [str(program), *first, *(word for word in test[1:] if word != GPU_PATH)],
            env=self.environment | path,
            stdout=subprocess.PIPE,
            stderr=subprocess.STDOUT,
            text=True,
            errors="replace",
        ) as process:
            assert process.stdout is not None
            limit = threading.Timer(TEST_SECONDS, process.kill)
            limit.start()
            for line in process.stdout:
                printed.append(line)
                if "[  FAILED  ]" in line:
                    process.kill()
                    break
            process.wait()
            limit.cancel()
        return process.returncode == 0, "".join(printed)


class Planter:
    """Plants mistakes in a copy, and knows which tests pass without one."""

    def __init__(self, copy: Copy) -> None:
        self.copy = copy
        self.sound: set[tuple[str, ...]] = set()

    def passes(self, mutant: Mutant, test: list[str]) -> tuple[bool, str]:
        if not self.copy.compile({test[0]}):
            raise mutant.fail(f"it does not compile:\n{self.copy.log.read_text(encoding='utf-8')[-2000:]}")
        return self.copy.run(test)

    def check_sound(self, mutant: Mutant, test: list[str]) -> None:
        """Without a mistake each test passes."""
        if tuple(test) not in self.sound:
            passed, printed = self.passes(mutant, test)
            if not passed or "Running 0 test(s)" in printed:
                sys.exit(f"{printed[-4000:]}\nrun.py: {' '.join(test)} fails without a mistake, or has no case")
            self.sound.add(tuple(test))

    def finds(self, mutant: Mutant, test: list[str]) -> bool:
        """Whether a test finds the mistake, which is gone afterwards."""
        self.check_sound(mutant, test)
        path = mutant.find(self.copy.source)
        text = path.read_text(encoding="utf-8")
        path.write_text(text.replace(mutant.old, mutant.new), encoding="utf-8")
        try:
            passed, printed = self.passes(mutant, test)
            if not passed and any(sign in printed for sign in NO_MISTAKE):
                raise mutant.fail(f"a kernel does not compile:\n{printed[-2000:]}")
            return not passed
        finally:
            path.write_text(text, encoding="utf-8")

    def judge(self, mutant: Mutant) -> str:
        """Plants a mistake and prints what became of it."""
        begin = time.monotonic()
        why = ""
        try:
            verdict = "found" if any(self.finds(mutant, test) for test in mutant.tests) else "ALIVE"
        except WrongRecord as wrong:
            verdict, why = "WRONG", f"\n{wrong}"
        print(f"{verdict}  {time.monotonic() - begin:5.1f} s  {mutant.room}: {mutant.name}{why}", flush=True)
        return verdict


def main() -> int:
    arguments = sys.argv[1:]
    try:
        mutants = read_records()
        if arguments == ["--check"]:
            print(f"mutants: {len(mutants)} records in {len({m.room for m in mutants})} rooms")
            return 0
        if not arguments or arguments[0].startswith("-"):
            print(__doc__, file=sys.stderr)
            return 2
        chosen = [m for m in mutants if len(arguments) == 1 or m.room in arguments[1:]]
        copy = Copy(Path(arguments[0]).resolve())
        copy.refresh()
        copy.configure()
        planter = Planter(copy)
        verdicts = [planter.judge(mutant) for mutant in chosen]
    except WrongRecord as wrong:
        print(f"run.py: {wrong}", file=sys.stderr)
        return 1
    alive, wrong = verdicts.count("ALIVE"), verdicts.count("WRONG")
    print(f"mutants: {len(chosen)} planted, {alive} alive, {wrong} that cannot be planted")
    return 1 if alive or wrong else 0


if __name__ == "__main__":
    sys.exit(main())
