"""Renders one of Fathom's scene files with Blender's Cycles: blender -b --factory-startup -P cycles.py -- SCENE.json
OUT.exr SPP SEED THREADS. Prints "seconds S", the time of the render call.

It knows quads, meshes in PLY files and whole .glb files, the materials kd, ke and metallicRoughness without extensions,
a constant background and a camera by eye and target, and refuses everything else. Nothing is clamped, denoised or sampled
adaptively."""
import json
import math
import os
import sys
import time

import bpy
import numpy
from mathutils import Matrix, Vector

numpy.bool = bool  # Debian's importer of 3.4 names it so, and Debian's numpy has no such name any more

scene_path, out, spp, seed, threads = sys.argv[sys.argv.index("--") + 1:]
scene = json.load(open(scene_path))
folder = os.path.dirname(os.path.abspath(scene_path))


def refuse(what):
    sys.exit(f"cycles.py: {scene_path}: {what} is not known here")


def material(name, m):
    made = bpy.data.materials.new(name)
    made.use_nodes = True
    nodes, links = made.node_tree.nodes, made.node_tree.links
    nodes.clear()
    output = nodes.new("ShaderNodeOutputMaterial")
    rgba = lambda c: (*c, 1)
    if m.get("model") == "metallicRoughness":
        unknown = set(m) - {"model", "baseColor", "metallic", "roughness"}
        if unknown:
            refuse(f"material {name}: {unknown}")
        node = nodes.new("ShaderNodeBsdfPrincipled")
        node.distribution = "GGX"
        node.inputs["Base Color"].default_value = rgba(m.get("baseColor", [1, 1, 1]))
        node.inputs["Metallic"].default_value = m.get("metallic", 0)
        node.inputs["Roughness"].default_value = m.get("roughness", 0.5)
        links.new(node.outputs[0], output.inputs["Surface"])
        return made
    unknown = set(m) - {"kd", "ke"}
    if unknown:
        refuse(f"material {name}: {unknown}")
    diffuse = nodes.new("ShaderNodeBsdfDiffuse")
    diffuse.inputs["Color"].default_value = rgba(m.get("kd", [0.5, 0.5, 0.5]))
    light = nodes.new("ShaderNodeEmission")
    light.inputs["Color"].default_value = rgba(m.get("ke", [0, 0, 0]))
    both = nodes.new("ShaderNodeAddShader")
    links.new(diffuse.outputs[0], both.inputs[0])
    links.new(light.outputs[0], both.inputs[1])
    links.new((both if "ke" in m else diffuse).outputs[0], output.inputs["Surface"])
    return made


def add(mesh, name, made):
    mesh.materials.clear()
    mesh.materials.append(made)
    bpy.context.collection.objects.link(bpy.data.objects.new(name, mesh))


for thing in list(bpy.data.objects):
    bpy.data.objects.remove(thing)
materials = {name: material(name, m) for name, m in scene.get("materials", {}).items()}
for thing in scene["objects"]:
    if thing["type"] == "quad":
        c, u, v = (Vector(thing[key]) for key in ("center", "u", "v"))
        mesh = bpy.data.meshes.new("quad")
        mesh.from_pydata([c - u - v, c + u - v, c + u + v, c - u + v], [], [(0, 1, 2, 3)])
        add(mesh, "quad", materials[thing["material"]])
    elif thing["type"] == "mesh" and thing["file"].endswith(".glb"):
        bpy.ops.import_scene.gltf(filepath=os.path.join(folder, thing["file"]))
        y_up = Matrix(((1, 0, 0), (0, 0, 1), (0, -1, 0))).to_4x4()  # as in the file, undoing the importer's turn
        for root in (made for made in bpy.context.selected_objects if not made.parent):
            root.matrix_world = y_up @ root.matrix_world
    elif thing["type"] == "mesh":
        bpy.ops.import_mesh.ply(filepath=os.path.join(folder, thing["file"]))
        made = bpy.context.selected_objects[0]
        made.data.materials.clear()
        made.data.materials.append(materials[thing["material"]])
        made.select_set(False)
    else:
        refuse(thing["type"])

camera = scene["camera"]
eye, target = Vector(camera["eye"]), Vector(camera["target"])
z = (eye - target).normalized()
x = Vector(camera.get("up", [0, 1, 0])).cross(z).normalized()
lens = bpy.data.cameras.new("camera")
lens.sensor_fit = "VERTICAL"
lens.angle_y = math.radians(camera["fovy"])
lens.clip_start, lens.clip_end = 1e-3, 1e5
placed = bpy.data.objects.new("camera", lens)
bpy.context.collection.objects.link(placed)
placed.matrix_world = Matrix.Translation(eye) @ Matrix((x, z.cross(x), z)).transposed().to_4x4()

s = bpy.context.scene
s.camera = placed
world = bpy.data.worlds.new("world")
s.world = world
world.use_nodes = True
world.node_tree.nodes["Background"].inputs["Color"].default_value = (*scene.get("background", [0, 0, 0]), 1)
image, cycles = scene["image"], s.cycles
s.render.engine = "CYCLES"
cycles.device = "CPU"
cycles.samples, cycles.seed = int(spp), int(seed)
cycles.use_adaptive_sampling = cycles.use_denoising = False
cycles.sample_clamp_direct = cycles.sample_clamp_indirect = 0
cycles.blur_glossy = 0
cycles.caustics_reflective = cycles.caustics_refractive = True
cycles.pixel_filter_type, cycles.filter_width = "BOX", 1
depth = image.get("maxDepth", 16)
cycles.max_bounces = cycles.diffuse_bounces = cycles.glossy_bounces = depth - 1
cycles.transmission_bounces = cycles.transparent_max_bounces = depth - 1
s.render.threads_mode, s.render.threads = "FIXED", int(threads)
s.render.resolution_x, s.render.resolution_y, s.render.resolution_percentage = image["width"], image["height"], 100
s.render.image_settings.color_mode = "RGB"
s.render.image_settings.file_format, s.render.image_settings.color_depth = "OPEN_EXR", "32"
s.render.filepath = out
s.render.use_persistent_data = False
began = time.monotonic()
bpy.ops.render.render(write_still=True)
print(f"seconds {time.monotonic() - began:.3f}")
