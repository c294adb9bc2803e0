#!/usr/bin/env python3
# SPDX-FileCopyrightText: The latticed authors
# SPDX-License-Identifier: Apache-2.0
"""What a number of servers needs, and what is full first: cells.py [NODES].

Each node is a server with one GPU. Each scene is dragged by one person, 60 times a second, and sent to one watcher. What a
scene costs was measured (tests/bench/results); what nodes have is assumed and named. Scenes go to nodes by the hash of their
ids, as the proxy does it.
"""
import bisect
import random
import sys

# Measured. Bytes and milliseconds of the device for an update of all points of fandisk.obj, 17,068 patches.
DRAG_RATE = 60
UPDATES = {  # bytes (viewer.md), ms (nvidia-h200.md; a bound from tolerance.md, which has 113,663 patches in 0.30 ms)
    "10 segments, Draco": (1.97e6, 0.65),
    "half a pixel, Draco": (0.26e6, 0.30),
    "patches": (27e3, 0.30),
}
POSTGRES_EDITS = 20_000  # a second, by one PostgreSQL with two cores: store.md, 100 x 200
PROXY_CORES_PER_GB = 0.75  # core-seconds, HAProxy 2.6 with TLS

# Assumed.
LINE_GB = 25 / 8  # a second: 25 Gbit/s of each node
DEVICE_USE = 0.9  # how much of a second the device may be busy
PEOPLE = 12  # who drag at the same time, of each node
RING = 64  # places of a node on the hash ring
SEED = 23


def capacity(name):
    """How many dragged scenes a node carries, and what is full then."""
    size, milliseconds = UPDATES[name]
    limits = {
        "its line": LINE_GB * 1e9 / (size * DRAG_RATE),
        "its device": DEVICE_USE * 1e3 / (milliseconds * DRAG_RATE),
    }
    first = min(limits, key=limits.get)
    return int(limits[first]), first


def dragged(nodes, people, chooses):
    """How many dragged scenes each node has. `chooses`: a new scene goes to the less busy of two nodes."""
    rng = random.Random(SEED)
    ring = sorted((rng.random(), node) for node in range(nodes) for _ in range(RING))
    places = [place for place, _ in ring]
    count = [0] * nodes
    for _ in range(nodes * people):
        found = [ring[bisect.bisect_left(places, rng.random()) % len(ring)][1] for _ in range(1 + chooses)]
        count[min(found, key=count.__getitem__)] += 1
    return count


def main():
    nodes = int(sys.argv[1]) if len(sys.argv) > 1 else 1000
    cell = POSTGRES_EDITS // (PEOPLE * DRAG_RATE)
    print(f"| updates | scenes dragged at a time on a node | full first | GB/s of {nodes:,} nodes | cores of their proxies |")
    print("|---|---:|---|---:|---:|")
    for name, (size, _) in UPDATES.items():
        most, first = capacity(name)
        rate = nodes * PEOPLE * DRAG_RATE * size / 1e9
        print(f"| {name} | {most} | {first} | {rate:,.1f} | {rate * PROXY_CORES_PER_GB:,.0f} |")
    print(f"\n{PEOPLE} people a node make {PEOPLE * DRAG_RATE} edits a second, so one PostgreSQL carries {cell} nodes, and")
    print(f"{nodes:,} nodes are {-(-nodes // cell)} cells that share nothing.\n")
    most, _ = capacity("10 segments, Draco")
    print(f"| people a node | nodes that are full ({most} scenes) by hash | fullest | by the less busy of two | fullest |")
    print("|---:|---:|---:|---:|---:|")
    for people in (6, 12, 18):
        row = [dragged(nodes, people, chooses) for chooses in (False, True)]
        cells = [f"{sum(n > most for n in count) / nodes:.1%} | {max(count)}" for count in row]
        print(f"| {people} | {' | '.join(cells)} |")


main()
