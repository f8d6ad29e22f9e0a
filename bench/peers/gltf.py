"""Renders the scenes of fidelity.sh with Blender's Cycles: blender -b --factory-startup -P gltf.py -- SCENES.json FOLDER
SPP SEED... writes FOLDER/NAME-SEED.exr, linear. Nothing is clamped, denoised or sampled adaptively.

What Blender's importer leaves open is set here as glTF has it: lights without a radius, one watt for each candela times
4 pi and for each lux ("compatible"), the camera's field by yfov. Scenes of the shading "matt" get Lambert's BSDF in
place of the importer's Principled BSDF, whose diffuse lobe is Disney's; textures, uvs, normals, colours and alpha are
taken as the importer linked them. Cycles knows no cutoff of alpha, so a node compares it."""
import json
import os
import sys

import bpy
import numpy

numpy.bool = bool  # Debian's importer of 3.4 names it so, and Debian's numpy has no such name any more

listed, folder, spp, *seeds = sys.argv[sys.argv.index("--") + 1:]


def take(tree, socket, to):
    """Links or copies what feeds `socket` to `to`."""
    if socket.is_linked:
        tree.links.new(socket.links[0].from_socket, to)
    else:
        to.default_value = socket.default_value


def make_matt(tree, threshold):
    principled = [n for n in tree.nodes if n.type == "BSDF_PRINCIPLED"]
    for old in principled:
        diffuse, light = tree.nodes.new("ShaderNodeBsdfDiffuse"), tree.nodes.new("ShaderNodeEmission")
        both, clear, mix = (tree.nodes.new("ShaderNode" + n) for n in ("AddShader", "BsdfTransparent", "MixShader"))
        take(tree, old.inputs["Base Color"], diffuse.inputs["Color"])
        if old.inputs["Normal"].is_linked:
            take(tree, old.inputs["Normal"], diffuse.inputs["Normal"])
        take(tree, old.inputs["Emission"], light.inputs["Color"])
        take(tree, old.inputs["Emission Strength"], light.inputs["Strength"])
        tree.links.new(diffuse.outputs[0], both.inputs[0])
        tree.links.new(light.outputs[0], both.inputs[1])
        take(tree, old.inputs["Alpha"], mix.inputs["Fac"])
        if threshold is not None:
            above = tree.nodes.new("ShaderNodeMath")
            above.operation, above.inputs[1].default_value = "GREATER_THAN", threshold
            take(tree, old.inputs["Alpha"], above.inputs[0])
            tree.links.new(above.outputs[0], mix.inputs["Fac"])
        tree.links.new(clear.outputs[0], mix.inputs[1])
        tree.links.new(both.outputs[0], mix.inputs[2])
        for link in list(old.outputs[0].links):
            tree.links.new(mix.outputs[0], link.to_socket)
        tree.nodes.remove(old)


def prepare(scene, wanted):
    world = bpy.data.worlds.new("world")
    scene.world = world
    world.use_nodes = True
    world.node_tree.nodes["Background"].inputs["Color"].default_value = (*wanted["background"], 1)
    for light in bpy.data.lights:
        light.shadow_soft_size = 0
        if light.type == "SUN":
            light.angle = 0
    for material in bpy.data.materials if wanted["shading"] == "matt" else []:
        if material.use_nodes:
            make_matt(material.node_tree, material.alpha_threshold if material.blend_method == "CLIP" else None)
    scene.camera = next(o for o in bpy.data.objects if o.type == "CAMERA")
    cycles = scene.cycles
    scene.render.engine, cycles.device = "CYCLES", "CPU"
    cycles.samples = int(spp)
    cycles.use_adaptive_sampling = cycles.use_denoising = False
    cycles.sample_clamp_direct = cycles.sample_clamp_indirect = cycles.blur_glossy = 0
    cycles.caustics_reflective = cycles.caustics_refractive = True
    cycles.pixel_filter_type, cycles.filter_width = "BOX", 1
    cycles.max_bounces = cycles.diffuse_bounces = cycles.glossy_bounces = 15
    cycles.transmission_bounces = cycles.transparent_max_bounces = 15
    scene.render.threads_mode, scene.render.threads = "FIXED", os.cpu_count()
    scene.render.resolution_x, scene.render.resolution_y = wanted["size"]
    scene.render.resolution_percentage = 100
    image = scene.render.image_settings
    image.file_format, image.color_depth, image.color_mode = "OPEN_EXR", "32", "RGB"


for wanted in json.load(open(listed)):
    bpy.ops.wm.read_factory_settings(use_empty=True)
    bpy.ops.import_scene.gltf(filepath=wanted["twin"], convert_lighting_mode="COMPAT")
    scene = bpy.context.scene
    prepare(scene, wanted)
    for seed in seeds:
        scene.cycles.seed = int(seed)
        scene.render.filepath = os.path.join(folder, f"{wanted['name']}-{seed}.exr")
        bpy.ops.render.render(write_still=True)
