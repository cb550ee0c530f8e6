#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Kills a render at 20 random moments, each time going on from its checkpoint, and compares with a render without a break;
then joins 4 shards.

usage: kill.py CAUSTIC_RENDER SCENE [--photons N] [--resolution WxH]"""
import argparse
import filecmp
import os
import random
import resource
import signal
import subprocess
import tempfile
import time

p = argparse.ArgumentParser()
p.add_argument("program")
p.add_argument("scene")
p.add_argument("--photons", default="4000000")
p.add_argument("--resolution", default="160x90")
p.add_argument("--kills", type=int, default=20)
p.add_argument("--longest", type=float, default=3, help="seconds until a kill, at most")
a = p.parse_args()
WHAT = [a.program, a.scene, "--photons", a.photons, "--resolution", a.resolution, "--layers", "irradiance,error", "--quiet"]


def cpu_s():
    usage = resource.getrusage(resource.RUSAGE_CHILDREN)
    return usage.ru_utime + usage.ru_stime


def timed(*arguments):
    before = cpu_s()
    subprocess.run([*WHAT, *arguments], check=True)
    return cpu_s() - before


with tempfile.TemporaryDirectory(prefix="caustics_kill_") as folder:
    one, out, state = (os.path.join(folder, n) for n in ("one.exr", "out.exr", "state"))
    whole_s = timed("-o", one)
    print(f"one render: {whole_s:.2f} CPU s")
    dice, kills, before = random.Random(2026), 0, cpu_s()
    resumed = [*WHAT, "-o", out, "--checkpoint", state, "--checkpoint-every", "0.25", "--resume"]
    for n in range(a.kills):
        run = subprocess.Popen(resumed)
        time.sleep(dice.uniform(0.02, a.longest))
        run.send_signal(signal.SIGKILL)
        kills += run.wait() == -signal.SIGKILL
    timed("-o", out, "--checkpoint", state, "--resume")
    same = filecmp.cmp(one, out, shallow=False)
    print(f"{kills} of {a.kills} kills came before the end; {cpu_s() - before:.2f} CPU s in all; "
          f"{'the same bytes' if same else 'OTHER BYTES'}; state {os.path.getsize(state)} bytes")
    shards = [f"{state}.{i}" for i in range(1, 5)]
    shards_s = [timed("--shard", f"{i}/4", "--checkpoint", s) for i, s in enumerate(shards, 1)]
    join_s = timed("-o", out, "--join", *shards)
    same &= filecmp.cmp(one, out, shallow=False)
    print(f"4 shards: {' '.join(f'{s:.2f}' for s in shards_s)} CPU s, joining {join_s:.2f}; "
          f"{'the same bytes' if filecmp.cmp(one, out, shallow=False) else 'OTHER BYTES'}")
    raise SystemExit(0 if same else 1)
