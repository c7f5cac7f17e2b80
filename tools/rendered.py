# SPDX-License-Identifier: MIT
"""What the tools that measure need of a rendered sequence's truth.json."""


def write_camera(truth, path):
    """The true camera, as handyar reads it."""
    (fx, _, cx), (_, fy, cy), _ = truth['K']
    with open(path, 'w') as file:
        file.write(f'%YAML:1.0\n---\nimage_width: {truth["width"]}\nimage_height: {truth["height"]}\n'
                   f'camera_matrix: !!opencv-matrix\n   rows: 3\n   cols: 3\n   dt: d\n   data: [ {fx}, 0., {cx}, 0., {fy}, {cy}, 0., 0., 1. ]\n'
                   f'distortion_coefficients: !!opencv-matrix\n   rows: 1\n   cols: 5\n   dt: d\n   data: {truth["dist"]}\n')
