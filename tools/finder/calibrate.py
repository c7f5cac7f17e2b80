# SPDX-License-Identifier: MIT
"""Fits what a hand is by the network's maps: calibrate.py finder.pt ../../src/find/constellation_statistics.inc --data SET

Runs the network on fresh training pictures, reads hands from its maps as src/find/constellation.cpp
does, and fits a logistic function of the palm's score, the fingertips' scores and how they lie to
each other (constellation.py) to whether all five are within a quarter of the span.
"""
import argparse
import itertools

import numpy as np
import torch

from constellation import FINGERS, as_source, constellations
from network import CELLS_X, CELLS_Y, STRIDE, Finder
from samples import PALM_BY_TIPS, Samples, palm_of, thumb_right
from train import as_input

MOST_PEAKS, LEAST_TIP, NO_PALM = 5, -4.0, -8.0
FREEDOM, SAME_HAND = 6.0, 0.35
MOST_CANDIDATES = 4
# The source reads hands in the same way.
RULES = f"""\
// Of each fingertip's map so many peaks are thought of, from these log odds on; beyond the maps'
// edge there is no palm.
constexpr int kMostPeaks = {MOST_PEAKS};
constexpr float kLeastTip = {LEAST_TIP}f, kNoPalm = {NO_PALM}f;
// Constellations follow Student's distribution with so many degrees of freedom: thumbs go far.
constexpr float kFreedom = {FREEDOM}f;
// Two palms nearer than this share of a span, or fingertips nearer than this share of a reach, are
// one hand's.
constexpr float kSameHand = {SAME_HAND}f;
"""
# Real rooms hold so many times more that is like a hand than these pictures do, and of hands that
# count or grasp, which lack a finger, so many times more again.
OTHER_ROOMS, OTHER_HANDS = 2.5, 4.0


def sigmoid(x):
    return 1 / (1 + np.exp(-x))


def peaks(m):
    """The likeliest peaks of a map: places (complex, between cells) and logits."""
    padded = np.pad(m, 1, constant_values=-99)
    around = [padded[1 + dy:1 + dy + CELLS_Y, 1 + dx:1 + dx + CELLS_X] for dy in (-1, 0, 1) for dx in (-1, 0, 1)]
    weight = np.array([sigmoid(a) for a in around])
    dx, dy = np.tile([-1, 0, 1], 3)[:, None, None], np.repeat([-1, 0, 1], 3)[:, None, None]
    y, x = np.nonzero((m >= LEAST_TIP) & (m >= np.max(around, 0)))
    best = np.argsort(-m[y, x], kind='stable')[:MOST_PEAKS]
    y, x = y[best], x[best]
    total = weight.sum(0)
    z = x + (weight * dx).sum(0)[y, x] / total[y, x] + 1j * (y + (weight * dy).sum(0)[y, x] / total[y, x])
    return z, m[y, x]


def readings(maps, models):
    """(palm logit, fingertips' logits, distance, whether one is missing, layout, tips, palm) of all hands that the peaks can be."""
    found = [peaks(maps[2 + f]) for f in range(FINGERS)]
    out = []
    for layout in range(2):
        mirror = (lambda z: z) if layout == 0 else (lambda z: -z.conj())
        around = np.max([np.pad(maps[layout], 1, constant_values=NO_PALM)[1 + dy:1 + dy + CELLS_Y, 1 + dx:1 + dx + CELLS_X]
                         for dy in (-1, 0, 1) for dx in (-1, 0, 1)], 0)
        for missing, model in enumerate(models):
            choices = [range(len(found[f][0])) if f != missing else [-1] for f in range(FINGERS)]
            combos = np.array(list(itertools.product(*choices)))
            if not len(combos):
                continue
            z = np.stack([mirror(found[f][0][combos[:, f]]) if f != missing else np.zeros(len(combos), complex) for f in range(FINGERS)], 1)
            logit = sum(found[f][1][combos[:, f]] for f in range(FINGERS) if f != missing)
            gone = np.full(len(combos), float(missing < FINGERS))
            with np.errstate(all='ignore'):
                d2, z = model.read(z)
            z = mirror(z)
            tips = np.stack([z.real, z.imag], 2)
            palm = np.einsum('f,nfk->nk', PALM_BY_TIPS, tips)
            ok = np.isfinite(tips).all((1, 2)) & np.isfinite(d2)
            at = np.rint(np.where(np.isfinite(palm), palm, -99)).astype(int)
            inside = ok & (at >= 0).all(1) & (at < [CELLS_X, CELLS_Y]).all(1)
            score = np.full(len(z), NO_PALM)
            score[inside] = around[at[inside, 1], at[inside, 0]]
            out.append((score[ok], logit[ok], d2[ok], gone[ok], np.full(ok.sum(), layout), tips[ok], palm[ok]))
    return [np.concatenate(c) for c in zip(*out)] if out else None


def features(score, logit, d2, gone):
    return np.stack([np.ones(len(score)), score, logit, np.log1p(d2 / FREEDOM), gone], 1)


def candidates(found, w):
    """Of all readings the likeliest, each hand once."""
    *parts, layout, tips, palm = found
    X = features(*parts)
    odds, kept = X @ w, []
    for i in np.argsort(-odds)[:400]:
        if any(layout[i] == layout[k] and np.linalg.norm(palm[i] - palm[k]) < SAME_HAND * max(np.linalg.norm(tips[j][0] - tips[j][4]) for j in (i, k))
               for k in kept):
            continue
        kept.append(i)
        if len(kept) == MOST_CANDIDATES:
            break
    return [(X[i], layout[i], tips[i]) for i in kept]


def is_hand(layout, tips, hands):
    for true in hands:
        t = (true + 0.5) / STRIDE - 0.5
        limit = 0.25 * max(np.linalg.norm(t - palm_of(t), axis=1).max() * 1.4, 4)
        if thumb_right(t) == (layout == 0) and (np.linalg.norm(t - tips, axis=1) < limit).all():
            return True
    return False


def errors_of(layout, tips, hands):
    """By how much of the span a right reading's fingertips are off: a row for the hand that it is, if any."""
    for true in hands:
        if is_hand(layout, tips, [true]):
            yield (tips - (true + 0.5) / STRIDE + 0.5) / np.linalg.norm(tips[0] - tips[4])


def main():
    ap = argparse.ArgumentParser()
    ap.add_argument('network')
    ap.add_argument('out')
    ap.add_argument('--data', required=True)
    ap.add_argument('--count', type=int, default=3000)
    a = ap.parse_args()
    torch.set_num_threads(1)
    net = Finder()
    net.load_state_dict(torch.load(a.network))
    net.eval()
    models = constellations(a.data)
    samples, pictures = Samples(a.data, 424242), []
    w = np.array([5.0, 1.2, 0.36, -1.4, -1.8])
    for _ in range(a.count):
        picture, hands = samples.sample()
        with torch.no_grad():
            maps = net(as_input(torch.from_numpy(picture)[None]))[0].numpy()
        found = readings(maps, models)
        if found is not None:
            best = np.argsort(-(features(*found[:4]) @ w))[:300]
            pictures.append(([c[best] for c in found], hands))
    for _ in range(4):
        rows, labels = [], []
        for found, hands in pictures:
            for x, layout, tips in candidates(found, w):
                rows.append(x)
                labels.append(is_hand(layout, tips, hands))
        X, y = np.array(rows), np.array(labels, float)
        weight = np.where(y > 0, 1, OTHER_ROOMS * np.where(X[:, -1] > 0, OTHER_HANDS, 1))
        for _ in range(50):  # Newton
            p = sigmoid(X @ w)
            H = (X * (weight * p * (1 - p))[:, None]).T @ X + 1e-3 * np.eye(len(w))
            w += np.linalg.solve(H, X.T @ (weight * (y - p)) - 1e-3 * w)
        p = sigmoid(X @ w)
        print(int(y.sum()), 'of', len(y), 'candidates are hands; log odds', ','.join('%.4f' % v for v in w),
              'log loss %.4f' % -np.mean(np.where(y > 0, np.log(p), np.log(1 - p))), flush=True)
    errors = np.array([e for found, hands in pictures for x, layout, tips in candidates(found, w) if x @ w > 0 for e in errors_of(layout, tips, hands)])
    sigma = np.sqrt(np.mean(errors ** 2))
    with open(a.out, 'w') as f:
        f.write('// SPDX-License-Identifier: MIT\n// Made by tools/finder/calibrate.py; do not edit.\n\n'
                '%s\n'
                '// Standard deviation of a right and likely reading\'s fingertips, as a share of the span.\n'
                'constexpr float kTipSigma = %.2gf;\n'
                '// Fingertips without each of them, and all.\n'
                'constexpr std::array<Constellation, kFingerCount + 1> kConstellations{{\n%s}};\n'
                '// The palm by the fingertips.\n'
                'constexpr std::array<float, kFingerCount> kPalmOfTips{%s};\n'
                '// Log odds of a hand: constant, by the palm\'s log odds, by the sum of the fingertips\',\n'
                '// by the logarithm of their constellation\'s likelihood, by one being missing.\n'
                'constexpr std::array<float, 5> kOdds{%s};\n'
                % (RULES, sigma, ''.join(map(as_source, models)), *(', '.join('%.4g' % v for v in t) for t in (PALM_BY_TIPS, w))))


if __name__ == '__main__':
    main()
