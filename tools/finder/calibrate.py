# SPDX-License-Identifier: MIT
"""Fits the log odds of a candidate: calibrate.py finder.pt --data SET --names hands... [--count 6000]

Runs the network on fresh training pictures, takes candidates as src/find/hand_finder.cpp does and
fits a logistic function of a palm's score and of its fingertips' mean support to whether all five
tips are within a quarter of the span. Prints the three numbers that export.py wants.
"""
import argparse

import numpy as np
import torch

from network import CELLS_X, CELLS_Y, OFFSET_UNIT, OFFSETS, Finder
from samples import Samples, palm_of, thumb_right
from train import as_input

STRIDE = 4
LEAST, REACH = -2.5, 0.22
OTHER_ROOMS = 1.2  # real rooms hold so many times more that is like a hand than these pictures do


def sigmoid(x):
    return 1 / (1 + np.exp(-x))


def candidates(maps):
    """(palm score, mean support, layout, tips in cells) of each peak."""
    for palm in range(2):
        m = maps[palm]
        padded = np.pad(m, 1, constant_values=-99)
        around = np.max([padded[1 + dy:1 + dy + CELLS_Y, 1 + dx:1 + dx + CELLS_X]
                         for dy in (-1, 0, 1) for dx in (-1, 0, 1) if dy or dx], 0)
        for y, x in zip(*np.nonzero((m >= LEAST) & (m > around))):
            tips = np.array([x, y]) + OFFSET_UNIT * maps[OFFSETS][:, y, x].reshape(5, 2)
            reach = max(1.5, REACH * np.linalg.norm(tips[0] - tips[4]))
            support = []
            for f in range(5):
                ys, xs = np.mgrid[0:CELLS_Y, 0:CELLS_X]
                off = np.hypot(xs - tips[f, 0], ys - tips[f, 1]) / reach
                s = np.where(off <= 1.5, sigmoid(maps[2 + f]) * np.maximum(0, 1 - 0.5 * off ** 2), 0)
                best = np.unravel_index(s.argmax(), s.shape)
                support.append(s[best])
                if s[best] > 0.15:
                    tips[f] = best[1], best[0]
            yield m[y, x], np.mean(support), palm, tips


def is_hand(palm, tips, hands):
    for true in hands:
        t = (true + 0.5) / STRIDE - 0.5
        limit = 0.25 * max(np.linalg.norm(t - palm_of(t), axis=1).max() * 1.4, 4)
        if thumb_right(t) == (palm == 0) and (np.linalg.norm(t - tips, axis=1) < limit).all():
            return True
    return False


def main():
    ap = argparse.ArgumentParser()
    ap.add_argument('network')
    ap.add_argument('--data', required=True)
    ap.add_argument('--names', nargs='+', default=['hands'])
    ap.add_argument('--count', type=int, default=6000)
    a = ap.parse_args()
    net = Finder()
    net.load_state_dict(torch.load(a.network))
    net.eval()
    samples, rows, labels = Samples(a.data, a.names, 424242), [], []
    for _ in range(a.count):
        picture, hands = samples.sample()
        with torch.no_grad():
            maps = net(as_input(torch.from_numpy(picture)[None]))[0].numpy()
        for score, support, palm, tips in candidates(maps):
            rows.append((1, score, support))
            labels.append(is_hand(palm, tips, hands))
    X, y = np.array(rows), np.array(labels, float)
    weight = np.where(y > 0, 1, OTHER_ROOMS)
    w = np.zeros(3)
    for _ in range(50):  # Newton
        p = sigmoid(X @ w)
        H = (X * (weight * p * (1 - p))[:, None]).T @ X + 1e-3 * np.eye(3)
        w += np.linalg.solve(H, X.T @ (weight * (y - p)) - 1e-3 * w)
    print(int(y.sum()), 'of', len(y), 'candidates are hands; log odds', ','.join('%.4f' % v for v in w))


if __name__ == '__main__':
    main()
