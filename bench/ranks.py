"""The measurements of bench/ranks.sh: python3 ranks.py FATHOM SCENE SPP WIDTHxHEIGHT SPP FOLDER"""
import heapq
import os
import resource
import struct
import subprocess
import sys
from random import Random

fathom, scene, spp, size, simulated_spp, folder = sys.argv[1:]
# As in src/job/ranks/ranks.c.
LOOK = 0.001  # seconds between two looks for messages
LEFT_SHARE, REQUEST_SECONDS, ANSWER_SECONDS, MOST_UNITS = 4, 0.003, 8e-6, 1024
# Time of rank 0's processor: a request with the results that come before it and the answer, and each of its squares. Measured
# with 8 ranks, of 28,812 requests.
REQUEST_COST, SQUARE_COST = 8e-6, 0.07e-6
SQUARES = 64  # of a tile
HEAD_BYTES_AT = 12  # of part_head.bytes
RECORD = struct.Struct("<IIQQdd7Q")  # part_record


def run(*command):
    """Processor seconds of the command with all that it starts."""
    before = resource.getrusage(resource.RUSAGE_CHILDREN)
    subprocess.run(command, check=True, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
    after = resource.getrusage(resource.RUSAGE_CHILDREN)
    return after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime


ROUNDS = 9
PARTS, RANKS = "parts", "ranks"


def render(kind, count, samples):
    """Processor seconds of one process (kind None), of parts at the same time, or of ranks."""
    out = os.path.join(folder, "out.exr")
    command = [fathom, "render", scene, "--spp", str(samples), "--threads", "1", "--quiet", "-o"]
    if kind == PARTS:
        script = f'for k in $(seq {count}); do "$@" {folder}/$k.part --part $k/{count} --split tiles & done; wait'
        seconds = run("sh", "-c", script, "sh", *command)
        for k in range(count):
            os.remove(f"{folder}/{k + 1}.part")
        return seconds
    return run(*(["mpirun", "--oversubscribe", "-n", str(count)] if kind else []), *command, out, *(["--mpi"] if kind else []))


def measure():
    """The least of rounds in which all take turns: other work on the machine only adds. The start is measured by a sample a
    pixel: each process reads the scene, builds, and joins the others. Parts send no messages."""
    kinds = [(None, 1)] + [(kind, count) for kind in (PARTS, RANKS) for count in (2, 4, 8)]
    times = {(kind, samples): [] for kind in kinds for samples in (spp, 1)}
    for _ in range(ROUNDS):
        for kind, samples in times:
            times[kind, samples].append(render(*kind, samples))
    print("|processes|processor time, s|of it start|more than one process|more than one process's rendering|")
    print("|---|---|---|---|---|")
    one, one_start = min(times[kinds[0], spp]), min(times[kinds[0], 1])
    for kind in kinds:
        all_, start = min(times[kind, spp]), min(times[kind, 1])
        name = f"{kind[1]} {kind[0]}" if kind[0] else "one"
        print(f"|{name}|{all_:.2f}|{start:.2f}|{100 * (all_ / one - 1):+.1f} %|"
              f"{100 * ((all_ - start) / (one - one_start) - 1):+.1f} %|", flush=True)


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


class Squares:
    """The work that is not handed out yet. `least`: squares of the smallest unit."""

    def __init__(self, times, samples, ranks):
        self.times, self.ranks = times, ranks
        self.least = max(SQUARES // samples, 1)
        self.first, self.end = 0, len(times) * SQUARES
        self.lasting = max(REQUEST_SECONDS, ANSWER_SECONDS * ranks) * self.end / sum(times)

    def take(self):
        """The seconds of each unit that one request gets."""
        left, units = self.end - self.first, []
        each = max(left / (LEFT_SHARE * self.ranks), min(self.lasting, left / self.ranks))
        each = max(int(min(each, MOST_UNITS * SQUARES)) // self.least * self.least, self.least)
        end = min(self.first + each, self.end)
        while self.first < end:
            tile, square = divmod(self.first, SQUARES)
            count = min(SQUARES - square, end - self.first)
            units.append(self.times[tile] * count / SQUARES)
            self.first += count
        return units, len(units) and each


def simulate(times, samples, ranks):
    """Seconds until the last square is there, one thread a rank. A rank sends its results and asks when it begins its last
    unit. Rank 0 takes one message after the other; a message waits for the next look of who sleeps."""
    random = Random(1)
    squares, free, waiting, root, end = Squares(times, samples, ranks), [0.0] * ranks, [0] * ranks, 0.0, 0.0
    events = [(0.0, rank) for rank in range(ranks)]  # when it asks
    while events:
        asked, rank = heapq.heappop(events)
        sent, waiting[rank] = waiting[rank], 0
        if rank:
            begin = asked + random.random() * LOOK if asked > root else root
            root = begin + REQUEST_COST + sent * SQUARE_COST
        units, waiting[rank] = squares.take()
        if not units:
            end = max(end, root, free[rank] + (random.random() * LOOK if rank else 0))
            continue
        heard = root + random.random() * LOOK if rank else asked
        last = max(free[rank], heard) + sum(units[:-1])
        free[rank] = last + units[-1]
        heapq.heappush(events, (last, rank))
    return end


FACTORS = 1, 20, 100, 400


def efficiency():
    times = tile_times()
    work = sum(times)
    print(f"\n{len(times)} tiles of {size}, {simulated_spp} spp: {1000 * work / len(times):.1f} ms each in the mean, "
          f"{1000 * max(times):.1f} ms at most; the same with as many times the samples:")
    print("\n|ranks|" + "|".join(f"×{k}" for k in FACTORS) + "|")
    print("|---|" + "---|" * len(FACTORS))
    for ranks in (2, 8, 32, 128, 512, 1024):
        row = [work * k / (ranks * simulate([t * k for t in times], int(simulated_spp) * k, ranks)) for k in FACTORS]
        print(f"|{ranks}|" + "|".join(f"{100 * e:.1f} %" for e in row) + "|")


measure()
efficiency()
