#!/usr/bin/env python3
# SPDX-License-Identifier: MIT
"""Runs what the documentation tells people to type, in a folder of its own.

    documented_commands.py --limber PROGRAM readme      every command of README.md's blocks
    documented_commands.py --limber PROGRAM help        the example at the end of every command's --help
    documented_commands.py --example PROGRAM output     what README.md says that the C++ example prints

Commands are run as they stand, on shorter twins of the scenarios (3 s, 40 points where the file names no world). What
would still take long runs as the smaller twin that TWINS says. Exit codes other than 0 fail the test. Each is printed with its time.
"""
import argparse
import os
import re
import shutil
import subprocess
import sys
import tempfile
import time
from pathlib import Path

SOURCE = Path(__file__).resolve().parents[2]
HELPED = ["run", "info", "convert", "smooth", "health", "recalibrate", "simulate", "evaluate", "study", "study merge", "study show", "paper", "report",
          "compare", "decalibrate"]
# Pattern, replacement, why.
TWINS = [
    (r"^scripts/demo\.sh", "LIMBER_PROGRAM=limber LIMBER_DEMO_RUNS=1 scripts/demo.sh", "without building, one run"),
    (r"^scripts/test\.sh", "bash -n scripts/test.sh", "it is what runs this test"),
    (r"^(\S*limber) health flight\.bag .*", r"\1 info flight.bag", "the bag of the tests is too small to navigate with"),
    (r"--runs \d+", "--runs 1", "one run"),
    (r"^(limber paper .*)--out \S+", r"! \1--out /dev/null/paper", "parsed, then refused for its folder; "
     "tests/cli/paper_command_test.cpp runs smaller ones"),
]

# Exit codes that are answers: three seconds of a recording are too short to say more.
VERDICTS = {"health": [0, 3, 4, 5], "recalibrate": [0, 4, 6]}


def twin(command):
    for pattern, replacement, _ in TWINS:
        command = re.sub(pattern, replacement, command)
    return command


def shorter(text):
    if re.search(r"^duration:", text, re.M):
        text = re.sub(r"^duration: *\S+", "duration: 3", text, flags=re.M)
    else:
        text = "duration: 3\n" + text
    return text if re.search(r"^world:", text, re.M) else text + "world: {points: 40}\n"


def make_sandbox(folder, program):
    (folder / "bin").mkdir()
    (folder / "bin/limber").symlink_to(program)
    (folder / "build/release").mkdir(parents=True)
    (folder / "build/release/limber").symlink_to(program)
    shutil.copytree(SOURCE / "scripts", folder / "scripts")
    bags = SOURCE / "tests/bags/fixtures"
    shutil.copy(bags / "ros1_lz4.bag", folder / "flight.bag")
    for name in ("camchain.yaml", "imu.yaml"):
        shutil.copy(bags / name, folder / name)
    (folder / "scenarios").mkdir()
    for file in (SOURCE / "scenarios").glob("*.yaml"):
        (folder / "scenarios" / file.name).write_text(shorter(file.read_text()))


def run(command, folder):
    """The shell's answer; a command after '!' has to fail with 1: parsed, but refused."""
    environment = dict(os.environ, PATH=f"{folder / 'bin'}:{os.environ['PATH']}")
    wanted = [1] if command.startswith("! ") else [0]
    for name, codes in VERDICTS.items():
        if re.match(rf"\S*limber {name} (?!--help)", command):
            wanted = codes
    begin = time.monotonic()
    done = subprocess.run(["bash", "-c", command.removeprefix("! ")], cwd=folder, env=environment, text=True,
                          stdout=subprocess.PIPE, stderr=subprocess.STDOUT, check=False)
    print(f"[{done.returncode}] {time.monotonic() - begin:5.1f} s {command}", flush=True)
    if done.returncode not in wanted:
        sys.exit(f"expected exit code {wanted}:\n{done.stdout[-3000:]}")
    return done.stdout


def commands_of(block):
    for line in block.splitlines():
        command = re.sub(r"\s+#.*$", "", line).strip()
        if command and not command.startswith(("#", "alias ")):
            yield command


def blocks(language):
    found = re.findall(r"^```(\w*)\n(.*?)^```$", (SOURCE / "README.md").read_text(), re.M | re.S)
    return [text for name, text in found if name == language]


def test_readme(folder, _):
    commands = [command for block in blocks("sh") for command in commands_of(block)]
    if len(commands) < 10:
        sys.exit(f"README.md: expected ten commands and more, found {commands}")
    for command in commands:
        run(twin(command), folder)
    again = set()
    # Once more, one of a kind: what would overwrite results is refused, and done with --force.
    for command in map(twin, commands):
        kind = re.match(r"limber \w+|scripts/demo", command)
        writes = re.match(r"limber (simulate|convert|run|compare|health) .*--out ", command) is not None
        if not kind or (kind[0], writes) in again:
            continue
        again.add((kind[0], writes))
        if writes:
            run("! " + command, folder)
            run(command + " --force", folder)
        else:
            run(command, folder)


def test_help(folder, available):
    run("limber simulate scenarios/paper_iv.yaml --out data/v101", folder)
    for day in ("v102", "monday", "tuesday", "wednesday"):
        shutil.copytree(folder / "data/v101", folder / "data" / day)
    for k in (1, 2):
        run(f"limber study scenarios/paper_i.yaml --methods ekf --runs 2 --shard {k}/2 --out part{k}.sqlite", folder)
    for name in HELPED:
        if name.split()[0] not in available:
            print(f"not in this build: {name}")
            continue
        text = run(f"limber {name} --help", folder)
        examples = re.findall(r"^  (limber \S.*)$", text[text.find("Example:"):], re.M) if "Example:" in text else []
        if not examples:
            sys.exit(f"limber {name} --help ends without an example")
        if name == "study merge":
            for file in ("study.sqlite", "study.html"):
                (folder / file).unlink(missing_ok=True)
        for example in examples:
            run(twin(example), folder)


def test_output(program):
    expected = [block for block in blocks("") if block.startswith("moved ")][0].split()
    found = subprocess.run([program], text=True, stdout=subprocess.PIPE, check=True).stdout.split()
    if expected[2:] != found[2:] or not float(found[1]) < 0.01:
        sys.exit(f"README.md says '{' '.join(expected)}', the example '{' '.join(found)}'")


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--limber")
    parser.add_argument("--example")
    parser.add_argument("what", choices=["readme", "help", "output"])
    arguments = parser.parse_args()
    if arguments.what == "output":
        test_output(arguments.example)
        return
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        make_sandbox(folder, arguments.limber)
        listed = run("limber --help", folder)
        available = re.findall(r"^  (\w+) ", listed, re.M)
        {"readme": test_readme, "help": test_help}[arguments.what](folder, available)


if __name__ == "__main__":
    main()
