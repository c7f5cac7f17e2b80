# SPDX-License-Identifier: MIT
"""How well a hand that calibrated itself is tracked elsewhere: measure.py HANDYAR PAIR...

Each PAIR is a folder with the rendered sequences stiff/ and alive/. The stiff palm is calibrated by
`handyar calibrate --self`, its span known; then the living back is tracked with that hand, with the
average hand, scaled to the true span, and with the true one. Prints a table row a pair.
"""
import argparse
import csv
import json
import math
import os
import subprocess
import sys
import tempfile

sys.path.insert(0, os.path.join(os.path.dirname(os.path.abspath(__file__)), '..'))
from rendered import write_camera


def evaluate(handyar, sequence, folder, *options):
    """Median and 95th percentile of the rotation error (degrees), median of the translation's (%), share rightly tracked (%)."""
    tree = tempfile.mkdtemp(dir=folder)
    os.symlink(os.path.abspath(sequence), os.path.join(tree, 'alive'))
    report = os.path.join(tree, 'report')
    subprocess.run([handyar, 'evaluate', tree, *options, '--report', report], check=True, capture_output=True)
    with open(os.path.join(report, 'sequences.csv')) as file:
        row = next(csv.DictReader(file))
    return [float(row[k] or 'nan') for k in ('rotation, median (deg)', 'rotation, 95 % (deg)', 'translation, median (%)', 'rightly tracked (%)')]


def main():
    ap = argparse.ArgumentParser()
    ap.add_argument('handyar')
    ap.add_argument('pairs', nargs='+')
    a = ap.parse_args()
    print('| pair | calibrated by itself | average hand | true hand | rightly tracked (%) |\n| --- | --: | --: | --: | --: |')
    for pair in a.pairs:
        stiff, alive = os.path.join(pair, 'stiff'), os.path.join(pair, 'alive')
        with open(os.path.join(stiff, 'truth.json')) as file:
            truth = json.load(file)
        span_mm = math.dist(truth['tips_hand_mm'][0], truth['tips_hand_mm'][4])
        with tempfile.TemporaryDirectory() as folder:
            camera, hand = os.path.join(folder, 'camera.yml'), os.path.join(folder, 'hand.json')
            write_camera(truth, camera)
            done = subprocess.run([a.handyar, 'calibrate', '--self', os.path.join(stiff, 'video.mp4'), '--camera', camera,
                                   '--span-mm', '%.1f' % span_mm, '--hand-out', hand], capture_output=True, text=True)
            if done.returncode:
                print('| %s | refused: %s |' % (os.path.basename(pair), done.stderr.strip().rsplit(': ', 1)[-1]))
                continue
            rows = [evaluate(a.handyar, alive, folder, *options) for options in (('--hand', hand), ('--uncalibrated',), ())]
        cell = lambda r: '%.1f / %.1f, %.1f %%' % tuple(r[:3])
        print('| %s | %s | %.0f |' % (os.path.basename(pair), ' | '.join(map(cell, rows)), rows[0][3]))


if __name__ == '__main__':
    main()
