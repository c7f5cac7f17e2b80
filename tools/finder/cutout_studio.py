# SPDX-License-Identifier: MIT
"""What cutouts.py renders with: camera, lights, materials and meshes of Blender."""
import math
import os

import bpy
import numpy as np
from mathutils import Matrix, Vector

SIDE = 256
SKINS = [('young_lightskinned_female_diffuse2', 1.0), ('young_lightskinned_male_diffuse', 1.0),
         ('young_lightskinned_male_diffuse3', 1.0), ('middleage_lightskinned_male_diffuse', 1.0),
         ('old_lightskinned_male_diffuse2', 1.0), ('old_darkskinned_male_diffuse', 0.8),
         ('middleage_darkskinned_male_diffuse', 1.0), ('middleage_darkskinned_female_diffuse', 0.9),
         ('young_darkskinned_male_diffuse', 1.1)]


def turned(x, y, z):
    c, s = np.cos([x, y, z]), np.sin([x, y, z])
    X = np.array([[1, 0, 0], [0, c[0], -s[0]], [0, s[0], c[0]]])
    Y = np.array([[c[1], 0, s[1]], [0, 1, 0], [-s[1], 0, c[1]]])
    Z = np.array([[c[2], -s[2], 0], [s[2], c[2], 0], [0, 0, 1]])
    return Z @ X @ Y


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
