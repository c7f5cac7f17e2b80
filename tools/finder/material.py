# SPDX-License-Identifier: MIT
"""Packs what samples are drawn from: rendered cut-outs, hands of permitted photographs, backgrounds.

  material.py --out SET --cutouts DIR --real DATA/real --backgrounds DIR... --plates DIR...

Writes hands.npz (pictures with alpha, fingertips in finger order, the fingers' roots where rendered
and open, which kind each is, which face it shows: 0 palm, 1 back, -1 not told), people.npz (pictures
with alpha, where the face is) and backgrounds.npz. Which photographs are taken stands in
STILLS and CLIPS, by origin, so that the rest can be reported on.
"""
import argparse
import csv
import glob
import itertools
import json
import os

os.environ['OPENCV_IO_ENABLE_OPENEXR'] = '1'
import cv2
import numpy as np

from samples import BACK, CLOSED, OPEN, PALM, PHOTOGRAPHED, WHOLE, palm_of

SIDE = 208  # longest side of a cut-out, pixels
STILLS = ('SubhiH/HandsDataset', 'ardamavi/Sign-Language-Digits-Dataset')  # palms
CLIPS = ('wall_a.mp4', 'desk_stereo0.mp4', 'desk_stereo1.mp4')  # backs
WHOLE_SIDE = 320
MOST_OF_A_FOLDER = 300  # pictures of the same package look alike


def cut(bgr, alpha, places):
    """The part of a picture with a hand in it, reduced to SIDE. `places`: its fingertips, perhaps others after them."""
    ys, xs = np.nonzero(alpha > 20)
    if len(xs) < 400:
        return None
    x0, x1, y0, y1 = xs.min(), xs.max() + 1, ys.min(), ys.max() + 1
    if places is not None:  # of a long forearm only a hand's length
        tips = places[:5]
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
    if places is not None:
        places = (places - [x0, y0] + 0.5) * s - 0.5
    return rgba, places


def cutouts(folder, kind):
    """What cutouts.py has rendered of one kind, and what it tells of each."""
    for path in sorted(glob.glob(os.path.join(folder, kind, '*.json'))):
        rgba = cv2.imread(path[:-5] + '.png', cv2.IMREAD_UNCHANGED)
        if rgba is None:  # still being written
            continue
        # A path tracer's bright specks are single pixels.
        yield np.ascontiguousarray(cv2.medianBlur(np.ascontiguousarray(rgba[..., :3]), 3)), rgba[..., 3], json.load(open(path))


def rows(path):
    for r in csv.DictReader(open(path)):
        tips = np.array([[float(r[f + '_x']), float(r[f + '_y'])] for f in ('thumb', 'index', 'middle', 'ring', 'little')])
        yield r, tips


def real_hands(real):
    for r, tips in rows(os.path.join(real, 'stills', 'fingertips.csv')):
        if r['source'] in STILLS:
            bgr = cv2.imread(os.path.join(real, 'stills', r['file']))
            yield bgr, tips, PALM
    wanted = {}
    for r, tips in rows(os.path.join(real, 'clips', 'fingertips.csv')):
        if r['clip'] in CLIPS:
            wanted.setdefault(r['clip'], {})[int(r['frame'])] = tips
    for clip, frames in wanted.items():
        video = cv2.VideoCapture(os.path.join(real, 'clips', clip))
        for i in range(max(frames) + 1):
            ok, bgr = video.read()
            if ok and i in frames:
                yield bgr, frames[i], BACK


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


def pictures(paths):
    for path in paths:
        if os.path.getsize(path) < 30000:
            continue
        bgr = cv2.imread(path, cv2.IMREAD_COLOR)
        if bgr is None or min(bgr.shape[:2]) < 150:
            continue
        if (np.abs(np.diff(bgr.astype(np.int16), axis=1)).max(2) == 0).mean() > 0.45 and len(os.path.basename(path)) % 6:
            continue  # drawings: flat areas; some of them will do
        s = 420 / max(bgr.shape[:2])
        yield cv2.resize(bgr, None, fx=min(1, s), fy=min(1, s), interpolation=cv2.INTER_AREA)


def backgrounds(folders, plates):
    for folder in folders:
        paths = sorted(os.path.join(root, name) for root, _, files in os.walk(folder) for name in files
                       if name.lower().endswith(('.jpg', '.jpeg', '.webp', '.png')))
        np.random.default_rng(len(paths)).shuffle(paths)
        yield from itertools.islice(pictures(paths), MOST_OF_A_FOLDER)
    for folder in plates:
        for path in sorted(glob.glob(os.path.join(folder, '**', '*.exr'), recursive=True)):
            if os.path.basename(path).startswith(('alb', 'nrm', 'aov')):
                continue
            e = cv2.imread(path, cv2.IMREAD_UNCHANGED)[..., :3]
            bgr = (np.clip(np.nan_to_num(e), 0, 1) ** (1 / 2.2) * 255).astype(np.uint8)
            yield cv2.resize(bgr, (560, 478), interpolation=cv2.INTER_AREA)


def pack(path, pictures, **more):
    sizes = np.array([p.shape[:2] for p in pictures])
    np.savez(path, data=np.concatenate([p.reshape(-1, p.shape[2]) for p in pictures]), sizes=sizes,
             **{k: np.array(v) for k, v in more.items()})


def main():
    ap = argparse.ArgumentParser()
    ap.add_argument('--out', required=True)
    ap.add_argument('--cutouts')
    ap.add_argument('--real')
    ap.add_argument('--backgrounds', nargs='*', default=[])
    ap.add_argument('--plates', nargs='*', default=[])
    a = ap.parse_args()
    os.makedirs(a.out, exist_ok=True)
    pictures, tips, roots, kinds, faces = [], [], [], [], []

    def keep(picture, places, kind, face):
        pictures.append(picture)
        tips.append(np.zeros((5, 2)) if places is None else places[:5])
        roots.append(places[5:] if kind == OPEN else np.zeros((5, 2)))
        kinds.append(kind)
        faces.append(face)

    for bgr, t, face in real_hands(a.real) if a.real else ():
        s = min(1, WHOLE_SIDE / max(bgr.shape[:2]))
        small = cv2.resize(bgr, None, fx=s, fy=s, interpolation=cv2.INTER_AREA)
        t = (t + 0.5) * s - 0.5
        keep(np.dstack([small, np.full(small.shape[:2], 255, np.uint8)]), t, WHOLE, face)
        alpha = grab(small, t)
        made = None if alpha is None else cut(small, alpha, t)
        if made:
            keep(*made, PHOTOGRAPHED, face)
    for name, kind in (('open', OPEN), ('closed', CLOSED)) if a.cutouts else ():
        for bgr, alpha, told in cutouts(a.cutouts, name):
            made = cut(bgr, alpha, np.array(told['tips'] + told['roots']) if kind == OPEN else None)
            if made:
                keep(*made, kind, {'palm': PALM, 'back': BACK}[told['shows']] if kind == OPEN else -1)
    if pictures:
        pack(os.path.join(a.out, 'hands.npz'), pictures, tips=tips, roots=roots, kinds=kinds, faces=faces)
        print(*(f'{kinds.count(k)} {n},' for k, n in ((OPEN, 'open hands'), (CLOSED, 'others'), (PHOTOGRAPHED, 'photographed'), (WHOLE, 'photographs'))))
    if a.cutouts:
        people = [(np.dstack([bgr, alpha]), told['face']) for bgr, alpha, told in cutouts(a.cutouts, 'people')]
        pack(os.path.join(a.out, 'people.npz'), [p for p, _ in people], faces=[f for _, f in people])
        print(len(people), 'people')
    if a.backgrounds or a.plates:
        found = list(backgrounds(a.backgrounds, a.plates))
        pack(os.path.join(a.out, 'backgrounds.npz'), found)
        print(len(found), 'backgrounds')


if __name__ == '__main__':
    main()
