#!/usr/bin/env python3
"""Power cuts, thousands of them, from one recorded run of a plant that keeps values.

usage: cuts.py BEFORE.img LOG PLC FOLDER CUTS SEEN [SEED]

QEMU's blklogwrites recorded every write and flush of the disk (format of dm-log-writes). A cut may come after any of
them. Writes before the last flush are on the disk then; of those after it a random part is, and one of these may be torn
between sectors, as of a drive that has a cache and reorders. Of each such disk: the file system recovers, and the file of
retained values must hold one whole set (Round and every element of Set are equal), which is at least as new as the one
that was on the disk with the last flush. SEEN: the last Round that a client read; the whole log must hold one that is at
most 200 ms older. That one is written to FOLDER/last.
"""
import json
import os
import random
import struct
import subprocess
import sys

MAGIC = 0x6A736677736872
FLUSH, FUA, DISCARD = 1, 2, 4


def entries(path):
    """(flags, offset in bytes, data) in the order of the log."""
    log = open(path, "rb").read()
    magic, version, count, size = struct.unpack_from("<QQQI", log)
    if magic != MAGIC or version != 1:
        sys.exit(f"{path} is no log of writes")
    at = size
    for _ in range(count):
        sector, sectors, flags, _ = struct.unpack_from("<QQQQ", log, at)
        at += size
        data = b""
        if not flags & DISCARD:
            data = log[at : at + sectors * size]
            at += sectors * size
        yield flags, sector * size, data


def kept(image, plc, folder):
    """Round of the retained set on this disk after recovery; None without a file. Ends the test when it is mixed."""
    disk, file = os.path.join(folder, "cut.img"), os.path.join(folder, "cut.retain")
    with open(disk, "wb") as out:
        out.write(image)
    if os.path.exists(file):
        os.unlink(file)
    recovery = subprocess.run(["e2fsck", "-fy", disk], capture_output=True)
    if recovery.returncode > 2:
        sys.exit(f"the file system cannot be recovered: {recovery.stdout.decode()}")
    subprocess.run(["debugfs", "-R", f"dump /power/retain {file}", disk], capture_output=True, check=True)
    if not os.path.exists(file) or os.path.getsize(file) == 0:
        return None
    shown = subprocess.run([plc, "retain", "--json", file], capture_output=True, text=True)
    if shown.returncode != 0:
        sys.exit(f"lost: {shown.stderr}")
    values = {variable["path"].lower(): variable["value"] for variable in json.loads(shown.stdout)["variables"]}
    numbers = {values["round"], *values["main.set"]}
    if len(numbers) != 1:
        sys.exit(f"mixed: {sorted(numbers)}")
    return numbers.pop()


def main():
    before, log, plc, folder, wanted, seen = *sys.argv[1:5], int(sys.argv[5]), int(sys.argv[6])
    seed = int(sys.argv[7]) if len(sys.argv) > 7 else random.randrange(1 << 32)
    choose = random.Random(seed)
    print(f"cuts: seed {seed}")
    disk = bytearray(open(before, "rb").read())
    all_entries = list(entries(log))
    points = {}
    for _ in range(wanted):
        point = choose.randrange(len(all_entries) + 1)
        points[point] = points.get(point, 0) + 1
    waiting = []  # since the last flush
    durable = None  # Round on the disk as it is with the last flush
    durable_is_known = False
    cuts = partly = 0
    for point in range(len(all_entries) + 1):
        for _ in range(points.get(point, 0)):
            if not durable_is_known:
                durable = kept(disk, plc, folder)
                durable_is_known = True
            image = bytearray(disk)
            written = [write for write in waiting if choose.random() < 0.5]
            torn = choose.randrange(len(written)) if written and choose.random() < 0.5 else -1
            for index, (offset, data) in enumerate(written):
                if index == torn:
                    data = data[: 512 * choose.randrange(len(data) // 512 + 1)]
                image[offset : offset + len(data)] = data
            partly += len(written) not in (0, len(waiting)) or torn >= 0
            found = kept(image, plc, folder)
            if durable is not None and (found is None or found < durable):
                sys.exit(f"lost: after entry {point} of the log there is {found}, and {durable} was on the disk")
            cuts += 1
        if point == len(all_entries):
            break
        flags, offset, data = all_entries[point]
        if data:
            waiting.append((offset, data))
        if flags & (FLUSH | FUA):
            for offset, data in waiting:
                disk[offset : offset + len(data)] = data
            waiting = []
            durable_is_known = False
    for offset, data in waiting:
        disk[offset : offset + len(data)] = data
    last = kept(disk, plc, folder)
    with open(os.path.join(folder, "last"), "w") as out:
        out.write(str(last))
    flushes = sum(1 for flags, _, _ in all_entries if flags & FLUSH)
    print(f"cuts: {cuts} cuts at {len(all_entries)} writes and flushes ({flushes}), {partly} with a part of the writes; "
          f"none lost, none mixed")
    # 200 ms are ten rounds.
    if last is None or last < seen - 10:
        sys.exit(f"lost: a client saw round {seen}, and {last} is kept")


main()
