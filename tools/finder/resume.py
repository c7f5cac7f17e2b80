# SPDX-License-Identifier: MIT
"""Takes the weights in the source back into a network that can be trained on.

  resume.py ../../src/find/finder_weights.inc finder.pt --data SET, or ../../src/find/face_weights.inc face.pt

Folded batch normalisation is split again: each gets the mean and the variance that its convolution
has on training pictures, and what undoes them, so that the network computes what it did.
"""
import argparse
import re

import numpy as np
import torch

from face import FaceNetwork, FaceSamples
from network import Finder
from samples import Samples
from train import as_input


def read_blocks(path):
    """Weights [n, outputs] and biases of each block, in the file's order."""
    text = open(path).read()
    body = lambda name: re.search(name + r'\[\] = \{(.*?)\n\};|' + name + r'\[\] = \{(.*?)\};', text, re.S)
    numbers = lambda name: re.findall(r'-?\d+(?:\.\d+)?(?:e[-+]?\d+)?', ''.join(filter(None, body(name).groups())))
    table = np.array(numbers('kBlocks'), int).reshape(-1, 2)
    scales, weights = np.array(numbers('kScales'), float), np.array(numbers('kWeights'), int)
    for size, outputs in table:
        yield weights[:size].reshape(-1, outputs) * scales[:outputs], scales[outputs:2 * outputs]
        weights, scales = weights[size:], scales[2 * outputs:]


def main():
    ap = argparse.ArgumentParser()
    ap.add_argument('source')
    ap.add_argument('out')
    ap.add_argument('--data', required=True)
    a = ap.parse_args()
    blocks = list(read_blocks(a.source))
    kinds = ((Finder, Samples), (FaceNetwork, FaceSamples))
    net, samples = next((n().eval(), s(a.data, 5)) for n, s in kinds if len(n().convolutions()) == len(blocks))
    moments = {}
    for (conv, norm), (w, b) in zip(net.convolutions(), blocks):
        n_out, n_in, h, v = conv.weight.shape
        w = w.reshape(h, v, n_in, n_out).transpose(3, 2, 0, 1)
        conv.weight.data = torch.tensor(np.ascontiguousarray(w), dtype=torch.float32)
        if norm is None:
            conv.bias.data = torch.tensor(b, dtype=torch.float32)
            continue
        norm.running_mean.zero_()
        norm.running_var.fill_(1 - norm.eps)
        norm.bias.data = torch.tensor(b, dtype=torch.float32)
        conv.register_forward_hook(lambda _, __, y, norm=norm: moments.update(
            {norm: (y.mean((0, 2, 3)), y.var((0, 2, 3)))}))
    pictures = torch.from_numpy(np.stack([samples.sample()[0] for _ in range(256)]))
    with torch.no_grad():
        before = net(as_input(pictures[:8]))
        net(as_input(pictures))
        for norm, (mean, variance) in moments.items():
            norm.bias += mean
            norm.weight.copy_(torch.sqrt(variance + norm.eps))
            norm.running_mean.copy_(mean)
            norm.running_var.copy_(variance)
        for conv, _ in net.convolutions():
            conv._forward_hooks.clear()
        print('largest change of an output:', (net(as_input(pictures[:8])) - before).abs().max().item())
    torch.save(net.state_dict(), a.out)


if __name__ == '__main__':
    main()
