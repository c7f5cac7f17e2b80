# SPDX-License-Identifier: MIT
"""A network half-way between where a round of training began and where it ended, either of the two.

  halfway.py start.pt finder.pt halfway.pt --data SET

What a round learns of its own pictures alone is weaker there, what both know is not (Wortsman et al.,
"Robust fine-tuning of zero-shot models", 2022). Normalisation is measured anew on training pictures.
"""
import argparse

import numpy as np
import torch

from face import network_of
from train import as_input


def main():
    ap = argparse.ArgumentParser()
    ap.add_argument('start')
    ap.add_argument('end')
    ap.add_argument('out')
    ap.add_argument('--data', required=True)
    a = ap.parse_args()
    start, end = torch.load(a.start), torch.load(a.end)
    net, kind = network_of({k: (start[k] + end[k]) / 2 if end[k].is_floating_point() else end[k] for k in end})
    samples = kind(a.data, 77)
    for layer in net.modules():
        if isinstance(layer, torch.nn.BatchNorm2d):
            layer.reset_running_stats()
            layer.momentum = None  # the mean of all
    with torch.no_grad():
        for _ in range(40):
            net(as_input(torch.from_numpy(np.stack([samples.sample()[0] for _ in range(48)]))))
    torch.save(net.state_dict(), a.out)


if __name__ == '__main__':
    main()
