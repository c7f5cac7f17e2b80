# SPDX-License-Identifier: MIT
"""Random training pictures: hands of every angle, size and light pasted before anything."""
import os

import cv2
import numpy as np

from network import CELLS_X, CELLS_Y, HEIGHT, OUTPUTS, PALMS, STRIDE, TIPS, WIDTH

# What a picture of a hand is: rendered and not open; rendered; cut out of a photograph; a photograph as it is.
CLOSED, OPEN, PHOTOGRAPHED, WHOLE = range(4)
# Which face of it is seen.
PALM, BACK = range(2)

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
    def __init__(self, folder, seed):
        self.rng = np.random.default_rng(seed)
        self.hands, self.people, self.rooms = (Pack(os.path.join(folder, n + '.npz')) for n in ('hands', 'people', 'backgrounds'))
        self.noise = self.rng.standard_normal(4 * WIDTH * HEIGHT * 3).astype(np.float32)
        self.of_kind = [np.nonzero(self.hands.more['kinds'] == k)[0] for k in range(4)]

    def pick(self, kind):
        return self.rng.choice(self.of_kind[kind])

    # ---- pieces
    def recolour(self, bgr, strong):
        """Another light on bytes: gain for each channel, gamma, saturation."""
        r = self.rng
        gamma, gain = np.exp(r.normal(0, 0.3 * strong)), np.exp(r.normal(0, 0.25 * strong) + r.normal(0, 0.15 * strong, 3))
        saturation = np.exp(r.normal(0, 0.25 * strong))
        table = 255 * (np.arange(256) / 255)[None, :, None] ** gamma * gain
        x = cv2.LUT(bgr, table.astype(np.float32))
        grey = (1 - saturation) / 3
        return np.clip(cv2.transform(x, np.full((3, 3), grey) + saturation * np.eye(3)), 0, 255)

    def room(self):
        """A crop of a picture, in one of three with crops of others laid over it: rooms are full of things."""
        r, canvas = self.rng, self.crop()
        if r.random() < 0.35:
            for _ in range(r.integers(1, 13)):
                self.lay_over(canvas, self.crop())
        return canvas

    def lay_over(self, canvas, picture):
        """A part of a picture with an outline of its own, as large as a fingertip or as half the canvas."""
        r = self.rng
        size, stretch = np.exp(r.uniform(np.log(4), np.log(90))), np.exp(r.normal(0, 0.5))
        centre, angle = r.uniform([0, 0], [WIDTH, HEIGHT]), r.uniform(0, 180)
        mask = np.zeros((HEIGHT, WIDTH), np.uint8)
        box = (centre.tolist(), (float(size * stretch), float(size / stretch)), float(angle))
        if r.random() < 0.4:
            cv2.ellipse(mask, box, 255, -1)
        else:
            corners = cv2.boxPoints(box)
            cv2.fillPoly(mask, [np.rint(corners + size * r.normal(0, 0.12, (4, 2))).astype(int)], 255)
        alpha = cv2.GaussianBlur(mask, (0, 0), r.uniform(0.3, 1.2)).astype(np.float32)[..., None] / 255
        canvas += (picture - canvas) * alpha

    def crop(self):
        r = self.rng
        if r.random() < 0.06:
            a, b = r.uniform(0, 255, (2, 3))
            t = np.linspace(0, 1, WIDTH)[None, :, None] if r.random() < 0.5 else np.linspace(0, 1, HEIGHT)[:, None, None]
            return np.broadcast_to(a + (b - a) * t, (HEIGHT, WIDTH, 3)).astype(np.float32).copy()
        source = self.rooms[r.integers(len(self.rooms))]
        h, w = source.shape[:2]
        s = max(WIDTH / w, HEIGHT / h) * np.exp(r.uniform(0, 1.0))
        s = max(s if r.random() < 0.8 else 1 / np.exp(r.uniform(0, 0.8)), 0.3)
        c = (r.uniform(0.2, 0.8) * w, r.uniform(0.2, 0.8) * h)
        a = np.deg2rad(r.normal(0, 8) if r.random() < 0.8 else r.uniform(-180, 180))
        flip = -1 if r.random() < 0.5 else 1
        M = np.array([[s * np.cos(a) * flip, -s * np.sin(a), 0], [s * np.sin(a) * flip, s * np.cos(a), 0]])
        M[:, 2] = np.array([WIDTH / 2, HEIGHT / 2]) - M[:, :2] @ np.array(c)
        out = cv2.warpAffine(source, M, (WIDTH, HEIGHT), flags=cv2.INTER_LINEAR if s > 0.6 else cv2.INTER_AREA,
                             borderMode=cv2.BORDER_REFLECT_101)
        return self.recolour(out, 0.7)

    def background(self):
        """A room, often with somebody in it; a hand may be of that person's colour."""
        r, canvas, self.skin = self.rng, self.room(), None
        if r.random() < 0.4:
            i = r.integers(len(self.people))
            person, face = self.people[i], self.people.more['faces'][i]
            size = np.exp(r.uniform(np.log(50), np.log(330)))  # of the picture with head and shoulders
            # From the whole of it to a face that fills the picture; what is cut off below stays below.
            around = (WIDTH * r.uniform(0.1, 0.9), HEIGHT * r.uniform(0.15, 0.6))
            M = self.placing(face, person.shape[0], around, size, size, level=True)
            below = M[:, :2] @ [person.shape[1] / 2, person.shape[0]] + M[:, 2]
            if below[1] < HEIGHT:
                M[1, 2] += HEIGHT - below[1]
            self.paste(canvas, person, M, 0.5)
            x, y = np.rint(M[:, :2] @ face + M[:, 2]).astype(int)
            if r.random() < 0.6 and 2 <= x < WIDTH - 2 and 2 <= y < HEIGHT - 2:
                self.skin = canvas[y - 2:y + 3, x - 2:x + 3].mean((0, 1))
        return canvas

    def paste(self, canvas, picture, M, light, soft=0.0):
        """Lays a cut-out over the canvas, its edge blurred by so many pixels."""
        s = np.sqrt(abs(np.linalg.det(M[:, :2])))
        if s < 0.5:  # reduce by averaging first
            k = int(1 / s)
            h, w = picture.shape[0] // k, picture.shape[1] // k
            picture = cv2.resize(picture, (max(w, 1), max(h, 1)), interpolation=cv2.INTER_AREA)
            M = M @ np.array([[k, 0, (k - 1) / 2], [0, k, (k - 1) / 2], [0, 0, 1]])
        # Only where it comes to lie anything is done.
        h, w = picture.shape[:2]
        corners = np.array([[0, 0], [w, 0], [0, h], [w, h]]) @ M[:, :2].T + M[:, 2]
        x0, y0 = np.maximum(np.floor(corners.min(0)).astype(int) - 1, 0)
        x1, y1 = np.minimum(np.ceil(corners.max(0)).astype(int) + 2, [WIDTH, HEIGHT])
        if x0 >= x1 or y0 >= y1:
            return
        M = M - [[0, 0, x0], [0, 0, y0]]
        warped = cv2.warpAffine(picture, M, (x1 - x0, y1 - y0), flags=cv2.INTER_LINEAR)
        bgr, alpha = self.recolour(np.ascontiguousarray(warped[..., :3]), light), warped[..., 3].astype(np.float32) / 255
        if soft:
            alpha = cv2.GaussianBlur(alpha, (0, 0), soft)
        if self.skin is not None:
            mean = np.array(cv2.mean(bgr, warped[..., 3])[:3])
            bgr *= (self.skin * np.exp(self.rng.normal(0, 0.12, 3) + self.rng.normal(0, 0.15)) / np.maximum(mean, 4)).astype(np.float32)
            np.clip(bgr, 0, 255, out=bgr)
        if self.rng.random() < 0.3 and s < 3:  # its shadow on what is behind
            whole = np.zeros((HEIGHT, WIDTH), np.float32)
            whole[y0:y1, x0:x1] = alpha
            soft = cv2.GaussianBlur(np.roll(whole, self.rng.integers(-8, 9, 2), (0, 1)), (0, 0), self.rng.uniform(1, 5))
            canvas *= (1 - self.rng.uniform(0.1, 0.6) * soft)[..., None]
        there = canvas[y0:y1, x0:x1]
        there += (bgr - there) * alpha[..., None]

    def placing(self, centre, size, around, least, most, level=False, flat=False):
        """Turned by any angle (or about level), a little sheared, of a size drawn evenly in its logarithm.

        What is flat cannot be turned in space: it is squashed as if it were tilted.
        """
        r = self.rng
        s = np.exp(r.uniform(np.log(least), np.log(most))) / size
        a = np.deg2rad(r.normal(0, 5) if level else r.normal(0, 25) if r.random() < 0.6 else r.uniform(-180, 180))
        flip = -1 if r.random() < 0.5 else 1
        shear = np.array([[np.exp(r.normal(0, 0.08)), r.normal(0, 0.08)], [0, 1]])
        if flat:
            b, squash = r.uniform(0, np.pi), r.uniform(0.65, 1)
            away = np.array([np.cos(b), np.sin(b)])
            shear = shear + (squash - 1) * np.outer(away, away)
        L = s * np.array([[np.cos(a), -np.sin(a)], [np.sin(a), np.cos(a)]]) @ shear @ np.diag([flip, 1])
        M = np.zeros((2, 3))
        M[:, :2] = L
        M[:, 2] = np.asarray(around) - L @ centre
        return M

    def beside(self, canvas, hand, places, size):
        """Something long about some of the places, like a finger that is none: a rod, a box, a strip of another picture.

        What comes to lie there is often of the hand's colour, and often partly behind the hand.
        """
        r = self.rng
        for at in places:
            long, wide, angle = size * r.uniform(0.2, 0.9), size * r.uniform(0.05, 0.2), r.uniform(0, 2 * np.pi)
            way = np.array([np.cos(angle), np.sin(angle)])
            a = at + size * r.normal(0, 0.12, 2)
            ends = np.rint([a, a + long * way]).astype(int)
            mask = np.zeros((HEIGHT, WIDTH), np.uint8)
            if r.random() < 0.5:
                cv2.line(mask, ends[0].tolist(), ends[1].tolist(), 255, max(1, round(wide)))
            else:
                off = 0.5 * wide * np.array([-way[1], way[0]])
                cv2.fillPoly(mask, [np.rint([a - off, a + off, a + long * way + off, a + long * way - off]).astype(int)], 255)
            what = r.random()
            if what < 0.3:
                picture = self.room()
            else:
                colour = np.array(cv2.mean(hand[..., :3], hand[..., 3])[:3]) * np.exp(r.normal(0, 0.1, 3) + r.normal(0, 0.25)) if what < 0.75 else r.uniform(0, 255, 3)
                y, x = np.mgrid[0:HEIGHT, 0:WIDTH]
                across = ((y - a[1]) * way[0] - (x - a[0]) * way[1]) / max(wide, 1)  # light falls off across it
                picture = np.clip(colour * (1 + r.normal(0, 0.5) * across - r.uniform(0, 1) * across ** 2)[..., None], 0, 255)
            alpha = cv2.GaussianBlur(mask, (0, 0), r.uniform(0.3, 1.0)).astype(np.float32)[..., None] / 255
            canvas += (picture.astype(np.float32) - canvas) * alpha

    def lamp(self, canvas, across):
        """Light that falls off from one side to the other, within so many pixels about the middle."""
        angle, fall = self.rng.uniform(0, 2 * np.pi), self.rng.uniform(0, 0.7)
        y, x = np.ogrid[0:HEIGHT, 0:WIDTH]
        along = ((x - WIDTH / 2) * np.cos(angle) + (y - HEIGHT / 2) * np.sin(angle)) / across
        canvas *= np.clip(1 + fall * along, 0.1, 1.8)[..., None]
        np.clip(canvas, 0, 255, out=canvas)

    def sharpen(self, canvas):
        """As webcams do."""
        canvas += self.rng.uniform(0.3, 2) * (canvas - cv2.GaussianBlur(canvas, (0, 0), self.rng.uniform(0.8, 2)))
        np.clip(canvas, 0, 255, out=canvas)

    def finish(self, x):
        """What cameras do: light, blur, noise, compression."""
        r = self.rng
        if r.random() < 0.2:
            x = cv2.GaussianBlur(x, (0, 0), r.uniform(0.4, 1.3))
        if r.random() < 0.12:
            k = np.zeros((9, 9), np.float32)
            a, l = r.uniform(0, np.pi), r.uniform(1.5, 4)
            cv2.line(k, tuple(int(round(4 - l * v)) for v in (np.cos(a), np.sin(a))), tuple(int(round(4 + l * v)) for v in (np.cos(a), np.sin(a))), 1)
            x = cv2.filter2D(x, -1, k / k.sum())
        if r.random() < 0.12:  # a dim room
            x = x * r.uniform(0.2, 0.7)
        x = x.astype(np.uint8)
        if r.random() < 0.4:
            x = self.recolour(x, 0.7)
        if r.random() < 0.5:
            at = r.integers(len(self.noise) - x.size)
            x = np.clip(x + r.uniform(1, 9) * self.noise[at:at + x.size].reshape(x.shape), 0, 255)
        if r.random() < 0.06:
            x = np.repeat(x.mean(2, keepdims=True), 3, 2)
        x = x.astype(np.uint8)
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
        if r.random() < 0.28:
            picture = self.hands[self.pick(CLOSED)]
            c, side = np.array(picture.shape[1::-1]) / 2, max(picture.shape[:2])
            M = self.placing(c, side, r.uniform([0, 0], [WIDTH, HEIGHT]), 25, 160)
            if r.random() < 0.5:
                side *= np.sqrt(abs(np.linalg.det(M[:, :2])))
                self.beside(canvas, picture, M @ [*c, 1] + side * r.normal(0, 0.25, (r.integers(1, 4), 2)), 0.5 * side)
            self.paste(canvas, picture, M, 0.5)
        kind = r.random()
        if kind < 0.1:
            hands += self.add(canvas, WHOLE, 28, 95)
        elif kind < 0.8:
            for _ in range(2 if r.random() < 0.08 else 1):
                # Of photographs there are few: they are taken more often than their number says.
                hands += self.add(canvas, PHOTOGRAPHED if r.random() < 0.25 else OPEN, 19, 105)
        if r.random() < 0.25:
            self.lamp(canvas, r.uniform(60, 160))
        if r.random() < 0.15:
            self.sharpen(canvas)
        return self.finish(canvas), hands

    def add(self, canvas, kind, least, most):
        r, i = self.rng, self.pick(kind)
        picture, tips = self.hands[i], self.hands.more['tips'][i]
        palm = palm_of(tips)
        size = np.linalg.norm(tips - palm, axis=1).max() * 1.4  # about the span, whatever the tilt
        around = (r.uniform(10, WIDTH - 10), r.uniform(8, HEIGHT - 8))
        M = self.placing(0.5 * (palm + tips.mean(0)), size, around, least, most, flat=kind in (PHOTOGRAPHED, WHOLE) and r.random() < 0.6)
        if kind != WHOLE and r.random() < 0.25:  # a dark hand before a window, a hand lit in a dark room
            canvas *= r.uniform(1.2, 2.0) if r.random() < 0.5 else r.uniform(0.1, 0.7)
            np.clip(canvas, 0, 255, out=canvas)
        soft = 0.0
        if kind != WHOLE and r.random() < 0.1:  # what is behind blurred by the camera's program, and the hand's edge with it
            soft = r.uniform(0.5, 2)
            canvas[:] = cv2.GaussianBlur(canvas, (0, 0), r.uniform(1.5, 6))
        placed, palm = self.hand_tips(M, tips), M @ [*palm, 1]
        if kind != WHOLE and r.random() < 0.35:
            fingers = r.choice(5, r.integers(1, 4), p=[0.5, 0.1, 0.05, 0.1, 0.25])
            self.beside(canvas, picture, palm + (placed[fingers] - palm) * r.uniform(0.3, 1.2, (len(fingers), 1)), np.linalg.norm(placed - palm, axis=1).max() * 1.4)
        self.paste(canvas, picture, M, 0.4, soft)
        return [placed]

    def target(self, hands):
        """Maps as network.py has them, and how much each cell of them counts."""
        y, x = np.ogrid[0:CELLS_Y, 0:CELLS_X]
        target = np.zeros((OUTPUTS, CELLS_Y, CELLS_X), np.float32)
        weight = np.ones((OUTPUTS, CELLS_Y, CELLS_X), np.float32)
        for tips in hands:
            t = (tips + 0.5) / STRIDE - 0.5
            palm = palm_of(t)
            inside = (tips > 0).all(1) & (tips < [WIDTH, HEIGHT]).all(1)
            span = max(np.linalg.norm(t - palm, axis=1).max() * 1.4, 1)
            sigma = np.clip(span / 14, 0.7, 1.6)
            bump = lambda c: np.exp(-(x - c[0]) ** 2 / (2 * sigma ** 2)) * np.exp(-(y - c[1]) ** 2 / (2 * sigma ** 2))
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
