# SPDX-License-Identifier: MIT
"""Random training pictures: hands of every angle, size and light pasted before anything."""
import os

import cv2
import numpy as np

from network import CELLS_X, CELLS_Y, HEIGHT, OUTPUTS, PALMS, STRIDE, TIPS, WIDTH

CLOSED, OPEN, WHOLE = 0, 1, 2

# Fingertips and palm of an average hand, thumb right, y up, in metres.
MODEL_TIPS = np.array([[.0945, 0], [.045, .08], [0, .0955], [-.042, .0775], [-.072, .0415]])
MODEL_PALM = np.array([0, -.0287])


def thumb_right(tips):
    """Which layout five fingertips in a picture (y down) have."""
    c = tips - tips.mean(0)
    return sum(c[k, 0] * c[k + 1, 1] - c[k, 1] * c[k + 1, 0] for k in range(4)) < 0


# The palm by the fingertips: where the affine map that takes an average hand's to them has it.
# Mirrored hands have the same.
PALM_BY_TIPS = np.append(MODEL_PALM, 1) @ np.linalg.pinv(np.column_stack([MODEL_TIPS, np.ones(5)]))


def palm_of(tips):
    """Where the palm of five fingertips is."""
    return PALM_BY_TIPS @ tips


class Pack:
    """Pictures of different sizes in one file (material.py)."""

    def __init__(self, path):
        z = np.load(path)
        self.data, self.sizes = z['data'], z['sizes']
        self.at = np.concatenate([[0], np.cumsum(self.sizes[:, 0] * self.sizes[:, 1])])
        self.more = {k: z[k] for k in z.files if k not in ('data', 'sizes')}

    def __len__(self):
        return len(self.sizes)

    def __getitem__(self, i):
        return self.data[self.at[i]:self.at[i + 1]].reshape(*self.sizes[i], -1)


class Samples:
    def __init__(self, folder, names, seed):
        self.rng = np.random.default_rng(seed)
        self.packs = [Pack(os.path.join(folder, n + '.npz')) for n in names]
        self.backgrounds = Pack(os.path.join(folder, 'backgrounds.npz'))
        people = self.backgrounds.more['people']
        self.people, self.rooms = np.nonzero(people == 1)[0], np.nonzero(people == 0)[0]
        kinds = lambda k: [(p, i) for p in range(len(self.packs)) for i in np.nonzero(self.packs[p].more['kinds'] == k)[0]]
        self.open, self.closed, self.whole = kinds(OPEN), kinds(CLOSED), kinds(WHOLE)
        # Of photographs there are few: they are taken more often than their number says.
        self.photographed = [(p, i) for p, i in self.open if self.packs[p].more['faces'][i] < 0]

    def pick(self, items):
        return items[self.rng.integers(len(items))]

    # ---- pieces
    def recolour(self, bgr, strong):
        """Another light: gain for each channel, gamma, saturation."""
        r = self.rng
        x = bgr.astype(np.float32) / 255
        x = np.power(np.maximum(x, 1e-4), np.exp(r.normal(0, 0.3 * strong)))
        x *= np.exp(r.normal(0, 0.25 * strong) + r.normal(0, 0.15 * strong, 3)).astype(np.float32)
        grey = x.mean(2, keepdims=True)
        x = grey + (x - grey) * np.float32(np.exp(r.normal(0, 0.25 * strong)))
        return np.clip(x, 0, 1) * 255

    def background(self):
        r, self.skin = self.rng, None
        if r.random() < 0.06:
            a, b = r.uniform(0, 255, (2, 3))
            t = np.linspace(0, 1, WIDTH)[None, :, None] if r.random() < 0.5 else np.linspace(0, 1, HEIGHT)[:, None, None]
            return np.broadcast_to(a + (b - a) * t, (HEIGHT, WIDTH, 3)).astype(np.float32).copy()
        person = r.random() < 0.35
        source = self.backgrounds[self.pick(self.people if person else self.rooms)]
        h, w = source.shape[:2]
        if person:  # face and shoulders are about the middle
            s = np.exp(r.uniform(np.log(0.3), np.log(1.6)))
            c = (w / 2 + r.normal(0, 40), h * 0.49 + r.normal(0, 35))
        else:
            s = max(WIDTH / w, HEIGHT / h) * np.exp(r.uniform(0, 1.0))
            s = s if r.random() < 0.8 else 1 / np.exp(r.uniform(0, 0.8))
            c = (r.uniform(0.2, 0.8) * w, r.uniform(0.2, 0.8) * h)
            s = max(s, 0.3)
        if person:
            s = 1 / s if s > 1 else 1 / max(s, 0.16)
        a = np.deg2rad(r.normal(0, 8) if r.random() < 0.8 else r.uniform(-180, 180))
        flip = -1 if r.random() < 0.5 else 1
        M = np.array([[s * np.cos(a) * flip, -s * np.sin(a), 0], [s * np.sin(a) * flip, s * np.cos(a), 0]])
        M[:, 2] = np.array([WIDTH / 2, HEIGHT / 2]) - M[:, :2] @ np.array(c)
        out = cv2.warpAffine(source, M, (WIDTH, HEIGHT), flags=cv2.INTER_LINEAR if s > 0.6 else cv2.INTER_AREA,
                             borderMode=cv2.BORDER_REFLECT_101)
        out = self.recolour(out, 0.7)
        if person and r.random() < 0.6:  # the hand is of the person behind it
            x, y = np.clip(M[:, :2] @ np.array([w / 2, h * 0.45]) + M[:, 2], 6, [WIDTH - 7, HEIGHT - 7]).astype(int)
            self.skin = out[y - 6:y + 7, x - 6:x + 7].mean((0, 1))
        return out

    def paste(self, canvas, picture, M, light):
        """Lays a cut-out over the canvas; returns its alpha there."""
        s = np.sqrt(abs(np.linalg.det(M[:, :2])))
        if s < 0.5:  # reduce by averaging first
            k = int(1 / s)
            h, w = picture.shape[0] // k, picture.shape[1] // k
            picture = cv2.resize(picture, (max(w, 1), max(h, 1)), interpolation=cv2.INTER_AREA)
            M = M @ np.array([[k, 0, (k - 1) / 2], [0, k, (k - 1) / 2], [0, 0, 1]])
        bgr = self.recolour(picture[..., :3], light)
        if self.skin is not None and picture.shape[2] == 4:
            a = picture[..., 3:].astype(np.float32)
            mean = (bgr * a).sum((0, 1)) / max(a.sum(), 1)
            bgr = np.clip(bgr * (self.skin * np.exp(self.rng.normal(0, 0.12, 3) + self.rng.normal(0, 0.15)) / np.maximum(mean, 4)), 0, 255).astype(np.float32)
        warped = cv2.warpAffine(np.dstack([bgr, picture[..., 3].astype(np.float32)]), M, (WIDTH, HEIGHT), flags=cv2.INTER_LINEAR)
        alpha = np.clip(warped[..., 3:] / 255, 0, 1)
        if self.rng.random() < 0.3 and s < 3:  # its shadow on what is behind
            d = self.rng.integers(-8, 9, 2)
            soft = cv2.GaussianBlur(np.roll(alpha[..., 0], d, (0, 1)), (0, 0), self.rng.uniform(1, 5))
            canvas *= 1 - self.rng.uniform(0.1, 0.6) * soft[..., None]
        canvas *= 1 - alpha
        canvas += warped[..., :3] * alpha
        return alpha

    def placing(self, centre, size, around, least, most):
        """Turned by any angle, a little sheared, of a size drawn evenly in its logarithm."""
        r = self.rng
        s = np.exp(r.uniform(np.log(least), np.log(most))) / size
        a = np.deg2rad(r.normal(0, 25) if r.random() < 0.7 else r.uniform(-180, 180))
        flip = -1 if r.random() < 0.5 else 1
        shear = np.array([[np.exp(r.normal(0, 0.08)), r.normal(0, 0.08)], [0, 1]])
        L = s * np.array([[np.cos(a), -np.sin(a)], [np.sin(a), np.cos(a)]]) @ shear @ np.diag([flip, 1])
        M = np.zeros((2, 3))
        M[:, :2] = L
        M[:, 2] = np.asarray(around) - L @ centre
        return M

    def finish(self, x):
        """What cameras do: light, blur, noise, compression."""
        r = self.rng
        if r.random() < 0.4:
            x = self.recolour(x, 0.7)
        if r.random() < 0.2:
            x = cv2.GaussianBlur(x, (0, 0), r.uniform(0.4, 1.3))
        if r.random() < 0.08:
            k = np.zeros((9, 9), np.float32)
            a, l = r.uniform(0, np.pi), r.uniform(1.5, 4)
            cv2.line(k, tuple(int(round(4 - l * v)) for v in (np.cos(a), np.sin(a))), tuple(int(round(4 + l * v)) for v in (np.cos(a), np.sin(a))), 1)
            x = cv2.filter2D(x, -1, k / k.sum())
        if r.random() < 0.5:
            x = x + r.normal(0, r.uniform(1, 9), x.shape).astype(np.float32)
        if r.random() < 0.06:
            x = np.repeat(x.mean(2, keepdims=True), 3, 2)
        x = np.clip(x, 0, 255).astype(np.uint8)
        if r.random() < 0.3:
            x = cv2.imdecode(cv2.imencode('.jpg', x, [cv2.IMWRITE_JPEG_QUALITY, int(r.uniform(35, 90))])[1], 1)
        return x

    # ---- whole samples
    def hand_tips(self, M, tips):
        return tips @ M[:, :2].T + M[:, 2]

    def sample(self):
        """A picture and the fingertips of each open hand in it."""
        r = self.rng
        canvas, hands = self.background(), []
        if self.closed and r.random() < 0.2:
            p, i = self.pick(self.closed)
            picture = self.packs[p][i]
            c = np.array(picture.shape[1::-1]) / 2
            self.paste(canvas, picture, self.placing(c, max(picture.shape[:2]), r.uniform([0, 0], [WIDTH, HEIGHT]), 25, 120), 0.5)
        kind = r.random()
        if kind < 0.1 and self.whole:
            p, i = self.pick(self.whole)
            hands += self.add(canvas, p, i, 28, 95)
        elif kind < 0.8:
            count = 2 if r.random() < 0.08 else 1
            for _ in range(count):
                real = self.photographed and r.random() < 0.3
                hands += self.add(canvas, *self.pick(self.photographed if real else self.open), 19, 105)
        return self.finish(canvas), hands

    def add(self, canvas, p, i, least, most):
        r = self.rng
        pack = self.packs[p]
        picture, tips = pack[i], pack.more['tips'][i]
        palm = palm_of(tips)
        size = np.linalg.norm(tips - palm, axis=1).max() * 1.4  # about the span, whatever the tilt
        around = (r.uniform(10, WIDTH - 10), r.uniform(8, HEIGHT - 8))
        M = self.placing(0.5 * (palm + tips.mean(0)), size, around, least, most)
        if pack.more['kinds'][i] == OPEN and r.random() < 0.25:  # a dark hand before a window, a hand lit in a dark room
            canvas *= r.uniform(1.2, 2.0) if r.random() < 0.5 else r.uniform(0.1, 0.7)
            np.clip(canvas, 0, 255, out=canvas)
        self.paste(canvas, picture, M, 0.33)
        return [self.hand_tips(M, tips)]

    def target(self, hands):
        """Maps as network.py has them, and how much each cell of them counts."""
        y, x = np.mgrid[0:CELLS_Y, 0:CELLS_X]
        target = np.zeros((OUTPUTS, CELLS_Y, CELLS_X), np.float32)
        weight = np.ones((OUTPUTS, CELLS_Y, CELLS_X), np.float32)
        for tips in hands:
            t = (tips + 0.5) / STRIDE - 0.5
            palm = palm_of(t)
            inside = (tips > 0).all(1) & (tips < [WIDTH, HEIGHT]).all(1)
            span = max(np.linalg.norm(t - palm, axis=1).max() * 1.4, 1)
            sigma = np.clip(span / 14, 0.7, 1.6)
            bump = lambda c: np.exp(-((x - c[0]) ** 2 + (y - c[1]) ** 2) / (2 * sigma ** 2))
            at = 0 if thumb_right(t) else 1
            spot = bump(palm)
            if inside.sum() < 4:  # cut by the border: neither a hand nor none
                near = (np.hypot(x - palm[0], y - palm[1]) < 0.5 * span)
                weight[PALMS][:, near] = 0
                weight[TIPS] *= 0.1
                continue
            target[at] = np.maximum(target[at], spot)
            for f in range(5):
                target[2 + f] = np.maximum(target[2 + f], bump(t[f]))
        return target, weight
