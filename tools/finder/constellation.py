# SPDX-License-Identifier: MIT
"""How the fingertips of a hand lie to each other in pictures.

Of the fingertips of all training hands, thumb right, as complex numbers, turned and scaled onto
their mean (Procrustes), with each one missing and for all five: the mean, what whitens the rest,
and the missing one's place by the others.
"""
import os
import textwrap

import numpy as np

from samples import CLOSED, Pack, thumb_right

FINGERS = 5


class Constellation:
    """Of all fingertips but `missing` (5: of all)."""

    def __init__(self, hands, missing):
        self.known = [f for f in range(FINGERS) if f != missing]
        self.missing = missing
        m = hands[0] - hands[0, self.known].mean()
        m /= np.linalg.norm(m[self.known])
        for _ in range(20):
            x, _, _ = self.align(hands, m)
            m = x.mean(0)
            m -= m[self.known].mean()
            m /= np.linalg.norm(m[self.known])
        self.mean = m
        x, _, _ = self.align(hands, m)
        u = self.parts(x[:, self.known] - m[self.known])
        variance, axes = np.linalg.eigh(np.cov(u.T))
        dof = 2 * len(self.known) - 4
        self.whiten = (axes[:, -dof:] / np.sqrt(variance[-dof:])).T
        if missing < FINGERS:
            white = u @ self.whiten.T
            v = self.parts(x[:, [missing]] - m[missing])
            self.guess = np.linalg.lstsq(white, v, rcond=None)[0].T

    def align(self, z, mean):
        middle = z[:, self.known].mean(1, keepdims=True)
        scale = ((z - middle)[:, self.known] @ mean[self.known].conj())[:, None]  # their norm is 1
        return (z - middle) / scale, scale, middle

    @staticmethod
    def parts(z):
        return np.concatenate([z.real, z.imag], 1)

    def read(self, z):
        """Squared Mahalanobis distance, and all fingertips with the missing one where it is expected."""
        x, scale, middle = self.align(z, self.mean)
        white = self.parts(x[:, self.known] - self.mean[self.known]) @ self.whiten.T
        z = z.copy()
        if self.missing < FINGERS:
            v = white @ self.guess.T
            z[:, self.missing] = middle[:, 0] + scale[:, 0] * (self.mean[self.missing] + v[:, 0] + 1j * v[:, 1])
        return (white ** 2).sum(1), z


def constellations(folder):
    hands, pack = [], Pack(os.path.join(folder, 'hands.npz'))
    for tips, kind in zip(pack.more['tips'], pack.more['kinds']):
        if kind == CLOSED:
            continue
        z = tips[:, 0] + 1j * tips[:, 1]
        hands.append(z if thumb_right(tips) else -z.conj())
    hands = np.array(hands)
    return [Constellation(hands, missing) for missing in range(FINGERS + 1)]


def as_source(model):
    """As src/find/constellation.cpp reads it: mean, what whitens, how the missing one is guessed."""
    mean = model.parts(model.mean[None])
    whiten, guess = np.zeros((6, 10)), np.zeros((2, 6))
    whiten[:len(model.whiten), model.known + [FINGERS + f for f in model.known]] = model.whiten
    if model.missing < FINGERS:
        guess[:, :len(model.whiten)] = model.guess
    row = lambda v: '{%s}' % ', '.join('%.4g' % x for x in v)
    rows = lambda t: '{{%s}}' % ',\n     '.join(textwrap.fill(row(v), 93, subsequent_indent='      ') for v in t)
    return '  {%s,\n   %s,\n   %s},\n' % (row(mean[0]), rows(whiten), rows(guess))
