"""A table of branches taken and regions run, by folder of src/, from what `llvm-cov export` says of every function.

A branch is one outcome of one condition of the source, as clang sees it: of `if (a && b)`, a true, a false, b true, b false.
One text that is compiled several times (kernels for each instruction set, intersectors for each precision, functions in
headers) is one text here: an outcome counts as taken if any of its compilations took it. A condition in a macro belongs to each
place that uses the macro. Each label of a switch is one outcome, that it was jumped to; a switch without default names all
values of its type (-Wswitch-enum), so that none is left for a further one. Conditions that are constants are not counted.

usage: coverage.py EXPORT.json SOURCE MISSED.txt
"""
import json
import os
import re
import sys
from collections import defaultdict

CODE, EXPANSION = 0, 1


def places(function, names):
    """Where each file of a function comes from: its name and the chain of uses of macros that leads to it."""
    chains = {0: ()}
    uses = {region[6]: region for region in function["regions"] if region[7] == EXPANSION}

    def chain(number):
        if number not in chains:
            use = uses.get(number)
            chains[number] = chain(use[5]) + ((names[use[5]], *use[:4]),) if use else ()
        return chains[number]

    return [chain(number) for number in range(len(names))]


class Texts:
    """The lines of the source."""

    def __init__(self, source):
        self.source, self.texts = source, {}

    def line(self, file, number):
        if file not in self.texts:
            with open(os.path.join(self.source, file), encoding="utf-8") as opened:
                self.texts[file] = opened.read().splitlines()
        return self.texts[file][number - 1]

    def excerpt(self, place):
        file, line, column, to_line, to_column = place
        text = self.line(file, line)
        return text[column - 1:to_column - 1] if line == to_line else text[column - 1:] + " …"

    def is_switch(self, place):
        return self.line(*place[:2])[:place[2] - 1].endswith("switch (")

    def is_label(self, place):
        return re.match(r"(case|default)\b", self.line(*place[:2])[place[2] - 1:])


def collect(functions, source, texts):
    """Outcomes and lines: {file: {place: [true, false]}}, {file: {line: times}}; of a label only true."""
    real = {}
    branches, lines = defaultdict(dict), defaultdict(dict)
    for function in functions:
        for name in function["filenames"]:
            if name not in real:  # headers are reached through links of the build
                real[name] = os.path.relpath(os.path.realpath(name), source)
        names = [real[name] for name in function["filenames"]]
        if not any(name.startswith("src/") for name in names):
            continue
        chains = places(function, names)
        for branch in function["branches"]:
            number = branch[6]
            place = chains[number] + ((names[number], *branch[:4]),)
            if not place[0][0].startswith("src/") or texts.is_switch(place[-1]):
                continue
            taken = branch[4:5] if texts.is_label(place[-1]) else branch[4:6]
            before = branches[place[0][0]].get(place, [0, 0])
            branches[place[0][0]][place] = [a + b for a, b in zip(taken, before)]
        for region in function["regions"]:
            if region[7] == CODE and not chains[region[5]]:
                of_file = lines[names[region[5]]]
                of_file[region[0]] = of_file.get(region[0], 0) + region[4]
    return branches, lines


def describe(place):
    file, line, column = place[0][:3]
    text = f"{file}:{line}:{column}"
    return text + "".join(f" in {inner}:{at}:{col}" for inner, at, col, *_ in place[1:])


def main():
    export, source, missed = sys.argv[1:]
    source = os.path.realpath(source)
    texts = Texts(source)
    with open(export, encoding="utf-8") as file:
        functions = json.load(file)["data"][0]["functions"]
    branches, lines = collect(functions, source, texts)
    sums = defaultdict(lambda: [0, 0, 0, 0])
    with open(missed, "w", encoding="utf-8") as out:
        for file in sorted(set(branches) | set(lines)):
            if not file.startswith("src/"):
                continue
            outcomes = [taken for place in branches[file].values() for taken in place]
            runs = list(lines[file].values())
            counts = (sum(n > 0 for n in outcomes), len(outcomes), sum(n > 0 for n in runs), len(runs))
            for name in ("/".join(file.split("/")[:2]), "all"):
                sums[name] = [a + b for a, b in zip(sums[name], counts)]
            if counts[0] < counts[1]:
                out.write(f"{file}: {counts[0]} of {counts[1]} branches\n")
            for place, taken in sorted(branches[file].items()):
                if not all(taken):
                    never = "neither" if not any(taken) else "never false" if taken[0] else "never true"
                    out.write(f"  {describe(place)}: {never}: {texts.excerpt(place[0])}\n")
    print(f"{'folder':<16} {'branches':>9} {'taken':>8} {'regions':>8} {'run':>8}")
    for name in sorted(sums, key=lambda name: (name == "all", name)):
        taken, total, run, starts = sums[name]
        print(f"{name:<16} {total:>9} {100 * taken / max(total, 1):>7.1f}% {starts:>8} {100 * run / max(starts, 1):>7.1f}%")


main()
