"""Renders a scene of tests/references by Cycles, for peers.py: within Blender 3.4, blender -b -P ... -- SCENE
FOLDER PICTURE SAMPLES SEED, where FOLDER has the volumes as .vdb."""
import math
import pathlib
import sys
import tomllib

import bpy
from mathutils import Matrix, Vector


def material_of(kind, socket, **inputs):
    """A material of one node, which shades the surface or the volume."""
    material = bpy.data.materials.new(kind)
    material.use_nodes = True
    nodes = material.node_tree.nodes
    nodes.clear()
    out, node = nodes.new("ShaderNodeOutputMaterial"), nodes.new("ShaderNode" + kind)
    for name, value in inputs.items():
        node.inputs[name].default_value = value
    material.node_tree.links.new(node.outputs[0], out.inputs[socket])
    return material


def add_volume(file, medium):
    bpy.ops.object.volume_import(filepath=str(file), align="WORLD",
                                 location=medium.get("translate", (0, 0, 0)))
    bpy.context.object.data.render.precision = "FULL"
    bpy.context.object.data.materials.append(material_of(
        "VolumePrincipled", "Volume", Color=(*[medium["albedo"]] * 3, 1), Density=medium["extinction"],
        Anisotropy=medium["g"]))


def add_plane(plane):
    point = plane["point"]
    mesh = bpy.data.meshes.new("plane")
    mesh.from_pydata([(x, point[1], z) for x, z in ((-1e3, -1e3), (1e3, -1e3), (1e3, 1e3), (-1e3, 1e3))], [],
                     [(0, 1, 2, 3)])
    mesh.materials.append(material_of("BsdfDiffuse", "Surface", Color=(*[plane["albedo"]] * 3, 1)))
    link("plane", mesh)


def link(name, data):
    thing = bpy.data.objects.new(name, data)
    bpy.context.scene.collection.objects.link(thing)
    return thing


def add_mesh(file, albedo):
    lines = [line.split() for line in file.read_text().splitlines()]
    mesh = bpy.data.meshes.new("mesh")
    mesh.from_pydata([[float(x) for x in words[1:]] for words in lines if words[0] == "v"], [],
                     [[int(i) - 1 for i in words[1:]] for words in lines if words[0] == "f"])
    mesh.materials.append(material_of("BsdfDiffuse", "Surface", Color=(*[albedo] * 3, 1)))
    link("mesh", mesh)


def add_sky(tree, file):
    """A picture whose first column is at +x, and which turns towards +z; +y is up."""
    place = tree.nodes.new("ShaderNodeTexCoord")
    turn = tree.nodes.new("ShaderNodeMapping")
    picture = tree.nodes.new("ShaderNodeTexEnvironment")
    turn.inputs["Rotation"].default_value = Matrix(((-1, 0, 0), (0, 0, 1), (0, 1, 0))).to_euler()
    picture.image, picture.interpolation = bpy.data.images.load(str(file)), "Closest"
    tree.links.new(place.outputs["Generated"], turn.inputs["Vector"])
    tree.links.new(turn.outputs["Vector"], picture.inputs["Vector"])
    tree.links.new(picture.outputs["Color"], tree.nodes["Background"].inputs["Color"])


def add_lights(scene, folder):
    world = bpy.context.scene.world = bpy.data.worlds.new("sky")
    world.use_nodes = True
    if "file" in scene["environment"]:
        add_sky(world.node_tree, folder / scene["environment"]["file"])
    else:
        world.node_tree.nodes["Background"].inputs[0].default_value = (
            *[scene["environment"]["radiance"]] * 3, 1)
    for sun in scene.get("sun", []):
        lamp = bpy.data.lights.new("sun", "SUN")
        lamp.energy, lamp.angle = sun["irradiance"], 0
        link("sun", lamp).rotation_euler = Vector(sun["direction"]).to_track_quat("Z", "Y").to_euler()
    for point in scene.get("point", []):
        lamp = bpy.data.lights.new("lamp", "POINT")
        lamp.energy, lamp.shadow_soft_size = 4 * math.pi * point["intensity"], 0
        link("lamp", lamp).location = point["position"]


def add_camera(camera):
    lens = bpy.data.cameras.new("camera")
    lens.sensor_fit, lens.angle = "VERTICAL", math.radians(camera["fov"])
    place = Vector(camera["position"])
    back = (place - Vector(camera["target"])).normalized()
    right = Vector((0, 1, 0)).cross(back).normalized()
    axes = Matrix((right, back.cross(right), back)).transposed().to_4x4()
    thing = link("camera", lens)
    thing.matrix_world = Matrix.Translation(place) @ axes
    bpy.context.scene.camera = thing


def set_up(size, samples, seed, picture):
    scene = bpy.context.scene
    scene.render.engine = "CYCLES"
    c = scene.cycles
    c.samples, c.seed, c.use_adaptive_sampling, c.use_denoising = samples, seed, False, False
    c.max_bounces = c.diffuse_bounces = c.volume_bounces = 1024
    c.sample_clamp_direct = c.sample_clamp_indirect = c.light_sampling_threshold = 0
    c.pixel_filter_type, c.volume_step_rate, c.volume_max_steps = "BOX", 1, 65536
    r = scene.render
    r.threads_mode, r.threads = "FIXED", 1
    r.resolution_x, r.resolution_y, r.resolution_percentage = *size, 100
    r.image_settings.file_format, r.image_settings.color_depth = "OPEN_EXR", "32"
    r.image_settings.color_mode, r.image_settings.exr_codec = "RGB", "ZIP"
    r.filepath = picture


def main():
    file, folder, picture, samples, seed = sys.argv[sys.argv.index("--") + 1:]
    scene, references = tomllib.loads(pathlib.Path(file).read_text()), pathlib.Path(file).parent
    bpy.ops.wm.read_factory_settings(use_empty=True)
    bpy.ops.preferences.addon_enable(module="cycles")
    volumes = scene["volume"] if isinstance(scene["volume"], list) else [scene["volume"]]
    for volume in volumes:
        for place in volume.get("instance", [{}]):
            add_volume(pathlib.Path(folder) / f"{volume['file']}.vdb",
                       volume.get("medium", scene["medium"]) | place)
    for plane in scene.get("plane", []):
        add_plane(plane)
    for mesh in scene.get("mesh", []):
        add_mesh(references / mesh["file"], mesh["albedo"])
    add_lights(scene, references)
    add_camera(scene["camera"])
    set_up(scene["render"]["size"], int(samples), int(seed), picture)
    bpy.ops.render.render(write_still=True)


main()
