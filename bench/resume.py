#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Is a run that was killed three times at random moments, with two bad files among the photographs, the same as one that was not?

usage: bench/resume.py PHOTOS [--control FILE] [--out DIR] [--seed N] [--collinea PROGRAM] [-- OPTIONS OF RUN]
Compares products/ and the oriented block bit for bit. Also runs once on a single thread. Exit code 1 when anything differs.
"""
import argparse
import filecmp
import os
import random
import shutil
import signal
import subprocess
import sys
import time

root = os.path.dirname(os.path.dirname(os.path.abspath(__file__)))
parser = argparse.ArgumentParser()
parser.add_argument("photos")
parser.add_argument("--control")
parser.add_argument("--out", default=os.path.join(root, "build", "bench-resume"))
parser.add_argument("--seed", type=int, default=1)
parser.add_argument("--collinea", default=os.path.join(root, "build", "release", "bin", "collinea"))
ours = sys.argv[1:sys.argv.index("--")] if "--" in sys.argv else sys.argv[1:]
args = parser.parse_args(ours)
args.options = sys.argv[len(ours) + 2:]
rng = random.Random(args.seed)

shutil.rmtree(args.out, ignore_errors=True)
photos = os.path.join(args.out, "photos")
shutil.copytree(args.photos, photos)
first = sorted(os.listdir(photos))[0]
whole = open(os.path.join(photos, first), "rb").read()
open(os.path.join(photos, "zz_truncated.jpg"), "wb").write(whole[: len(whole) // 2])
open(os.path.join(photos, "zz_text.jpg"), "w").write("this is not a photograph\n")


def command(project, *more):
    words = [args.collinea, "run", photos, "-o", project, "--progress", "lines", *more, *args.options]
    return words + (["--control", args.control] if args.control else [])


def run(project, *more):
    start = time.time()
    done = subprocess.run(command(project, *more), stderr=subprocess.PIPE, text=True)
    if done.returncode:
        sys.exit(f"run failed ({done.returncode}):\n{done.stderr}")
    return done.stderr, time.time() - start


def same(a, b):
    worst = 0
    for folder, names in (("products", None), ("model", None)):
        left, right = os.path.join(a, folder), os.path.join(b, folder)
        files = sorted(os.listdir(left))
        if files != sorted(os.listdir(right)):
            print(f"different files in {folder}: {files} and {sorted(os.listdir(right))}")
            worst = 1
            continue
        for name in files:
            equal = filecmp.cmp(os.path.join(left, name), os.path.join(right, name), shallow=False)
            print(f"{'same' if equal else 'DIFFERENT':<10}{folder}/{name}")
            worst |= not equal
    return worst


def export(project):
    subprocess.run([args.collinea, "export", project, os.path.join(project, "model"), "--format", "colmap"], check=True,
                   stdout=subprocess.DEVNULL)


plain = os.path.join(args.out, "plain")
log, seconds = run(plain)
export(plain)
print(f"undisturbed: {seconds:.1f} s")
for bad in ("zz_truncated.jpg", "zz_text.jpg"):
    print(f"{'named' if bad in log else 'NOT NAMED':<10}{bad}")
    if bad not in log:
        sys.exit(1)

killed = os.path.join(args.out, "killed")
for _ in range(3):
    process = subprocess.Popen(command(killed), stderr=subprocess.DEVNULL)
    time.sleep(rng.uniform(0.1, 0.4) * seconds)
    process.send_signal(signal.SIGKILL)
    process.wait()
    print("killed")
run(killed)
export(killed)
single = os.path.join(args.out, "single")
run(single, "--threads", "1")
export(single)

print("killed three times and resumed against undisturbed:")
different = same(plain, killed)
print("one thread against two:")
different |= same(plain, single)
sys.exit(different)
