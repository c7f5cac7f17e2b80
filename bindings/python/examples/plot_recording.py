# SPDX-License-Identifier: MIT
"""Plots where the hand was in a recording and how it was turned:

    python3 plot_recording.py hand.mp4 plot.png     (or sample, the shipped clip)

Cells as editors and notebooks have them (# %%).
"""

# %% Track the recording
import sys

import matplotlib
import numpy as np

import handyar

recording = sys.argv[1] if len(sys.argv) > 1 else "sample"
source = handyar.io.open_input(recording)
camera = handyar.Camera.from_field_of_view(source.width_px, source.height_px)
tracker = handyar.Tracker(camera, handyar.average_adult_hand())
results = [tracker.process(frame.bgr, frame.time_s) for frame in source]
tracked = [r for r in results if r.pose is not None and not r.doubtful]
print(f"{recording}: {len(tracked)} of {len(results)} frames tracked")
if not tracked:
    sys.exit(1)

# %% What is plotted: the origin of the hand frame, the tilt of the visible face, the index finger
time_s = np.array([r.time_s for r in tracked])
pose = np.array([r.pose for r in tracked])  # (n, 4, 4)
sigma_m = np.array([r.sigma_translation_m for r in tracked])
facing = np.degrees(np.arccos(np.clip(-pose[:, 2, 2], -1, 1)))  # 0: face to face with the camera
index_rad = np.array([r.flexion_rad[1] for r in tracked if r.flexion_rad is not None])

# %% Plot
matplotlib.use("Agg" if len(sys.argv) > 2 else matplotlib.get_backend())
from matplotlib import pyplot as plt

figure, (place, turn, bend) = plt.subplots(3, sharex=True, figsize=(8, 7), constrained_layout=True)
for axis, (name, color) in enumerate((("x right", "C3"), ("y down", "C2"), ("z forward", "C0"))):
    place.plot(time_s, pose[:, axis, 3], ".", color=color, markersize=3, label=name)
    place.fill_between(time_s, pose[:, axis, 3] - 2 * sigma_m, pose[:, axis, 3] + 2 * sigma_m,
                       color=color, alpha=0.2, linewidth=0)
place.set_ylabel("position (m)")
place.legend()
turn.plot(time_s, facing, ".", markersize=3)
turn.set_ylabel("turned away (degrees)")
bend.plot(time_s, np.degrees(index_rad), ".", markersize=3)
bend.set_ylabel("index bent (degrees)")
bend.set_xlabel("time (s)")
if len(sys.argv) > 2:
    figure.savefig(sys.argv[2], dpi=120)
else:
    plt.show()
