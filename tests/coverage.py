"""A table of branches and lines taken, by folder of src/, from gcovr's summary."""
import json
import re
import sys
from collections import defaultdict

with open(sys.argv[1], encoding="utf-8") as file:
    summary = json.load(file)
sums = defaultdict(lambda: [0, 0, 0, 0])
for entry in summary["files"]:
    # Headers are reached through links of the build: .../modules/scene/math/vec.h is src/math/vec.h.
    name = re.sub(r".*/modules/[^/]+/", "src/", entry["filename"])
    folder = "/".join(name.split("/")[:2])
    for name in (folder, "all"):
        for place, key in enumerate(("branch_covered", "branch_total", "line_covered", "line_total")):
            sums[name][place] += entry[key]
print(f"{'folder':<16} {'branches':>9} {'taken':>8} {'lines':>8} {'run':>8}")
for name in sorted(sums, key=lambda name: (name == "all", name)):
    taken, branches, run, lines = sums[name]
    share = 100 * taken / branches if branches else 100
    print(f"{name:<16} {branches:>9} {share:>7.1f}% {lines:>8} {100 * run / max(lines, 1):>7.1f}%")
