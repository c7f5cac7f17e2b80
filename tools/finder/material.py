# SPDX-License-Identifier: MIT
"""Cuts hands out of rendered sequences and permitted photographs, and collects backgrounds.

  material.py --out DIR --sequences DIR... --real ../shared/data/real --backgrounds DIR... --plates DIR...

Writes hands.npz (pictures with alpha, fingertips in finger order, palm or back) and
backgrounds.npz. What is taken of the photographs stands in REAL: by origin, so that the rest can be
reported on.
"""
import argparse
import csv
import glob
import json
import os

os.environ['OPENCV_IO_ENABLE_OPENEXR'] = '1'
import cv2
import numpy as np

from samples import palm_of

SIDE = 208  # longest side of a cut-out, pixels
STILLS = ('SubhiH/HandsDataset', 'ardamavi/Sign-Language-Digits-Dataset')
CLIPS = ('wall_a.mp4', 'desk_stereo0.mp4', 'desk_stereo1.mp4')
CLOSED, OPEN, WHOLE = 0, 1, 2  # WHOLE: a photograph as it is, its hand not cut out
WHOLE_SIDE = 320


def cut(bgr, alpha, tips):
    """The part of a picture with a hand in it, reduced to SIDE."""
    ys, xs = np.nonzero(alpha > 20)
    if len(xs) < 400:
        return None
    x0, x1, y0, y1 = xs.min(), xs.max() + 1, ys.min(), ys.max() + 1
    if tips is not None:  # of a long forearm only a hand's length
        span = np.ptp(tips, 0).max()
        reach = 2.2 * span
        c = tips.mean(0)
        x0, x1 = max(x0, int(c[0] - reach)), min(x1, int(c[0] + reach))
        y0, y1 = max(y0, int(c[1] - reach)), min(y1, int(c[1] + reach))
    m = 2
    x0, y0 = max(x0 - m, 0), max(y0 - m, 0)
    rgba = np.dstack([bgr, alpha])[y0:y1 + m, x0:x1 + m]
    s = min(1.0, SIDE / max(rgba.shape[:2]))
    rgba = cv2.resize(rgba, None, fx=s, fy=s, interpolation=cv2.INTER_AREA)
    if tips is not None:
        tips = (tips - [x0, y0] + 0.5) * s - 0.5
    return rgba, tips


def sequence_hands(folder, step):
    truth = json.load(open(os.path.join(folder, 'truth.json')))
    video = cv2.VideoCapture(os.path.join(folder, 'video.mp4'))
    masks = cv2.VideoCapture(os.path.join(folder, 'mask.mkv'))
    right = truth.get('hand_side', 'R') == 'R'
    for i, f in enumerate(truth['frames']):
        ok, bgr = video.read()
        ok2, mask = masks.read()
        if not ok or not ok2:
            break
        if i % step or f.get('hand_visible_fraction', 1) < 0.9:
            continue
        mask = mask[..., 0]
        alpha = np.where((mask > 220) | (np.abs(mask.astype(int) - 128) < 30), 255, 0).astype(np.uint8)
        alpha = cv2.GaussianBlur(alpha, (3, 3), 0)
        fold = f.get('fold', 0)
        label = f.get('label', 'open')
        tips = np.array(f['tips_px'], float)
        if fold < 0.02 and label == 'open' and all(f['tip_visible']):
            made = cut(bgr, alpha, tips)
            if made:
                c = made[1] - made[1].mean(0)
                thumb_right = sum(c[k, 0] * c[k + 1, 1] - c[k, 1] * c[k + 1, 0] for k in range(4)) < 0
                yield made + (int(right == thumb_right), OPEN)
        elif label in ('closed', 'four') or fold > 0.8:
            made = cut(bgr, alpha, None)
            if made:
                yield made[0], np.zeros((5, 2)), -1, CLOSED


def rows(path):
    for r in csv.DictReader(open(path)):
        tips = np.array([[float(r[f + '_x']), float(r[f + '_y'])] for f in ('thumb', 'index', 'middle', 'ring', 'little')])
        yield r, tips


def real_hands(real):
    for r, tips in rows(os.path.join(real, 'stills', 'fingertips.csv')):
        if r['source'] in STILLS:
            bgr = cv2.imread(os.path.join(real, 'stills', r['file']))
            yield bgr, tips
    wanted = {}
    for r, tips in rows(os.path.join(real, 'clips', 'fingertips.csv')):
        if r['clip'] in CLIPS:
            wanted.setdefault(r['clip'], {})[int(r['frame'])] = tips
    for clip, frames in wanted.items():
        video = cv2.VideoCapture(os.path.join(real, 'clips', clip))
        for i in range(max(frames) + 1):
            ok, bgr = video.read()
            if ok and i in frames:
                yield bgr, frames[i]


def grab(bgr, tips):
    """Alpha of the hand with these fingertips in a photograph, by GrabCut; None when it fails."""
    palm = palm_of(tips)
    span = np.linalg.norm(tips - palm, axis=1).max() * 1.4
    px = lambda p: tuple(int(round(v)) for v in p)
    mask = np.full(bgr.shape[:2], cv2.GC_BGD, np.uint8)
    for tip in tips:
        cv2.line(mask, px(palm), px(tip + 0.06 * (tip - palm)), cv2.GC_PR_BGD, int(0.24 * span))
    cv2.circle(mask, px(palm), int(0.34 * span), cv2.GC_PR_FGD, -1)
    for tip in tips:
        cv2.line(mask, px(palm), px(tip), cv2.GC_PR_FGD, int(0.1 * span))
    for a, b in zip(tips[:-1], tips[1:]):
        between = 0.5 * (a + b)
        if np.linalg.norm(a - b) > 0.2 * span:
            cv2.line(mask, px(palm + 0.74 * (between - palm)), px(palm + 1.2 * (between - palm)), cv2.GC_BGD, max(1, int(0.03 * span)))
    for tip in tips:
        cv2.line(mask, px(palm), px(palm + 0.95 * (tip - palm)), cv2.GC_FGD, max(1, int(0.035 * span)))
    cv2.circle(mask, px(palm), int(0.18 * span), cv2.GC_FGD, -1)
    cv2.grabCut(bgr, mask, None, np.zeros((1, 65)), np.zeros((1, 65)), 6, cv2.GC_INIT_WITH_MASK)
    hand = ((mask == cv2.GC_FGD) | (mask == cv2.GC_PR_FGD)).astype(np.uint8)
    count, labels = cv2.connectedComponents(hand)
    hand = labels == labels[px(palm)[::-1]]
    if not 0.15 < hand.sum() / span ** 2 < 0.75:
        return None
    return cv2.GaussianBlur(255 * hand.astype(np.uint8), (3, 3), 0)


def backgrounds(folders, plates):
    for folder in folders:
        for root, _, files in os.walk(folder):
            for name in sorted(files):
                path = os.path.join(root, name)
                if not name.lower().endswith(('.jpg', '.jpeg', '.webp', '.png')) or os.path.getsize(path) < 30000:
                    continue
                bgr = cv2.imread(path, cv2.IMREAD_COLOR)
                if bgr is None or min(bgr.shape[:2]) < 150:
                    continue
                if (np.abs(np.diff(bgr.astype(np.int16), axis=1)).max(2) == 0).mean() > 0.45 and len(name) % 6:
                    continue  # drawings: flat areas; some of them will do
                s = 420 / max(bgr.shape[:2])
                yield cv2.resize(bgr, None, fx=min(1, s), fy=min(1, s), interpolation=cv2.INTER_AREA), 0
    for folder in plates:
        for path in sorted(glob.glob(os.path.join(folder, '**', '*.exr'), recursive=True)):
            if os.path.basename(path).startswith(('alb', 'nrm', 'aov')):
                continue
            e = cv2.imread(path, cv2.IMREAD_UNCHANGED)[..., :3]
            bgr = (np.clip(np.nan_to_num(e), 0, 1) ** (1 / 2.2) * 255).astype(np.uint8)
            yield cv2.resize(bgr, (560, 478), interpolation=cv2.INTER_AREA), 1


def pack(path, pictures, **more):
    sizes = np.array([p.shape[:2] for p in pictures])
    np.savez(path, data=np.concatenate([p.reshape(-1, p.shape[2]) for p in pictures]), sizes=sizes,
             **{k: np.array(v) for k, v in more.items()})


def main():
    ap = argparse.ArgumentParser()
    ap.add_argument('--out', required=True)
    ap.add_argument('--sequences', nargs='*', default=[], help='folders with truth.json')
    ap.add_argument('--step', type=int, default=1)
    ap.add_argument('--real')
    ap.add_argument('--backgrounds', nargs='*', default=[])
    ap.add_argument('--plates', nargs='*', default=[])
    ap.add_argument('--name', default='hands')
    a = ap.parse_args()
    pictures, tips, faces, kinds = [], [], [], []
    for folder in a.sequences:
        for picture, t, face, kind in sequence_hands(folder, a.step):
            pictures.append(picture); tips.append(t); faces.append(face); kinds.append(kind)
    if a.real:
        for bgr, t in real_hands(a.real):
            s = min(1, WHOLE_SIDE / max(bgr.shape[:2]))
            small = cv2.resize(bgr, None, fx=s, fy=s, interpolation=cv2.INTER_AREA)
            pictures.append(np.dstack([small, np.full(small.shape[:2], 255, np.uint8)]))
            tips.append((t + 0.5) * s - 0.5); faces.append(-1); kinds.append(WHOLE)
            alpha = grab(small, tips[-1])
            made = None if alpha is None else cut(small, alpha, tips[-1])
            if made:
                pictures.append(made[0]); tips.append(made[1]); faces.append(-1); kinds.append(OPEN)
    if pictures:
        pack(os.path.join(a.out, a.name + '.npz'), pictures, tips=tips, faces=faces, kinds=kinds)
        print(len(pictures), 'hands,', kinds.count(CLOSED), 'closed')
    if a.backgrounds or a.plates:
        found = list(backgrounds(a.backgrounds, a.plates))
        pack(os.path.join(a.out, 'backgrounds.npz'), [b for b, _ in found], people=[p for _, p in found])
        print(len(found), 'backgrounds')


if __name__ == '__main__':
    main()
