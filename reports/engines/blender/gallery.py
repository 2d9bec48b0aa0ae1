"""Inside Blender: the gallery, rendered by Cycles: blender -b -P gallery.py -- FOLDER WIDTH HEIGHT FRAMES

A bumpy glossy floor and wall, a fence of thin bars, a column that slides past, and a camera that drifts. Light comes
from one sun and does not bounce: of two lamps Cycles would choose one by chance for every sample, which is noise.
"""

import math
import sys
from pathlib import Path

import bpy

# Samples a pixel, and the width of the box that they are taken from.
BUILDS = {"aliased": (1, 0.01), "four-samples": (4, 1.0), "reference": (64, 1.0)}


def material(name, colour, roughness, bumps=0.0):
    made = bpy.data.materials.new(name)
    made.use_nodes = True
    nodes, links = made.node_tree.nodes, made.node_tree.links
    shader = nodes["Principled BSDF"]
    shader.inputs["Base Color"].default_value = (*colour, 1)
    shader.inputs["Roughness"].default_value = roughness
    if bumps:
        noise, bump, place = (nodes.new(f"ShaderNode{kind}") for kind in ("TexNoise", "Bump", "NewGeometry"))
        noise.inputs["Scale"].default_value = 25.0  # bumps of some 4 cm
        noise.inputs["Detail"].default_value = 0.0
        bump.inputs["Strength"].default_value = bumps
        links.new(place.outputs["Position"], noise.inputs["Vector"])
        links.new(noise.outputs["Fac"], bump.inputs["Height"])
        links.new(bump.outputs["Normal"], shader.inputs["Normal"])
    return made


def add(kind, look, location, scale=(1, 1, 1), rotation=(0, 0, 0), **options):
    getattr(bpy.ops.mesh, f"primitive_{kind}_add")(location=location, rotation=rotation, **options)
    bpy.context.object.scale = scale
    bpy.context.object.data.materials.append(look)
    return bpy.context.object


def sun(direction, strength):
    """A light without a penumbra, from a direction given as x, y, z."""
    light = bpy.data.lights.new("sun", "SUN")
    light.energy, light.angle = strength, 0.0
    lamp = bpy.data.objects.new("sun", light)
    lamp.rotation_euler = (
        math.atan2(math.hypot(*direction[:2]), direction[2]),
        0,
        math.atan2(direction[0], -direction[1]),
    )
    bpy.context.collection.objects.link(lamp)


def move(thing, frames, **places):
    """Straight from the frame before the first to the one after the last: vectors look at both neighbours."""
    for frame in (-1, frames):
        for name, (start, step) in places.items():
            setattr(thing, name, [a + frame * b for a, b in zip(start, step, strict=True)])
            thing.keyframe_insert(name, frame=frame)
    for curve in thing.animation_data.action.fcurves:
        for key in curve.keyframe_points:
            key.interpolation = "LINEAR"


def build_gallery(frames):
    bpy.ops.wm.read_factory_settings(use_empty=True)
    bumpy = material("bumpy", (0.5, 0.25, 0.1), 0.25, bumps=1.0)
    dark, blue = material("dark", (0.01, 0.01, 0.01), 0.8), material("blue", (0.05, 0.1, 0.3), 0.6)
    add("plane", bumpy, (0, 0, 0), (40, 20, 1), size=1.0)
    add("plane", bumpy, (0, 10, 6), (40, 12, 1), (math.radians(90), 0, 0), size=1.0)
    for bar in range(60):
        add("cube", dark, (-6 + 0.2 * bar, 6, 0.6), (0.015, 0.015, 1.2), (0, 0.1, 0), size=1.0)
    column = add("cylinder", blue, (0, 3, 3), vertices=48, radius=0.4, depth=6)
    move(column, frames, location=((-1.6, 3, 3), (0.06, 0, 0)))
    sun((-0.7, -0.35, 0.45), 3.0)
    camera = bpy.data.objects.new("camera", bpy.data.cameras.new("camera"))
    camera.data.angle = math.radians(70)
    bpy.context.collection.objects.link(camera)
    bpy.context.scene.camera = camera
    start = ((0, -4, 1.7), (math.radians(83), 0, 0))
    move(camera, frames, location=(start[0], (0.023, 0.03, 0.004)), rotation_euler=(start[1], (0, 0, 0.0015)))


def render(folder, size, frames):
    scene = bpy.context.scene
    scene.render.engine = "CYCLES"
    scene.render.resolution_x, scene.render.resolution_y = size
    scene.render.fps = 24
    scene.frame_start, scene.frame_end = 0, frames - 1
    scene.render.image_settings.file_format = "OPEN_EXR_MULTILAYER"
    scene.render.image_settings.color_depth = "32"
    scene.view_layers[0].use_pass_z = True
    scene.view_layers[0].use_pass_vector = True  # written only while motion blur is off, as it is by default
    scene.cycles.use_denoising = False
    scene.cycles.use_adaptive_sampling = False
    scene.cycles.max_bounces = 0
    scene.cycles.use_animated_seed = True
    scene.cycles.pixel_filter_type = "BOX"
    for build, (samples, width) in BUILDS.items():
        scene.cycles.samples, scene.cycles.filter_width = samples, width
        scene.render.filepath = str(folder / build / "####.exr")
        bpy.ops.render.render(animation=True)


folder, *numbers = sys.argv[sys.argv.index("--") + 1 :]
width, height, frames = map(int, numbers)
build_gallery(frames)
render(Path(folder), (width, height), frames)
