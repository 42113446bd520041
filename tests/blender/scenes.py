"""Small scenes, made by script."""

import math

import bpy
from mathutils import Matrix, Vector

SIZE = (96, 54)


def empty():
    """A new scene without anything, as the tests render it."""
    bpy.ops.wm.read_factory_settings(use_empty=True)
    bpy.ops.preferences.addon_enable(module="pvol_blender")
    scene = bpy.context.scene
    scene.render.resolution_x, scene.render.resolution_y = SIZE
    scene.render.threads_mode, scene.render.threads = "FIXED", 2
    scene.world = bpy.data.worlds.new("World")
    scene.world.use_nodes = True
    background((0, 0, 0))
    cycles = scene.cycles
    # What else makes Cycles' pictures differ from what a scene says.
    cycles.use_adaptive_sampling = cycles.use_denoising = False
    cycles.sample_clamp_direct = cycles.sample_clamp_indirect = cycles.light_sampling_threshold = 0
    cycles.max_bounces = cycles.volume_bounces = cycles.diffuse_bounces = 64
    return scene


def background(color, strength=1):
    node = bpy.context.scene.world.node_tree.nodes["Background"]
    node.inputs["Color"].default_value = (*color, 1)
    node.inputs["Strength"].default_value = strength
    return node


def add(name, data, matrix=None, location=(0, 0, 0), rotation=(0, 0, 0), scale=(1, 1, 1)):
    thing = bpy.data.objects.new(name, data)
    bpy.context.scene.collection.objects.link(thing)
    if matrix is not None:
        thing.matrix_world = matrix
    else:
        thing.location, thing.rotation_euler, thing.scale = location, rotation, scale
    return thing


def looking(position, target):
    """The matrix of a camera or lamp, which look along -z."""
    turn = (Vector(target) - Vector(position)).to_track_quat("-Z", "Y")
    return Matrix.Translation(position) @ turn.to_matrix().to_4x4()


def camera(position=(0, -6, 0), target=(0, 0, 0), **settings):
    data = bpy.data.cameras.new("Camera")
    for name, value in settings.items():
        setattr(data, name, value)
    thing = add("Camera", data, looking(position, target))
    bpy.context.scene.camera = thing
    return thing


def lamp(kind, position, target=(0, 0, 0), **settings):
    data = bpy.data.lights.new(kind.title(), kind)
    for name, value in settings.items():
        setattr(data, name, value)
    thing = add(kind.title(), data, looking(position, target))
    thing.visible_camera = False
    return thing


def cube_mesh(size=2.0, name="Box"):
    h = size / 2
    corners = [(x, y, z) for x in (-h, h) for y in (-h, h) for z in (-h, h)]
    faces = [(0, 1, 3, 2), (4, 6, 7, 5), (0, 4, 5, 1), (2, 3, 7, 6), (0, 2, 6, 4), (1, 5, 7, 3)]
    mesh = bpy.data.meshes.new(name)
    mesh.from_pydata(corners, [], faces)
    return mesh


def smoke(density=1.0, color=(0.5, 0.5, 0.5), anisotropy=0.0, attribute="density", **inputs):
    """A material with a Principled Volume; `inputs` by their names with _ for spaces."""
    material = bpy.data.materials.new("Smoke")
    material.use_nodes = True
    tree = material.node_tree
    tree.nodes.clear()
    node = tree.nodes.new("ShaderNodeVolumePrincipled")
    node.inputs["Density"].default_value = density
    node.inputs["Density Attribute"].default_value = attribute
    node.inputs["Color"].default_value = (*color, 1)
    node.inputs["Anisotropy"].default_value = anisotropy
    for name, value in inputs.items():
        node.inputs[name.replace("_", " ")].default_value = value
    out = tree.nodes.new("ShaderNodeOutputMaterial")
    tree.links.new(node.outputs[0], out.inputs["Volume"])
    return material


def box(material, **place):
    """A box of fog, of size 2."""
    mesh = cube_mesh()
    mesh.materials.append(material)
    return add("Box", mesh, **place)


def write_vdb(path, size=2.0, voxels=32, density=1.0):
    """A box of even density as a .vdb file, by the modifier Mesh to Volume."""
    source = add("Source", cube_mesh(size))
    maker = add("Maker", bpy.data.volumes.new("Maker"))
    modifier = maker.modifiers.new("Fill", "MESH_TO_VOLUME")
    modifier.object = source
    modifier.resolution_mode = "VOXEL_SIZE"
    modifier.voxel_size = size / voxels
    modifier.density = density
    modifier.exterior_band_width = 0
    modifier.interior_band_width = size
    grids = maker.evaluated_get(bpy.context.evaluated_depsgraph_get()).data.grids
    if not (grids.load() and grids.save(str(path))):
        raise OSError(f"Blender cannot write {path}")
    for thing in (maker, source):
        bpy.data.objects.remove(thing)


def volume(path, material=None, name="Cloud", **place):
    data = bpy.data.volumes.new(name)
    data.filepath = str(path)
    if material is not None:
        data.materials.append(material)
    return add(name, data, **place)


def diffuse(color):
    material = bpy.data.materials.new("Diffuse")
    material.use_nodes = True
    tree = material.node_tree
    tree.nodes.clear()
    node = tree.nodes.new("ShaderNodeBsdfDiffuse")
    node.inputs["Color"].default_value = (*color, 1)
    out = tree.nodes.new("ShaderNodeOutputMaterial")
    tree.links.new(node.outputs[0], out.inputs["Surface"])
    return material


def floor(z=-1.0, half=20.0, color=(0.8, 0.8, 0.8)):
    mesh = bpy.data.meshes.new("Floor")
    mesh.from_pydata([(x, y, z) for x, y in ((-half, -half), (half, -half), (half, half),
                                             (-half, half))], [], [(0, 1, 2, 3)])
    mesh.materials.append(diffuse(color))
    return add("Floor", mesh)


def radians(*degrees):
    return tuple(math.radians(d) for d in degrees)
