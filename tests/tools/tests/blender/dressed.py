"""Makes dressed.blend in the folder of the first argument, and the same scene as dressed.fbx.

- Tube: a smooth tube on two bones with a waist of hard edges, texture coordinates, and three materials. Skin has an
  image file, Eye a packed image, and Cloth a colour.
- Flag: a quad with custom normals.
- Both meshes have the shape key Puff, driven alike by hand. The rig has the custom property breath, and each bone a
  custom property stretch.
- Two actions move the bones: Bend and Twist. A third action, Blink, moves no bone.
"""

import math
import sys
from pathlib import Path

import bpy

folder = Path(sys.argv[-1])
bpy.ops.wm.read_factory_settings(use_empty=True)
scene = bpy.context.scene
rig = bpy.data.objects.new("Rig", bpy.data.armatures.new("Rig"))
scene.collection.objects.link(rig)
bpy.context.view_layer.objects.active = rig
bpy.ops.object.mode_set(mode="EDIT")
parent = None
for name, low in (("lower", 0), ("upper", 1)):
    bone = rig.data.edit_bones.new(name)
    bone.head, bone.tail, bone.parent = (0, 0, low), (0, 0, low + 1), parent
    parent = bone
bpy.ops.object.mode_set(mode="OBJECT")


def add(name, corners, faces):
    data = bpy.data.meshes.new(name)
    data.from_pydata(corners, [], faces)
    data.shade_smooth()
    mesh = bpy.data.objects.new(name, data)
    scene.collection.objects.link(mesh)
    mesh.parent = rig
    mesh.modifiers.new("Armature", "ARMATURE").object = rig
    for bone in ("lower", "upper"):
        mesh.vertex_groups.new(name=bone)
    for vertex in data.vertices:
        above = min(max(vertex.co.z - 0.5, 0.0), 1.0)
        mesh.vertex_groups["lower"].add([vertex.index], 1 - above, "REPLACE")
        mesh.vertex_groups["upper"].add([vertex.index], above, "REPLACE")
    return mesh


SIDES, RINGS = 8, 13
ring = [(math.cos(2 * math.pi * side / SIDES), math.sin(2 * math.pi * side / SIDES)) for side in range(SIDES)]
width = [0.2 + 0.1 * abs(level - 6) / 6 for level in range(RINGS)]
corners = [(width[level] * x, width[level] * y, 2 * level / (RINGS - 1)) for level in range(RINGS) for x, y in ring]
faces = [
    (at + side, at + (side + 1) % SIDES, at + SIDES + (side + 1) % SIDES, at + SIDES + side)
    for at in range(0, SIDES * (RINGS - 1), SIDES)
    for side in range(SIDES)
]
tube = add("Tube", corners, faces)
for edge in tube.data.edges:
    edge.use_edge_sharp = all(6 * SIDES <= vertex < 7 * SIDES for vertex in edge.vertices)
uv = tube.data.uv_layers.new(name="Texture").data
for loop in tube.data.loops:
    x, y, z = corners[loop.vertex_index]
    uv[loop.index].uv = (x, z)
flag = add("Flag", [(0.2, 0, 1.6), (0.8, 0, 1.6), (0.8, 0, 2), (0.2, 0, 2)], [(0, 1, 2, 3)])
tilted = [(0, -1, 0), (0.6, -0.8, 0), (0.6, -0.8, 0), (0, -1, 0)]
flag.data.normals_split_custom_set(tilted)


def image(name, colour):
    made = bpy.data.images.new(name, 2, 2)
    made.pixels = list(colour) * 4
    made.filepath_raw, made.file_format = str(folder / name), "PNG"
    made.save()
    bpy.data.images.remove(made)
    return bpy.data.images.load(str(folder / name))


def material(name, colour, picture=None):
    made = bpy.data.materials.new(name)
    made.use_nodes = True
    shader = next(node for node in made.node_tree.nodes if node.type == "BSDF_PRINCIPLED")
    shader.inputs["Base Color"].default_value = (*colour, 1)
    if picture:
        texture = made.node_tree.nodes.new("ShaderNodeTexImage")
        texture.image = picture
        made.node_tree.links.new(texture.outputs["Color"], shader.inputs["Base Color"])
    return made


skin, eye = image("skin.png", (1, 0.5, 0.25, 1)), image("eye.png", (0, 0, 1, 1))
cloth = material("Cloth", (0.25, 0.5, 0.75))
for own in (material("Skin", (1, 1, 1), skin), material("Eye", (1, 1, 1), eye), cloth):
    tube.data.materials.append(own)
flag.data.materials.append(cloth)
for number, polygon in enumerate(tube.data.polygons):
    polygon.material_index = number % 3
for mesh in (tube, flag):
    mesh.shape_key_add(name="Basis")
    puff = mesh.shape_key_add(name="Puff", from_mix=False)
    puff.value = 0
    puff.data[2].co.x += 0.1

rig["breath"] = 0.0
bones = {name: rig.pose.bones[name] for name in ("lower", "upper")}
for bone in bones.values():
    bone.rotation_mode = "XYZ"
    bone["stretch"] = 0.0


def key(frame, lower, upper, breath):
    for name, degrees in (("lower", lower), ("upper", upper)):
        bones[name].rotation_euler = [math.radians(angle) for angle in degrees]
        bones[name].keyframe_insert("rotation_euler", frame=frame)
        bones[name]["stretch"] = float(degrees[0])
        bones[name].keyframe_insert('["stretch"]', frame=frame)
    rig["breath"] = breath
    rig.keyframe_insert('["breath"]', frame=frame)


for frame in range(1, 9):
    key(frame, (0, 0, 0), (10.0 * frame, 0, 0), frame / 8)
bend = rig.animation_data.action
bend.name = "Bend"
rig.animation_data.action = None
for frame in range(3, 7):
    bones["upper"].rotation_euler = (0, 0, 0)
    bones["lower"].rotation_euler = (0, math.radians(10 * frame), 0)
    bones["lower"].keyframe_insert("rotation_euler", frame=frame)
twist = rig.animation_data.action
twist.name = "Twist"
twist.use_fake_user = bend.use_fake_user = True
rig.animation_data.action = bend
for mesh in (tube, flag):
    puff = mesh.data.shape_keys.key_blocks["Puff"]
    for frame, value in ((1, 0.0), (8, 1.0)):
        puff.value = value
        puff.keyframe_insert("value", frame=frame)
    mesh.data.shape_keys.animation_data.action.name = "Blink"
scene.frame_start, scene.frame_end = 1, 8
bpy.ops.wm.save_as_mainfile(filepath=str(folder / "dressed.blend"))
bpy.ops.export_scene.fbx(
    filepath=str(folder / "dressed.fbx"), add_leaf_bones=False, use_mesh_modifiers=False,
    bake_anim_use_all_actions=False, bake_anim_use_nla_strips=False, path_mode="RELATIVE",
)
bpy.data.images["eye.png"].pack()
(folder / "eye.png").rename(folder / "eye.moved.png")
bpy.ops.wm.save_as_mainfile(filepath=str(folder / "dressed.blend"))
(folder / "eye.moved.png").rename(folder / "eye.png")
