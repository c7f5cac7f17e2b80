#!/usr/bin/env python3
# SPDX-License-Identifier: MIT
"""Mean and principal deviations of the hands that were found: see README.md."""
import argparse
import collections

import numpy as np

RIGHT = 0.2  # largest error of a tip over the span, for a hand to count as found
NOISE_MM = 2.0  # what finding the points costs
DEVIATIONS = 12  # how many are kept
ROUNDS = 3

# Where the mean begins, which fixes size and shear of the average hand: millimetres, x to the
# thumb, y along the fingers; thumb to little, then the valleys from thumb to little.
BEGIN_MM = np.array([[95.2, -2], [40.8, 80.4], [0.7, 90.1], [-35.4, 75.5], [-72.6, 38],
                     [35.6, -19.2], [10.5, 17.4], [-13.3, 17.5], [-35.6, 2.2]])

HEAD = """\
// Statistics of the shape of an outstretched hand: tips, then the valleys between them, of 45
// photographed hands of many people and of rendered ones, seen from many sides, after the best affine
// fit. Millimetres; x to the thumb, y along the fingers. Columns: thumb, index, middle, ring, little,
// then valleys in the same order.
const Eigen::Matrix<float, 2, kPoints> kMean_mm =
    (Eigen::Matrix<float, 2, kPoints>() <<
"""
MIDDLE = """
// Rows: principal deviations from the mean, each divided by its standard deviation, over x and y of
// every point in turn.
const Eigen::Matrix<float, 12, 2 * kPoints> kWhitening =
    (Eigen::Matrix<float, 12, 2 * kPoints>() <<
"""


def read_hands(frames_file, candidates_file):
    """Points (n, 9, 2) of the hands rightly found, y up, thumb at +x; their weights (n)."""
    weight = {}
    with open(frames_file) as file:
        for line in file:
            frame_weight, path, frame = line.split()[:3]
            weight[path, frame] = float(frame_weight)
    points, keys = [], []
    with open(candidates_file) as file:
        for line in file:
            path, frame, error, layout, *numbers = line.split()
            if float(error) >= RIGHT:
                continue
            hand = np.array(numbers, float).reshape(9, 2) * [1, -1]
            points.append(hand * [-1, 1] if layout == "1" else hand)
            keys.append((path, frame))
    found = collections.Counter(keys)
    print(f"{len(weight)} frames, the hand was found in {len(found)}, by {len(points)} readings")
    return np.array(points), np.array([weight[key] / found[key] for key in keys])


def left_over(hands, mean_mm):
    """What the best affine maps of the mean leave, in its millimetres, fingers up: (n, 9, 2)."""
    model = np.c_[mean_mm, np.ones(9)]
    out = []
    for hand in hands:
        affine = np.linalg.lstsq(model, hand, rcond=None)[0]
        linear = affine[:2].T
        scale = np.linalg.svd(linear)[1][0]
        turn = np.pi / 2 - np.arctan2(linear[1, 1], linear[0, 1])  # of the fingers to +y
        c, s = np.cos(turn), np.sin(turn)
        out.append((hand - model @ affine) / scale @ np.array([[c, s], [-s, c]]))
    return np.array(out)


def statistics(hands, weight):
    weight = weight / weight.sum()
    mean_mm = BEGIN_MM
    for _ in range(ROUNDS):
        mean_mm = mean_mm + np.einsum("n,nij->ij", weight, left_over(hands, mean_mm))
    rest = left_over(hands, mean_mm).reshape(len(hands), 18)
    variances, axes = np.linalg.eigh((rest.T * weight) @ rest)
    largest = np.argsort(variances)[::-1][:DEVIATIONS]
    print("standard deviations, mm:", np.sqrt(variances[largest].clip(0)).round(2))
    whitening = (axes[:, largest] / np.sqrt(variances[largest] + NOISE_MM**2)).T
    return mean_mm, whitening


def rows(matrix, digits):
    return ",\n".join("     " + ", ".join(f"{x:.{digits}f}f" for x in row) for row in matrix)


def main():
    options = argparse.ArgumentParser(description=__doc__)
    options.add_argument("frames")
    options.add_argument("candidates")
    options.add_argument("--out", required=True)
    given = options.parse_args()
    mean_mm, whitening = statistics(*read_hands(given.frames, given.candidates))
    with open(given.out, "w") as file:
        file.write(HEAD + rows(mean_mm.T, 2) + ").finished();\n" + MIDDLE)
        file.write(rows(whitening, 4) + ").finished();\n")


main()
