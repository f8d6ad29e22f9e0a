#!/usr/bin/python3
"""Draws the results of `fathom validate` and `fathom bench` as one page.

usage: report.py RESULTS.json PAGE.html     "-" reads the results from standard input
       report.py --check                    exit code 0 when everything that is needed is installed

Needs matplotlib (Debian: python3-matplotlib)."""

import json
import sys


def draw(results):
    import bench_page
    import validate_page

    return bench_page.page_of(results) if "bench" in results else validate_page.page_of(results)


def main(arguments):
    if arguments == ["--check"]:
        import matplotlib  # noqa: F401

        return 0
    if len(arguments) != 2:
        print(__doc__, file=sys.stderr)
        return 2
    source, target = arguments
    with sys.stdin if source == "-" else open(source, encoding="utf-8") as file:
        results = json.load(file)
    page = draw(results)
    with open(target, "w", encoding="utf-8") as file:
        file.write(page)
    return 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
