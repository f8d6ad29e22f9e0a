"""The measurements of bench/ranks.sh: python3 ranks.py FATHOM SCENE SPP WIDTHxHEIGHT SPP FOLDER"""
import heapq
import os
import resource
import struct
import subprocess
import sys

fathom, scene, spp, size, simulated_spp, folder = sys.argv[1:]
LOOK = 0.001  # seconds between two looks for messages, as in src/job/ranks/ranks.c
MOST, SHARE = 64, 4  # as there
HEAD_BYTES_AT = 12  # of part_head.bytes
RECORD = struct.Struct("<IIQQdd7Q")  # part_record


def run(*command):
    """Processor seconds of the command with all that it starts."""
    before = resource.getrusage(resource.RUSAGE_CHILDREN)
    subprocess.run(command, check=True, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
    after = resource.getrusage(resource.RUSAGE_CHILDREN)
    return after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime


def render(ranks, samples, repeats=3):
    out = os.path.join(folder, "out.exr")
    command = [fathom, "render", scene, "-o", out, "--spp", str(samples), "--threads", "1", "--quiet"]
    if ranks:
        command = ["mpirun", "--oversubscribe", "-n", str(ranks)] + command + ["--mpi"]
    return min(run(*command) for _ in range(repeats))


def measure():
    """The start is measured by a sample a pixel: each process reads the scene, builds, and joins the others."""
    one, one_start = render(0, spp), render(0, 1)
    print("|ranks|processor time, s|of it start (1 sample a pixel)|more than one process|more than one process's rendering|")
    print("|---|---|---|---|---|")
    print(f"|one process|{one:.2f}|{one_start:.2f}| | |")
    for ranks in (1, 2, 4, 8):
        all_, start = render(ranks, spp), render(ranks, 1)
        work, more = one - one_start, all_ - start
        print(f"|{ranks}|{all_:.2f}|{start:.2f}|{100 * (all_ / one - 1):+.1f} %|{100 * (more / work - 1):+.1f} %|")


def tile_times():
    path = os.path.join(folder, "all.part")
    subprocess.run([fathom, "render", scene, "-o", path, "--part", "1/1", "--split", "tiles", "--size", size, "--spp",
                    simulated_spp, "--threads", "1", "--quiet"], check=True, stderr=subprocess.DEVNULL)
    with open(path, "rb") as file:
        data = file.read()
    at = struct.unpack_from("<I", data, HEAD_BYTES_AT)[0] + 8
    times = {}
    while at < len(data):
        record = RECORD.unpack_from(data, at)
        times[record[1]] = record[5]
        at += RECORD.size + record[3] + 8
    return [times[i] for i in sorted(times)]


def simulate(times, ranks):
    """Seconds until the last tile is there, one thread a rank. A rank asks when its queue is empty and it begins its last
    tile, as ranks.c does; the answer comes two looks later."""
    first, events = 0, []

    def take():
        nonlocal first
        each = min(max((len(times) - first) // (SHARE * ranks), 1), MOST)
        taken = times[first:first + each]
        first += len(taken)
        return taken

    end = 0.0
    for rank in range(ranks):
        heapq.heappush(events, (2 * LOOK, rank, 2 * LOOK))  # (when it asks, rank, when it is free)
    while events:
        asked, rank, free = heapq.heappop(events)
        got = take()
        if not got:
            continue
        begin = max(free, asked + 2 * LOOK)
        last = begin + sum(got[:-1])
        done = last + got[-1]
        end = max(end, done + LOOK)
        heapq.heappush(events, (last, rank, done))
    return end


def efficiency():
    times = tile_times()
    work = sum(times)
    print(f"\n{len(times)} tiles of {size}, {simulated_spp} spp: {1000 * work / len(times):.1f} ms each in the mean, "
          f"{1000 * max(times):.1f} ms at most; the same with as many times the samples:")
    print("\n|ranks|" + "|".join(f"×{k}" for k in (1, 16, 256)) + "|")
    print("|---|---|---|---|")
    for ranks in (2, 8, 32, 128, 512, 1024):
        row = [work * k / (ranks * simulate([t * k for t in times], ranks)) for k in (1, 16, 256)]
        print(f"|{ranks}|" + "|".join(f"{100 * e:.1f} %" for e in row) + "|")


measure()
efficiency()
