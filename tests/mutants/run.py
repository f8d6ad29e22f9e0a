"""Runs `fathom validate` on every line of mutants.tsv and holds it against what must be found.

usage: run.py BUILD_FOLDER [NAME...]      (default: all)

A line has: where the fault is (plugin, embree, kernel), its name, the rays of each family, further options, and the
verdict: "none", or the words of which one must stand in a line that begins with "found: "."""

import concurrent.futures
import os
import pathlib
import subprocess
import sys
import time

HERE = pathlib.Path(__file__).parent


def command_of(build, place, name, rays, options):
    env = dict(os.environ, FATHOM_MUTANT=name)
    program = build / "bin/fathom"
    mutants = build / "tests/mutants"
    arguments = options.replace("PLUGIN", str(mutants / "tracers.so")).split()
    if place == "embree":
        env["LD_PRELOAD"] = str(mutants / "embree.so")
    if place == "kernel":
        program = mutants / "fathom"
    return [str(program), "validate", "--rays", rays, "--power", "0", "--sample", "0"] + arguments, env


# Two threads meet by chance, and seldom on a busy machine: a race has to be found in one of so many runs.
RACE_TRIES = 4


def run(build, line):
    tries = RACE_TRIES if line.split("\t")[1].startswith("race") else 1
    for _ in range(tries):
        result = run_once(build, line)
        if result[1]:
            break
    return result


def run_once(build, line):
    place, name, rays, options, verdict = line.split("\t")
    command, env = command_of(build, place, name, rays, options)
    start = time.monotonic()
    done = subprocess.run(command, env=env, capture_output=True, text=True, timeout=300)
    found = [text for text in done.stdout.splitlines() if text.startswith("found: ")]
    if verdict == "none":
        good = done.returncode == 0 and not found
    else:
        good = done.returncode == 1 and any(word in text for text in found for word in verdict.split("|"))
    return line, good, done, found, time.monotonic() - start


def report(result):
    line, good, done, found, seconds = result
    place, name, rays, _, verdict = line.split("\t")
    print(f"{'ok  ' if good else 'SLIP'} {place:7} {name:22} rays {rays:>6}  must be {verdict:24} {seconds:5.1f} s  "
          f"{found[0][7:] if found else ''}", flush=True)
    if not good:
        print(f"     exit code {done.returncode}: {' '.join(done.args[1:])}\n     {done.stderr.strip()[-300:]}")


def main():
    build = pathlib.Path(sys.argv[1])
    names = sys.argv[2:]
    lines = [text for text in (HERE / "mutants.tsv").read_text().splitlines() if text and text[0] != "#"]
    lines = [text for text in lines if not names or text.split("\t")[1] in names]
    start = time.monotonic()
    slipped = 0
    with concurrent.futures.ThreadPoolExecutor(os.cpu_count()) as pool:
        for result in pool.map(lambda text: run(build, text), lines):
            report(result)
            slipped += not result[1]
    mutants = sum(not text.endswith("\tnone") for text in lines)
    print(f"{mutants} mutants and {len(lines) - mutants} correct tracers, {slipped} slipped or false, "
          f"{time.monotonic() - start:.0f} s")
    return 1 if slipped or not lines else 0


sys.exit(main())
