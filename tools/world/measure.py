# SPDX-License-Identifier: MIT
"""How well a world that the hand has set is kept, on rendered sequences with exact truth.

  measure.py PROGRAM SEQUENCE...        for example: measure.py build/release/apps/handyar/handyar OUT/tabletop/*

Each sequence is run twice: as it is, and opened with the map that the first run has written. Drift is counted against the true
camera from the moment at which the frame was set, once the hand is gone, in degrees and in percent of the camera's distance to
where the hand lay. A return begins with the first frame in which the place where the hand lay is in the picture again, after it
was out of it for a third of a second; it ends with the first frame in which the world is tracked. A pose that is off by more
than 3 degrees or 5 % is wrong.
"""
import argparse
import csv
import json
import os
import subprocess
import sys
import tempfile

import numpy as np

sys.path.insert(0, os.path.join(os.path.dirname(os.path.abspath(__file__)), '..'))
from rendered import write_camera

FINGERS = ['thumb', 'index', 'middle', 'ring', 'little']
FPS = 30


def isometry(R, t):
    T = np.eye(4)
    T[:3, :3], T[:3, 3] = R, t
    return T


def rotation_of(w, x, y, z):
    return np.array([[1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y)],
                     [2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x)],
                     [2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y)]])


def write_inputs(truth, camera_file, hand_file):
    write_camera(truth, camera_file)
    # The back of the hand is seen; a right hand's truth is that of its palm.
    left = truth['hand_side'] == 'L'
    face = np.array([1, 1, 1] if left else [-1, 1, -1]) / 1000
    tips = {finger: list(face * tip) for finger, tip in zip(FINGERS, truth['tips_hand_mm'])}
    with open(hand_file, 'w') as file:
        json.dump(dict(format='handyar-hand', version=1, tips_m=tips, layout='thumb_right' if left else 'thumb_left', source='truth',
                       rms_px=0, thickness_m=0.008), file)


def run(program, sequence, folder):
    """Poses in the world by frame."""
    poses_file = f'{folder}/poses.csv'
    subprocess.run([program, 'world', f'{sequence}/video.mp4', '--camera', f'{folder}/camera.yml', '--hand', f'{folder}/hand.json',
                    '--map', f'{folder}/world.map', '--poses', poses_file], check=True, stdout=subprocess.DEVNULL)
    poses = {}
    with open(poses_file) as file:
        for row in csv.DictReader(file):
            if row['qw']:
                poses[int(row['frame'])] = isometry(rotation_of(*[float(row[k]) for k in ('qw', 'qx', 'qy', 'qz')]),
                                                    [float(row[k]) for k in ('tx_m', 'ty_m', 'tz_m')])
    return poses


def returns(cameras, spot, K):
    """Frames with which returns begin."""
    begun, out = [], 0
    for frame in sorted(cameras):
        p = cameras[frame] @ spot
        px = K @ p[:3] / p[2]
        seen = p[2] > 0 and 0 <= px[0] < 640 and 0 <= px[1] < 480
        if seen and out >= FPS / 3:
            begun.append(frame)
        out = 0 if seen else out + 1
    return begun


def percent_and_degrees(true, estimated):
    off = true @ np.linalg.inv(estimated)
    degrees = np.degrees(np.arccos(np.clip((np.trace(off[:3, :3]) - 1) / 2, -1, 1)))
    return 100 * np.linalg.norm(true[:3, 3] - estimated[:3, 3]) / np.linalg.norm(true[:3, 3]), degrees


def waits(begun, poses, frames):
    """Seconds from each return to the first pose; infinite where there is none before the next."""
    ends = begun[1:] + [frames]
    return [min((frame for frame in poses if start <= frame < end), default=np.inf) / FPS - start / FPS
            for start, end in zip(begun, ends)]


def measure(program, sequence):
    with open(f'{sequence}/truth.json') as file:
        truth = json.load(file)
    cameras = {f['frame']: isometry(f['R_world_to_cam'], np.array(f['t_world_to_cam_mm']) / 1000) for f in truth['frames']}
    visible = {f['frame']: f['hand_visible_fraction'] > 0.02 for f in truth['frames']}
    gone = max(frame for frame in visible if visible[frame]) + 1
    with tempfile.TemporaryDirectory() as folder:
        write_inputs(truth, f'{folder}/camera.yml', f'{folder}/hand.json')
        first = run(program, sequence, folder)
        if not first:
            return None
        again = run(program, sequence, folder)
    start = min(first)
    T_truth_world = np.linalg.inv(cameras[start]) @ first[start]
    begun = returns(cameras, T_truth_world[:, 3], np.array(truth['K']))
    drift, wrong = {}, 0
    for poses in (again, first):
        for frame, pose in poses.items():
            drift[frame] = percent_and_degrees(cameras[frame] @ T_truth_world, pose)
            wrong += drift[frame][0] > 5 or drift[frame][1] > 3
    kept = np.array([drift[frame] for frame in sorted(first) if frame >= gone])
    late = np.array([drift[frame] for frame in sorted(first) if frame >= gone + 10 * FPS])
    return dict(kept=kept, late=late, waits=waits(begun, first, len(cameras)), again=waits([0] + begun, again, len(cameras)), wrong=wrong,
                start=start)


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument('program')
    parser.add_argument('sequences', nargs='+')
    args = parser.parse_args()
    print('| sequence | set after | drift, median | 95 % | worst | after 10 s | returns found after | with the map of before | wrong |')
    print('| --- | --- | --- | --- | --- | --- | --- | --- | --- |')
    for sequence in args.sequences:
        m = measure(args.program, sequence)
        name = os.path.basename(os.path.normpath(sequence))
        if m is None:
            print(f'| {name} | never |')
            continue
        drift = lambda part, values: '{:.2f} %, {:.2f}°'.format(*part(values, 0)) if len(values) else ''
        limit = lambda values, axis: np.percentile(values, 95, axis)
        seconds = lambda values: ', '.join('never' if np.isinf(v) else f'{v:.2f}' for v in values)
        print(f"| {name} | {m['start'] / FPS:.2f} s | {drift(np.median, m['kept'])} | {drift(limit, m['kept'])} | "
              f"{drift(np.max, m['kept'])} | {drift(np.max, m['late'])} | {seconds(m['waits'])} | "
              f"{seconds(m['again'])} | {m['wrong']} |", flush=True)


if __name__ == '__main__':
    sys.exit(main())
