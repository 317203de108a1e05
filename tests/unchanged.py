#!/usr/bin/env python3
"""Which tests need not run again: those that passed with the same bytes.

    tests/unchanged.py select PRESET [--all]
        prints what ctest's -I takes: the numbers of the tests that must run. None printed: none must.
    tests/unchanged.py record PRESET
        notes what passed, from the report that ctest wrote: build/PRESET/ctest.xml.

A test's key is made of all that can change what it says: its command and environment, the bytes of its program and of
the programs that it starts, the captures, the packages and parts that are installed, and the processors. Tests without
a program of their own under build/ (they read the sources) always run, as does what failed, was skipped, or passed
longer than a week ago: what a key does not know of is found then.
"""

import hashlib
import json
import os
import pathlib
import platform
import re
import subprocess
import sys
import time
import xml.etree.ElementTree as ElementTree

ROOT = pathlib.Path(__file__).resolve().parent.parent
LONGEST_SECONDS = 7 * 24 * 3600
VARIABLES = re.compile(r"^(VK|LP|MESA|GALLIUM|XR|XRT|REVISIT|GTEST|TBB|LD|LIBGL|[AT]SAN|UBSAN)_")


def digest(*parts):
    sum_ = hashlib.blake2b(digest_size=16)
    for part in parts:
        data = part if isinstance(part, bytes) else json.dumps(part, sort_keys=True).encode()
        sum_.update(len(data).to_bytes(8, "little") + data)
    return sum_.hexdigest()


def digest_of_files(files):
    return digest([[file.name, digest(file.read_bytes())] for file in sorted(files) if file.is_file()])


def listing(folder):
    """What lies there, by name, size and time: captures are too large to be read for this."""
    found = []
    for place, _, names in os.walk(folder):
        for name in names:
            status = os.lstat(os.path.join(place, name))
            found.append([os.path.relpath(os.path.join(place, name), folder), status.st_size, status.st_mtime_ns])
    return sorted(found)


def said_by(*command):
    try:
        return subprocess.run(command, capture_output=True, check=False).stdout
    except FileNotFoundError:
        return b""


def surroundings(tree):
    """What all tests of a build stand on."""
    return digest(
        said_by("dpkg-query", "--show"),
        listing(ROOT / ".deps"),
        listing(ROOT.parent / "shared" / "data"),
        re.findall(r"^(?:model name|flags)\s*:.*", pathlib.Path("/proc/cpuinfo").read_text(), re.MULTILINE),
        platform.release(),
        sorted([name, value] for name, value in os.environ.items() if VARIABLES.match(name)),
        digest_of_files((ROOT / "tests").glob("*.txt")),
        digest_of_files((tree / "lib").glob("*.so*")),
    )


def keys_of(tests, tree):
    """By name; None: always runs. tests: as ctest --show-only=json-v1 lists them."""
    around = surroundings(tree)
    started = digest_of_files(
        file for file in (tree / "bin").iterdir() if not file.name.endswith(("_tests", "_bench"))
    )
    programs = {}
    keys = {}
    for test in tests:
        command = test.get("command", [""])
        program = pathlib.Path(command[0])
        labels = next((p["value"] for p in test["properties"] if p["name"] == "LABELS"), [])
        if program.parent != tree / "bin":
            keys[test["name"]] = None
            continue
        if program not in programs:
            programs[program] = digest(program.read_bytes())
        # What draws, and what is run as a user would, may start other programs; units of code do not.
        others = "" if set(labels) == {"unit"} else started
        keys[test["name"]] = digest(command, test["properties"], programs[program], others, around)
    return keys


def must_run(keys, passed, now):
    """The names of tests that must run, in order."""
    def is_known(name, key):
        before = passed.get(name, {})
        return key is not None and before.get("key") == key and 0 <= now - before["when"] < LONGEST_SECONDS
    return [name for name, key in keys.items() if not is_known(name, key)]


def after_run(keys, passed, report, now):
    """passed, with what a report of ctest (JUnit's XML) says of the tests of these keys."""
    passed = {name: entry for name, entry in passed.items() if name in keys}
    for case in ElementTree.fromstring(report).iter("testcase"):
        name = case.get("name")
        passed.pop(name, None)
        has_passed = case.get("status") == "run" and case.find("failure") is None and case.find("skipped") is None
        if has_passed and keys.get(name) is not None:
            passed[name] = {"key": keys[name], "when": now}
    return passed


def read_json(file):
    return json.loads(file.read_text()) if file.exists() else {}


def write_json(file, value):
    beside = file.with_suffix(".new")
    beside.write_text(json.dumps(value, indent=0))
    beside.replace(file)


def select(preset, tree, takes_all):
    ctest = ["ctest", "--preset", preset]
    tests = json.loads(subprocess.run([*ctest, "--show-only=json-v1"], capture_output=True, check=True).stdout)["tests"]
    numbered = subprocess.run([*ctest, "-N"], capture_output=True, check=True, text=True).stdout
    numbers = {name: number for number, name in re.findall(r"^ *Test +#(\d+): (.*)$", numbered, re.MULTILINE)}
    keys = keys_of(tests, tree)
    if len(keys) != len(tests) or keys.keys() != numbers.keys():
        sys.exit("tests/unchanged.py: two tests of one name, or ctest does not say the same twice")
    names = list(keys) if takes_all else must_run(keys, read_json(tree / "passed.json"), time.time())
    write_json(tree / "keys.json", keys)
    if len(names) < len(keys):
        print(f"[dev] {preset}: {len(keys) - len(names)} of {len(keys)} tests passed with the same programs, captures "
              "and drivers before, and do not run again; './dev test --all' runs them", file=sys.stderr)
    if names:
        print("0,0,0," + ",".join(numbers[name] for name in names))


def record(tree):
    report = tree / "ctest.xml"
    if not report.exists():
        return  # broken off: nothing is known
    passed = after_run(read_json(tree / "keys.json"), read_json(tree / "passed.json"), report.read_text(), time.time())
    write_json(tree / "passed.json", passed)


def main(arguments):
    os.chdir(ROOT)
    match arguments:
        case ["select", preset, *rest] if rest in ([], ["--all"]):
            select(preset, ROOT / "build" / preset, rest != [])
        case ["record", preset]:
            record(ROOT / "build" / preset)
        case _:
            sys.exit(__doc__)


if __name__ == "__main__":
    main(sys.argv[1:])
