#!/usr/bin/env python3
# SPDX-License-Identifier: MIT
"""Lists annotated frames, one a line: weight, file, frame (-1: a still), five tips in pixels.

usage: list_frames.py LIST.csv|truth.json ...
"""
import csv
import json
import os
import sys

FINGERS = ("thumb", "index", "middle", "ring", "little")
PHOTOGRAPH, RENDERED = 3.0, 0.5  # how much a frame counts


def from_truth(path):
    with open(path) as file:
        frames = json.load(file)["frames"]
    step = 20 if len(frames) > 100 else 12
    for frame in frames[::step]:
        if all(frame["tip_visible"]) and frame.get("fold", 0) < 0.02:
            tips = [x for tip in frame["tips_px"] for x in tip]
            yield RENDERED, "video.mp4", frame["frame"], tips


def from_csv(path):
    with open(path, newline="") as file:
        for row in csv.DictReader(file):
            if not (row.get("cut_by_border") or "").strip():
                tips = [float(row[finger + axis]) for finger in FINGERS for axis in ("_x", "_y")]
                yield PHOTOGRAPH, row.get("file") or row["clip"], row.get("frame", -1), tips


if len(sys.argv) < 2:
    sys.exit(__doc__)
for path in sys.argv[1:]:
    for weight, name, frame, tips in (from_csv if path.endswith(".csv") else from_truth)(path):
        file = os.path.join(os.path.dirname(path), name)
        if " " in file:
            sys.exit(f"{file}: a name with a space")
        print(weight, file, frame, *(round(x, 1) for x in tips))
