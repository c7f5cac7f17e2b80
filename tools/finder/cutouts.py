# SPDX-License-Identifier: MIT
"""Renders training hands and people, each one another person in another light, as cut-outs.

  blender -b -t 1 -P cutouts.py -- RENDER_FOLDER --kind open|closed|people --first 1 --count 1000 --out DIR

Writes DIR/KIND/000001.png (colours and alpha) and DIR/KIND/000001.json: fingertips and roots of the
fingers in pixels and which face of the hand is seen, or where a person's face is. The same number gives the same picture. Blender is started once, so that a
picture takes about a second; numbers that are there are skipped. Hands whose fingertips cannot all be
seen are left out.
"""
import argparse
import functools
import json
import math
import os
import sys

import bpy
import numpy as np
from mathutils import Matrix, Vector

SIDE = 256
FINGERS = '12345'
SKINS = [('young_lightskinned_female_diffuse2', 1.0), ('young_lightskinned_male_diffuse', 1.0),
         ('young_lightskinned_male_diffuse3', 1.0), ('middleage_lightskinned_male_diffuse', 1.0),
         ('old_lightskinned_male_diffuse2', 1.0), ('old_darkskinned_male_diffuse', 0.8),
         ('middleage_darkskinned_male_diffuse', 1.0), ('middleage_darkskinned_female_diffuse', 0.9),
         ('young_darkskinned_male_diffuse', 1.1)]
# Colours of hair, linear: black, browns, blond, grey, red.
HAIR = [(0.008, 0.007, 0.007), (0.02, 0.012, 0.008), (0.06, 0.03, 0.015), (0.35, 0.22, 0.1), (0.25, 0.25, 0.25), (0.15, 0.04, 0.015)]
# Where the thumb of a hand that shows four fingers lies (fingers.py).
FOUR_AZ, FOUR_EL = (30, -22, -48), (48, 30, 14)


# ---- a hand in the frame of mhhand.py, millimetres
def posture(params, kind, r):
    """Directions of the fingers' segments (azimuth, elevation), and how far each is folded."""
    spread = {'spread': r.uniform(0.7, 1.25), 'easy': r.uniform(0.2, 0.9), 'together': r.uniform(-0.05, 0.3)}
    way = r.choice(['spread', 'easy', 'together', 'relaxed'], p=[0.18, 0.24, 0.34, 0.24])
    s = spread.get(way, r.uniform(0, 0.8))
    az = {f: [s * v for v in params['az'][f]] for f in '2345'}
    thumb = r.uniform(-38, 12)
    az['1'] = [v + thumb * w for v, w in zip(params['az']['1'], (1, 0.9, 0.8))]
    together = r.normal(0, 5) if r.random() < 0.5 else abs(r.normal(0, 14))  # all fingers bend together
    el = {}
    for f in '2345':
        root, middle, end = together + r.normal(0, 4), abs(r.normal(0, 8)), abs(r.normal(0, 4))
        el[f] = [root, root + middle, root + middle + end]
        apart = r.normal(0, 6 if f == '5' else 2)  # little fingers stand off more than others do
        az[f] = [v + apart + r.normal(0, 2.5) for v in az[f]]
    el['1'] = [v + r.normal(6, 9) for v in (10, 4, 2)]
    if way == 'relaxed':
        bent = r.uniform(0, 24)
        for f in '2345':
            el[f] = np.cumsum([bent * r.uniform(0, 1), bent + r.uniform(0, 8), 0.6 * bent]).tolist()
        el['1'] = [v + r.uniform(0, 35) for v in (10, 4, 2)]
    fold = dict.fromkeys(FINGERS, 0.0)
    if kind == 'closed':
        four = r.random() < 0.5
        if four or r.random() < 0.5:  # the thumb before the palm
            w = r.uniform(0.75, 1.1)
            az['1'] = [a + (b - a) * w for a, b in zip(az['1'], FOUR_AZ)]
            el['1'] = [a + (b - a) * w for a, b in zip(el['1'], FOUR_EL)]
        if not four:
            for f in r.permutation(list('2345'))[:r.integers(1, 5)]:
                fold[f] = r.uniform(0.7, 1.0)
            if r.random() < 0.3:  # a fist
                fold = {f: r.uniform(0.85, 1.0) for f in FINGERS}
    return az, el, fold


class Body:
    """MakeHuman's base mesh; what mhhand.py reads anew for each hand is read once."""

    def __init__(self, mhhand):
        self.mhhand = mhhand
        whole = mhhand.load_obj()
        mhhand.load_obj = lambda: (whole[0].copy(), *whole[1:])

        @functools.lru_cache(None)
        def shifts(name):
            rows = [l.split() for l in open(os.path.join(mhhand.MH, 'targets', name + '.target')) if l[0] != '#']
            rows = [x for x in rows if len(x) == 4]
            return np.array([int(x[0]) for x in rows]), np.array([[float(v) for v in x[1:]] for x in rows])

        def target(V, name, w):
            at, by = shifts(name)
            V[at] += w * by
        mhhand.target = target
        load, files = json.load, {}

        def load_once(file):
            if file.name not in files:
                files[file.name] = load(file)
            return files[file.name]
        mhhand.json.load = load_once
        self.vertices, self.uv, self.faces, self.face_uv, self.groups = whole
        self.skeleton = mhhand.json.load(open(os.path.join(mhhand.MH, 'default.mhskel')))
        self.weights = mhhand.json.load(open(os.path.join(mhhand.MH, 'default_weights.mhw')))['weights']


# ---- Blender
def mesh_object(name, vertices, faces, face_uv, material):
    mesh = bpy.data.meshes.new(name)
    mesh.from_pydata([tuple(map(float, v)) for v in vertices], [], [list(f) for f in faces])
    if face_uv is not None:
        layer = mesh.uv_layers.new(name='uv')
        layer.data.foreach_set('uv', np.array([c for f in face_uv for c in f], np.float32).ravel())
    mesh.polygons.foreach_set('use_smooth', [True] * len(mesh.polygons))
    thing = bpy.data.objects.new(name, mesh)
    bpy.context.collection.objects.link(thing)
    mesh.materials.append(material)
    return thing


def subdivided(thing, levels):
    modifier = thing.modifiers.new('subdivision', 'SUBSURF')
    modifier.levels = modifier.render_levels = levels
    return thing


def move_vertices(thing, vertices):
    thing.data.vertices.foreach_set('co', np.asarray(vertices, np.float32).ravel())
    thing.data.update()
    thing.update_tag()


class Material:
    """A principled material whose colour is a texture or a mix of two colours by noise."""

    def __init__(self, name, textured):
        self.material = bpy.data.materials.new(name)
        self.material.use_nodes = True
        tree = self.material.node_tree
        self.shader = tree.nodes['Principled BSDF']
        self.bump = tree.nodes.new('ShaderNodeBump')
        self.noise = tree.nodes.new('ShaderNodeTexNoise')
        self.where = tree.nodes.new('ShaderNodeTexCoord')
        tree.links.new(self.where.outputs['Object'], self.noise.inputs['Vector'])
        self.mix = tree.nodes.new('ShaderNodeMixRGB')
        if textured:
            self.image = tree.nodes.new('ShaderNodeTexImage')
            self.gamma = tree.nodes.new('ShaderNodeGamma')
            grey = tree.nodes.new('ShaderNodeRGBToBW')
            tint = tree.nodes.new('ShaderNodeMixRGB')
            tint.blend_type, tint.inputs['Fac'].default_value = 'MULTIPLY', 1
            self.tint = tint.inputs['Color2']
            mottle = tree.nodes.new('ShaderNodeValToRGB')
            mottle.color_ramp.elements[0].position, mottle.color_ramp.elements[1].position = 0.35, 0.65
            mottle.color_ramp.elements[0].color = (0.86, 0.74, 0.72, 1)
            self.mix.blend_type = 'MULTIPLY'
            for a, b in ((self.image.outputs['Color'], self.gamma.inputs['Color']), (self.gamma.outputs['Color'], tint.inputs['Color1']),
                         (tint.outputs['Color'], self.mix.inputs['Color1']), (self.noise.outputs['Fac'], mottle.inputs['Fac']),
                         (mottle.outputs['Color'], self.mix.inputs['Color2']), (self.image.outputs['Color'], grey.inputs['Color']),
                         (grey.outputs['Val'], self.bump.inputs['Height'])):
                tree.links.new(a, b)
        else:
            tree.links.new(self.noise.outputs['Fac'], self.mix.inputs['Fac'])
            tree.links.new(self.noise.outputs['Fac'], self.bump.inputs['Height'])
        tree.links.new(self.mix.outputs['Color'], self.shader.inputs['Base Color'])
        tree.links.new(self.bump.outputs['Normal'], self.shader.inputs['Normal'])

    def skin(self, render, r):
        name, gamma = SKINS[r.integers(len(SKINS))]
        self.image.image = bpy.data.images.load(os.path.join(render, 'assets', 'mh', 'skins', name + '.jpg'), check_existing=True)
        self.gamma.inputs['Gamma'].default_value = gamma * np.exp(r.normal(0, 0.12))
        self.tint.default_value = (*np.minimum(np.exp(r.normal(0, 0.07, 3) + r.normal(-0.05, 0.1)), 1.2), 1)
        self.mix.inputs['Fac'].default_value = r.uniform(0.2, 1)
        self.noise.inputs['Scale'].default_value = r.uniform(40, 110)
        self.bump.inputs['Strength'].default_value, self.bump.inputs['Distance'].default_value = r.uniform(0.1, 0.6), 0.0018
        self.shader.inputs['Roughness'].default_value, self.shader.inputs['Specular'].default_value = r.uniform(0.35, 0.65), r.uniform(0.2, 0.5)

    def cloth(self, r, dark=False):
        base = r.uniform(0.005, 0.08) * np.ones(3) if dark else r.uniform(0, 0.9, 3) ** 1.5
        base = np.clip(base.mean() + (base - base.mean()) * r.uniform(0, 1), 0, 1)
        other = r.uniform(0, 0.8, 3) if r.random() < 0.3 else base * r.uniform(0.4, 0.9)
        self.mix.inputs['Color1'].default_value, self.mix.inputs['Color2'].default_value = (*base, 1), (*other, 1)
        self.noise.inputs['Scale'].default_value = np.exp(r.uniform(np.log(5), np.log(400)))
        self.noise.inputs['Detail'].default_value = r.uniform(0, 6)
        self.bump.inputs['Strength'].default_value, self.bump.inputs['Distance'].default_value = r.uniform(0.2, 0.9), 0.004
        self.shader.inputs['Roughness'].default_value, self.shader.inputs['Specular'].default_value = r.uniform(0.6, 1), 0.2


class Studio:
    """Camera and lights, the camera at the origin, looking along -z."""

    def __init__(self, render):
        bpy.ops.wm.read_factory_settings(use_empty=True)
        self.scene = bpy.context.scene
        self.rooms = sorted(os.path.join(render, 'assets', 'hdri', n) for n in os.listdir(os.path.join(render, 'assets', 'hdri')))
        self.camera = bpy.data.cameras.new('camera')
        self.camera.sensor_width, self.camera.clip_start = 36, 0.02
        thing = bpy.data.objects.new('camera', self.camera)
        bpy.context.collection.objects.link(thing)
        self.scene.camera = thing
        self.lamp = bpy.data.lights.new('lamp', 'AREA')
        self.lamp_object = bpy.data.objects.new('lamp', self.lamp)
        bpy.context.collection.objects.link(self.lamp_object)
        self.world = bpy.data.worlds.new('world')
        self.scene.world = self.world
        self.world.use_nodes = True
        tree = self.world.node_tree
        self.sky, turn, where = (tree.nodes.new(n) for n in ('ShaderNodeTexEnvironment', 'ShaderNodeMapping', 'ShaderNodeTexCoord'))
        self.turn = turn.inputs['Rotation']
        tree.links.new(where.outputs['Generated'], turn.inputs['Vector'])
        tree.links.new(turn.outputs['Vector'], self.sky.inputs['Vector'])
        self.shine = tree.nodes['Background']
        tree.links.new(self.sky.outputs['Color'], self.shine.inputs['Color'])
        self.world.cycles.sampling_method, self.world.cycles.sample_map_resolution = 'MANUAL', 256
        s, c = self.scene, self.scene.cycles
        s.render.engine, c.device = 'CYCLES', 'CPU'
        s.render.resolution_x = s.render.resolution_y = SIDE
        s.render.film_transparent, s.view_settings.view_transform = True, 'Standard'
        s.render.image_settings.file_format, s.render.image_settings.color_mode = 'PNG', 'RGBA'
        c.samples, c.use_adaptive_sampling, c.use_denoising = 6, False, False
        c.max_bounces = c.diffuse_bounces = 1
        c.glossy_bounces, c.transmission_bounces, c.transparent_max_bounces = 0, 0, 2
        c.caustics_reflective = c.caustics_refractive = False
        c.sample_clamp_direct, c.sample_clamp_indirect = 8, 3

    def place(self, things, R, at, focal_px):
        """Puts things in front of the camera, of that focal length."""
        M = Matrix.Identity(4)
        for i in range(3):
            M[i][:3] = R[i]
            M[i][3] = at[i]
        for thing in things:
            thing.matrix_world = M
        self.focal_px, self.camera.lens = focal_px, focal_px / SIDE * self.camera.sensor_width

    def project(self, points):
        """Pixels of points (..., 3)."""
        return self.focal_px * points[..., :2] * [1, -1] / -points[..., 2:] + (SIDE - 1) / 2

    def light(self, r, middle):
        """A room turned anyhow, and mostly a lamp, from weak to the only light there is."""
        self.sky.image = bpy.data.images.load(self.rooms[r.integers(len(self.rooms))], check_existing=True)
        # Rooms have their floor at -z, the camera's pictures theirs at -y.
        self.turn.default_value = (-math.pi / 2 + r.normal(0, 0.3), r.uniform(0, 2 * math.pi), 0)
        lamp = r.random() < 0.65
        self.shine.inputs['Strength'].default_value = np.exp(r.normal(-1.2 if lamp else 0, 0.8))
        self.lamp_object.hide_render = not lamp
        way = r.normal(0, 1, 3) + [0, 0.5, 0.5]
        distance = r.uniform(0.5, 1.5)
        at = Vector(middle) + Vector(way).normalized() * distance
        self.lamp_object.location = at
        self.lamp_object.rotation_euler = (Vector(middle) - at).to_track_quat('-Z', 'Y').to_euler()
        self.lamp.size = r.uniform(0.05, 0.8)
        self.lamp.energy = np.exp(r.uniform(np.log(5), np.log(40))) * distance ** 2
        warm = r.uniform(0, 1)
        self.lamp.color = (1, 1 - 0.35 * warm, 1 - 0.75 * warm) if r.random() < 0.6 else (0.8, 0.9, 1)

    def shoot(self, path, r):
        """Renders at an exposure about the usual one; False if hardly anything is in view."""
        self.scene.render.filepath = path
        bpy.ops.render.render(write_still=True)
        image = bpy.data.images.load(path)
        pixels = np.empty(SIDE * SIDE * 4, np.float32)
        image.pixels.foreach_get(pixels)
        pixels = pixels.reshape(-1, 4)
        there = pixels[:, 3] > 0.5
        seen = there.sum() >= 400
        if seen:
            linear = np.maximum(pixels[:, :3], 0) ** 2.2
            level = np.percentile(linear[there].max(1), 80)
            linear *= np.exp(r.normal(np.log(0.45), 0.45)) / max(level, 1e-4)
            pixels[:, :3] = np.clip(linear, 0, 1) ** (1 / 2.2)
            image.pixels.foreach_set(pixels.ravel())
            image.filepath_raw, image.file_format = path, 'PNG'
            image.save()
        bpy.data.images.remove(image)
        return seen


def turned(x, y, z):
    c, s = np.cos([x, y, z]), np.sin([x, y, z])
    X = np.array([[1, 0, 0], [0, c[0], -s[0]], [0, s[0], c[0]]])
    Y = np.array([[c[1], 0, s[1]], [0, 1, 0], [-s[1], 0, c[1]]])
    Z = np.array([[c[2], -s[2], 0], [s[2], c[2], 0], [0, 0, 1]])
    return Z @ X @ Y


class Hands:
    def __init__(self, body, studio, render, closed):
        import mkrandom
        self.body, self.studio, self.render, self.kind, self.shape = body, studio, render, 'closed' if closed else 'open', mkrandom.hand_shape
        self.skin, self.cloth = Material('skin', True), Material('cloth', False)
        hand = self.hand(mkrandom.hand_shape(np.random.default_rng(0)))
        vertices, faces, uv = self.with_forearm(hand, hand.V0)
        self.thing = subdivided(mesh_object('hand', vertices * 0.001, faces, uv, self.skin.material), 1)
        # Fingertips are places of the skin, told where all fingers are apart.
        smooth, self.tips = self.smooth(), []
        for f in FINGERS:
            head, tail = hand.head['finger%s-3.R' % f] * 0.001, hand.tail['finger%s-3.R' % f] * 0.001
            length = np.linalg.norm(tail - head)
            way, off = (tail - head) / length, smooth - head
            along = off @ way
            near = np.nonzero((np.linalg.norm(off - np.outer(along, way), axis=1) < 0.013) & (along > 0.3 * length) & (along < 2.5 * length))[0]
            self.tips.append(near[np.argmax(along[near])])
        self.sleeve = mesh_object('sleeve', np.zeros((32 * 12, 3)), [(i * 32 + k, i * 32 + (k + 1) % 32, (i + 1) * 32 + (k + 1) % 32, (i + 1) * 32 + k)
                                                                     for i in range(11) for k in range(32)], None, self.cloth.material)
        self.sleeve.parent = self.thing

    def hand(self, params):
        return self.body.mhhand.Hand(dict(params, level=False))

    def with_forearm(self, hand, posed):
        """The hand's mesh, its forearm longer; faces are made the first time."""
        if not hasattr(self, 'border'):
            edges = {}
            for f, t in zip(hand.F, hand.FT):
                for i in range(len(f)):
                    a, b = f[i], f[(i + 1) % len(f)]
                    if edges.pop((b, a), None) is None:
                        edges[a, b] = (t[i], t[(i + 1) % len(f)])
            self.border = sorted({a for a, _ in edges})
            order = {v: i for i, v in enumerate(self.border)}
            n, m = len(hand.V0), len(self.border)
            ring = lambda v, j: v if j < 0 else n + j * m + order[v]
            self.faces = [list(f) for f in hand.F] + [[ring(b, j - 1), ring(a, j - 1), ring(a, j), ring(b, j)] for j in range(3) for a, b in edges]
            self.face_uv = [[tuple(hand.T[t]) for t in f] for f in hand.FT] + [[tuple(hand.T[v]), tuple(hand.T[u]), tuple(hand.T[u]), tuple(hand.T[v])]
                                                                             for _ in range(3) for u, v in edges.values()]
        rest = hand.V0[self.border]
        middle, low = rest.mean(0), rest[:, 1].min()
        rings = [np.column_stack([middle[0] + (rest[:, 0] - middle[0]) * k, np.full(len(rest), low - far), middle[2] + (rest[:, 2] - middle[2]) * k])
                 for far, k in ((60, 1.05), (250, 1.15), (500, 1.25))]
        return np.vstack([posed, *rings]), self.faces, self.face_uv

    def smooth(self):
        graph = bpy.context.evaluated_depsgraph_get()
        graph.update()
        evaluated = self.thing.evaluated_get(graph)
        mesh = evaluated.to_mesh()
        v = np.empty(len(mesh.vertices) * 3, np.float32)
        mesh.vertices.foreach_get('co', v)
        evaluated.to_mesh_clear()
        return v.reshape(-1, 3).astype(float)

    def dress(self, hand, vertices, r):
        self.sleeve.hide_render = r.random() > 0.45
        self.cloth.cloth(r)
        wrist = hand.head['wrist.R'][1]
        first, wide = wrist - (r.uniform(-5, 30) if r.random() < 0.5 else r.uniform(30, 160)), r.uniform(2, 12)
        angles = 2 * np.pi * np.arange(32) / 32
        rows = []
        for i, y in enumerate(first - np.array([-0.5, 0, 2, 8, 25, 60, 100, 160, 230, 320, 430, 560])):
            arm = vertices[np.argsort(np.abs(vertices[:, 1] - min(max(y, vertices[:, 1].min()), wrist)))[:14]]
            middle, radius = arm.mean(0), np.ptp(arm, axis=0) / 2
            grow = wide * (0.4 if i == 0 else 1 + 0.002 * (first - y)) + r.normal(0, 1, 32) * (i > 3)
            rows.append(np.column_stack([middle[0] + (radius[0] * 1.05 + grow) * np.cos(angles), np.full(32, y), middle[2] + (radius[2] * 1.05 + grow) * np.sin(angles)]))
        move_vertices(self.sleeve, np.vstack(rows) * 0.001)

    def take(self, path, r):
        hand = self.hand(self.shape(r))
        az, el, fold = posture(hand.P, self.kind, r)
        posed, heads, _ = hand.pose(az=az, el=el, fold=fold)
        vertices = self.with_forearm(hand, posed)[0]
        move_vertices(self.thing, vertices * 0.001)
        self.skin.skin(self.render, r)
        self.dress(hand, vertices, r)
        tips = self.smooth()[self.tips]
        # Palm or back to the camera, tilted to any side; a left hand is the mirror image.
        away = r.random() < 0.5
        tilt, to = abs(r.normal(0, 30)) if r.random() < 0.85 else r.uniform(0, 70), r.uniform(0, 2 * np.pi)
        R = turned(np.radians(tilt) * np.cos(to), np.radians(tilt) * np.sin(to), np.radians(r.normal(0, 20))) @ turned(0, np.pi if away else 0, 0)
        R = np.diag([-1.0 if r.random() < 0.5 else 1.0, 1, 1]) @ R
        distance = np.exp(r.uniform(np.log(0.2), np.log(0.9)))
        at = np.array([0, 0.03, -distance]) - R @ [0, 0.02, 0]
        self.studio.place([self.thing], R, at, r.uniform(720, 880) * distance)
        self.studio.light(r, at)
        bpy.context.view_layer.update()
        placed = tips @ R.T + at
        pixels = self.studio.project(placed)
        if self.kind == 'open' and not (self.visible(placed) and (pixels > 2).all() and (pixels < SIDE - 3).all()):
            return None
        if not self.studio.shoot(path, r):
            return None
        if self.kind != 'open':
            return dict(shows='back' if away else 'palm')
        roots = 0.001 * np.array([heads['finger%s-1.R' % f] for f in FINGERS]) @ R.T + at
        return dict(tips=pixels.round(2).tolist(), roots=self.studio.project(roots).round(2).tolist(), shows='back' if away else 'palm')

    def visible(self, placed):
        graph = bpy.context.evaluated_depsgraph_get()
        for p in placed:
            hit, where, *_ = bpy.context.scene.ray_cast(graph, Vector((0, 0, 0)), Vector(p).normalized(), distance=float(np.linalg.norm(p)))
            if hit and where.length < np.linalg.norm(p) - 0.012:
                return False
        return True


class People:
    """Heads and shoulders, dressed and mostly with hair; the arms hang and have no hands in view."""

    def __init__(self, body, studio, render):
        self.body, self.studio, self.render = body, studio, render
        self.skin, self.cloth, self.hair, self.eye = (Material(n, n == 'skin') for n in ('skin', 'cloth', 'hair', 'eye'))
        self.parts = {}
        # Hair hangs to the waist and before the face: it is cut there, and at the shoulders or the ears.
        neck = self.joint(body.vertices, 'head')
        before = lambda c: c[2] > 0.6 and abs(c[0]) < 0.85 and c[1] < 1.0
        for name, groups, material, keep in (
                ('body', ['body'], self.skin, None), ('shirt', ['helper-tights'], self.cloth, None), ('eyes', ['helper-l-eye', 'helper-r-eye'], self.eye, None),
                ('long hair', ['helper-hair'], self.hair, lambda c: not before(c)),
                ('hair', ['helper-hair'], self.hair, lambda c: not before(c) and c[1] > -1.8),
                ('short hair', ['helper-hair'], self.hair, lambda c: not before(c) and c[1] > 0.1)):
            faces = [i for i, g in enumerate(body.groups) if g in groups and (keep is None or keep(body.vertices[body.faces[i]].mean(0) - neck))]
            used = sorted({v for i in faces for v in body.faces[i]})
            order = {v: i for i, v in enumerate(used)}
            thing = mesh_object(name, body.vertices[used], [[order[v] for v in body.faces[i]] for i in faces],
                                [[tuple(body.uv[t]) for t in body.face_uv[i]] for i in faces], material.material)
            self.parts[name] = (subdivided(thing, 1), used)
        arms, names = np.zeros((2, len(body.vertices))), body.skeleton['bones']
        for bone in names:
            chain, b = [], bone
            while b:
                chain.append(b)
                b = names[b]['parent']
            for side, of in (('L', 0), ('R', 1)):
                if 'upperarm01.' + side in chain:
                    for v, w in body.weights.get(bone, []):
                        arms[of, v] += w
        self.arms = np.minimum(arms, 1)

    def joint(self, vertices, bone):
        return vertices[self.body.skeleton['joints'][self.body.skeleton['bones'][bone]['head']]].mean(0)

    def take(self, path, r):
        v = self.body.vertices.copy()
        for name, w in zip(('caucasian-male-young', 'african-female-young', 'asian-male-young'), r.dirichlet([0.7] * 3)):
            self.body.mhhand.target(v, name, w)
        v *= 0.1  # decimetres
        for side, of in (('L', 0), ('R', 1)):
            shoulder = self.joint(v, 'upperarm01.' + side)
            down = r.uniform(15, 55) if r.random() < 0.9 else -r.uniform(0, 20)
            R = turned(0, 0, np.radians(-down if side == 'L' else down))
            w = self.arms[of][:, None]
            v = v + w * ((v - shoulder) @ R.T + shoulder - v)
        head = self.joint(v, 'head')
        v = (v - head) @ np.diag([r.uniform(0.93, 1.07), r.uniform(0.93, 1.07), r.uniform(0.93, 1.07)])
        for thing, used in self.parts.values():
            move_vertices(thing, v[used])
        self.skin.skin(self.render, r)
        self.cloth.cloth(r)
        self.hair.cloth(r, dark=True)
        base = np.array(HAIR[r.integers(len(HAIR))]) * np.exp(r.normal(0, 0.3))
        self.hair.mix.inputs['Color1'].default_value, self.hair.mix.inputs['Color2'].default_value = (*base, 1), (*(0.5 * base), 1)
        self.eye.cloth(r, dark=True)
        worn = ['long hair', 'hair', 'short hair', None][r.choice(4, p=[0.25, 0.2, 0.4, 0.15])]
        for name in ('long hair', 'hair', 'short hair'):
            self.parts[name][0].hide_render = name != worn
        self.parts['shirt'][0].hide_render = r.random() < 0.08
        distance = np.exp(r.uniform(np.log(0.5), np.log(1.5)))
        R = turned(np.radians(r.normal(0, 10)), np.radians(np.clip(r.normal(0, 25), -70, 70)), np.radians(r.normal(0, 6)))
        at = np.array([0, 0.1, -distance])
        self.studio.place([thing for thing, _ in self.parts.values()], R, at, SIDE / 0.62 * distance)
        self.studio.light(r, at)
        if not self.studio.shoot(path, r):
            return None
        return dict(face=self.studio.project(R @ [0, 0.03, 0.1] + at).round(1).tolist())


def main():
    ap = argparse.ArgumentParser()
    ap.add_argument('render')
    ap.add_argument('--kind', required=True, choices=['open', 'closed', 'people'])
    ap.add_argument('--first', type=int, default=1)
    ap.add_argument('--count', type=int, required=True)
    ap.add_argument('--out', required=True)
    a = ap.parse_args(sys.argv[sys.argv.index('--') + 1:])
    sys.path[:0] = [os.path.join(a.render, 'tools')]
    import mhhand
    body, studio = Body(mhhand), Studio(a.render)
    maker = People(body, studio, a.render) if a.kind == 'people' else Hands(body, studio, a.render, a.kind == 'closed')
    folder = os.path.join(os.path.abspath(a.out), a.kind)
    os.makedirs(folder, exist_ok=True)
    for number in range(a.first, a.first + a.count):
        path = os.path.join(folder, '%06d' % number)
        if os.path.exists(path + '.json'):
            continue
        # Numbers of kinds do not meet, nor those of mkrandom.py.
        r = np.random.default_rng([number, ['open', 'closed', 'people'].index(a.kind), 20261126])
        told = maker.take(path + '.png', r)
        if told is not None:
            with open(path + '.json', 'w') as file:
                json.dump(told, file)


if __name__ == '__main__':
    main()
