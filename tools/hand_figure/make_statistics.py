#!/usr/bin/env python3
# SPDX-License-Identifier: MIT
"""Mean, modes and residual deviations of fitted figures.

  make_statistics.py FITS.npz [--inc F.inc] [--json F.json] [--modes 12]
"""
import argparse
import json

import numpy as np

import figure

# Radii show along the outline in full, centres only across it.
RADIUS_WEIGHT = 2.0
# What rendered hands cannot tell of real ones, in metres: centre in the palm plane and out of it,
# radius. In the plane about what real_hands.py finds the most likely; out of it photographs of the palm
# say little. Tips come on top of their finger's last sphere.
REAL_HANDS = {'fingers': (0.0015, 0.004, 0.0007), 'knuckles': (0.002, 0.004, 0.001),
              'webs': (0.003, 0.004, 0.002), 'palm': (0.006, 0.004, 0.002)}
REAL_TIPS = (0.001, 0.001, 0.001)


def vectors(fits):
    """One row of 123 numbers for each hand, metres: x, y, z, radius of 27 spheres, then x, y, z of five tips."""
    n = len(fits['spheres'])
    return np.column_stack([fits['spheres'].reshape(n, -1), fits['tips'].reshape(n, -1)]) / 1000


def weights():
    w = np.ones(27 * 4 + 15)
    w[3:108:4] = RADIUS_WEIGHT
    return w


def principal_modes(X, count):
    """Mean, modes scaled by their standard deviation, what they leave per entry, and all variances."""
    mean, w = X.mean(0), weights()
    U, s, Vt = np.linalg.svd((X - mean) * w, full_matrices=False)
    deviation = s / np.sqrt(len(X) - 1)
    modes = deviation[:count, None] * Vt[:count] / w
    modes *= np.sign(modes[:, :].sum(1, keepdims=True))
    left = (X - mean) - ((X - mean) * w @ Vt[:count].T) @ Vt[:count] / w
    return mean, modes, left.std(0, ddof=count + 1), deviation**2


def entry_names():
    names = ['%s.%s' % (n, c) for n in figure.NAMES for c in 'xyzr']
    return names + ['%s_apex.%s' % (f, c) for f in figure.FINGERS for c in 'xyz']


def real_sigma(left):
    """Residual deviations for real hands: what the modes leave of rendered ones, and what those cannot
    know, added up."""
    extra = np.zeros((figure.SPHERES, 4))
    for name, spheres in figure.GROUPS.items():
        plane, depth, radius = REAL_HANDS[name]
        extra[spheres] = plane, plane, depth, radius
    return np.sqrt(left**2 + np.concatenate([extra.ravel(), np.tile(REAL_TIPS, 5)])**2)


def rows(values, per_line=8):
    values = ['%.5ff' % v for v in values]
    return ',\n    '.join(', '.join(values[i:i + per_line]) for i in range(0, len(values), per_line))


def closing_rad(mean):
    """By the ways from each finger's root to its last sphere, in the hand plane."""
    fingers = mean[:80].reshape(5, 4, 4)
    way = fingers[:, 3, :2] - fingers[:, 0, :2]
    angles = np.arctan2(way[:, 0], way[:, 1])
    return np.r_[angles[1], np.full(4, angles[2])] - angles


def write_inc(path, count, mean, modes, real):
    hulls = ['{%d, %d, %d}' % h for h in figure.HULLS]
    hulls = ',\n    '.join(', '.join(hulls[i:i + 6]) for i in range(0, len(hulls), 6))
    mode_text = ',\n    '.join('{' + rows(m) + '}' for m in modes)
    open(path, 'w').write(f'''// SPDX-License-Identifier: MIT
// Made by tools/hand_figure/make_statistics.py from {count} rendered hands; do not edit.
//
// The figure of an outstretched hand in the hand frame (palm of a right hand, layout thumb_right),
// metres. A vector holds x, y, z and radius of 27 spheres, sphere after sphere, then x, y, z of the
// five tips of the skin, thumb to little. Sphere 4 f + k lies on finger f, k from the root over two
// joints to the tip; 20 + k is the web between the fingers k and k + 1; 24 and 25 the wrist below
// thumb and little finger, 26 the hypothenar. A hand is the mean plus modes times coefficients of
// unit variance, within the residual. Mirror z for the back of a left hand, x for thumb_left.
inline constexpr int kFigureNumbers = {len(mean)};
inline constexpr int kFigureModes = {len(modes)};
inline constexpr int kFigureHulls = {len(figure.HULLS)};

// Spheres that span each convex hull; -1: a hull of two.
inline constexpr int kFigureHullSpheres[kFigureHulls][3] = {{
    {hulls}}};

inline constexpr float kFigureMean_m[kFigureNumbers] = {{
    {rows(mean)}}};

// Each scaled by its standard deviation, the largest first.
inline constexpr float kFigureModes_m[kFigureModes][kFigureNumbers] = {{
    {mode_text}}};

// What the modes leave of rendered hands, with what those cannot tell of real ones. A tip's comes
// on top of the residual of its finger's last sphere, with which it moves.
inline constexpr float kFigureSigma_m[kFigureNumbers] = {{
    {rows(real)}}};

// How fingers turn from the mean hand's rest until they lie side by side (abduction, radians): the
// four along the middle finger, the thumb along the index finger.
inline constexpr double kFigureClosing_rad[5] = {{
    {', '.join('%.3f' % a for a in closing_rad(mean))}}};
''')


def main():
    ap = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    ap.add_argument('fits')
    ap.add_argument('--inc')
    ap.add_argument('--json')
    ap.add_argument('--modes', type=int, default=12)
    a = ap.parse_args()
    X = vectors(np.load(a.fits))
    mean, modes, left, variance = principal_modes(X, a.modes)
    real = real_sigma(left)
    share = np.cumsum(variance) / variance.sum()
    print('explained by 1.. modes:', ' '.join('%.4f' % s for s in share[:24]))
    rms = lambda v: 1000 * np.sqrt(np.mean(v**2))
    spheres = left[:108].reshape(27, 4)
    print('left, mm rms: centres %.2f, radii %.2f, tips %.2f' %
          (rms(spheres[:, :3]), rms(spheres[:, 3]), rms(left[108:])))
    if a.inc:
        write_inc(a.inc, len(X), mean, modes, real)
    if a.json:
        lists = lambda v: np.round(v, 6).tolist()
        json.dump(dict(mean=lists(mean), modes=lists(modes), sigma=lists(real), sigma_rendered=lists(left),
                       hulls=[list(h) for h in figure.HULLS], names=entry_names(), units='m',
                       frame='hand frame, palm of a right hand, thumb_right'), open(a.json, 'w'))


if __name__ == '__main__':
    main()
