"""Prints how much of its reader's files a fuzz target's inputs reach, from llvm-cov's summaries.

usage: coverage.py FOLDER TARGET...    reads FOLDER/TARGET.json"""
import json
import sys

READERS = {
    "scene_json": ["src/read/json/"],
    "gltf": ["src/read/gltf/"],
    "glb": ["src/read/gltf/"],
    "obj": ["src/read/obj/"],
    "ply": ["src/read/ply/"],
    "rays": ["src/cli/validate/ray_line.c"],
    "checkpoint": ["src/render/checkpoint/", "src/job/adaptive_record.c"],
    "wire": ["src/image/helper/wire.c"],
    "reply": ["src/image/helper/loader.c", "src/image/helper/wire.c"],
    "part": ["src/job/part/"],
    "ranks": ["src/job/ranks/"],
    "command_line": ["src/cli/", "src/trace/spec.c"],
}


def main(folder, targets):
    width = max(len(" ".join(READERS[target])) for target in targets)
    print(f"{'target':14} {'reader':{width}} {'lines':>14} {'branches':>14}")
    for target in targets:
        with open(f"{folder}/{target}.json", encoding="utf-8") as file:
            files = json.load(file)["data"][0]["files"]
        sums = {"lines": [0, 0], "branches": [0, 0]}
        for entry in files:
            if not any(place in entry["filename"] for place in READERS[target]):
                continue
            for kind, (covered, count) in sums.items():
                summary = entry["summary"][kind]
                sums[kind] = [covered + summary["covered"], count + summary["count"]]
        cells = [f"{covered}/{count} {100 * covered / max(count, 1):3.0f} %" for covered, count in sums.values()]
        print(f"{target:14} {' '.join(READERS[target]):{width}} {cells[0]:>14} {cells[1]:>14}")


main(sys.argv[1], sys.argv[2:])
