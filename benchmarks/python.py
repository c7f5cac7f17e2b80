# SPDX-License-Identifier: MIT
"""What Python costs over C++, a frame: the shipped clip, tracked by the program, which times the
tracker alone, and from Python, with the result's arrays read. Of each frame the least of some runs
counts, since other programs only ever add.

    PYTHONPATH=build/release/bindings/python PATH=build/release/apps/handyar:$PATH \\
      python3 benchmarks/python.py
"""

import csv
import subprocess
import sys
import tempfile
import time
from pathlib import Path

import numpy as np

import handyar

RUNS = 15
CAMERA, HAND = (handyar.io.data_file("sample/" + name) for name in ("camera.yml", "hand.json"))


def cpp_ms(folder: Path) -> list[float]:
    poses = folder / "poses.csv"
    subprocess.run(
        [sys.executable, "-m", "handyar", "track", "sample", "--camera", CAMERA, "--hand", HAND,
         "--poses", str(poses)],
        check=True, capture_output=True,
    )
    with open(poses) as file:
        return [float(row["total_ms"]) for row in csv.DictReader(file)]


def python_ms() -> list[float]:
    tracker = handyar.Tracker(handyar.io.read_camera(CAMERA), handyar.io.read_hand(HAND))
    times_ms = []
    for frame in handyar.io.open_input("sample"):  # as the program: decoded just before
        start_s = time.perf_counter()
        result = tracker.process(frame.bgr, frame.time_s)
        result.state, result.pose, result.covariance, result.tips
        times_ms.append(1000 * (time.perf_counter() - start_s))
    return times_ms


with tempfile.TemporaryDirectory() as folder:
    runs = [(cpp_ms(Path(folder)), python_ms()) for _ in range(RUNS)]
cpp, python = np.array(runs).min(axis=0)
print(f"C++ {np.median(cpp):.3f} ms, Python {np.median(python):.3f} ms a frame (medians); "
      f"Python costs {np.median(python - cpp):+.3f} ms")
