"""Makes the scene of the test: a limb of two deforming bones with one between them that deforms
nothing, in centimetres under a node that makes metres of them. Saves it where its argument says, and
beside that as FBX."""

import math
import sys

import bpy

bpy.ops.wm.read_factory_settings(use_empty=True)
scene = bpy.context.scene


def add(name, data):
    thing = bpy.data.objects.new(name, data)
    scene.collection.objects.link(thing)
    return thing


metres = add("metres", None)
metres.scale = (0.01, 0.01, 0.01)
rig = add("Rig", bpy.data.armatures.new("Rig"))
rig.parent = metres
bpy.context.view_layer.objects.active = rig
bpy.ops.object.mode_set(mode="EDIT")
parent = None
for name, head, tail, deforms in (
    ("upper", 0, 100, True), ("control", 100, 120, False), ("lower", 100, 200, True)
):
    bone = rig.data.edit_bones.new(name)
    bone.head, bone.tail, bone.parent, bone.use_deform = (0, 0, head), (0, 0, tail), parent, deforms
    parent = bone
bpy.ops.object.mode_set(mode="OBJECT")

shape = bpy.data.meshes.new("Limb")
corners = [(10, 0, 50), (-10, 0, 50), (-10, 0, 150), (10, 0, 150), (0, 30, 180), (30, 30, 150)]
shape.from_pydata(corners, [], [(0, 1, 2, 3), (3, 2, 4), (0, 3, 4, 5, 1)])
# A seam: the edge from vertex 2 to 3 lies elsewhere in the triangle's texture than in the quad's.
texture = [(0, 0), (1, 0), (1, 1), (0, 1), (0, 2), (1, 2), (2, 3), (0, 0), (0, 1), (3, 1), (3, 0), (1, 0)]
for corner, uv in zip(shape.uv_layers.new(name="Texture").data, texture, strict=True):
    corner.uv = uv
limb = add("Limb", shape)
limb.parent = rig
for name, vertices in (("upper", [0, 1]), ("lower", [2, 3, 4, 5])):
    limb.vertex_groups.new(name=name).add(vertices, 1.0, "REPLACE")
limb.modifiers.new("Armature", "ARMATURE").object = rig
# What no skin can do: the first vertex moves by a shape key.
limb.shape_key_add(name="Basis")
swell = limb.shape_key_add(name="Swell")
swell.data[0].co.x += 10

scene.frame_start, scene.frame_end = 1, 3
lower = rig.pose.bones["lower"]
lower.rotation_mode = "XYZ"
for frame, degrees, swollen in ((1, 0, 0.0), (2, 45, 0.5), (3, 90, 1.0)):
    lower.rotation_euler = (math.radians(degrees), 0, 0)
    lower.keyframe_insert("rotation_euler", frame=frame)
    swell.value = swollen
    swell.keyframe_insert("value", frame=frame)
path = sys.argv[-1]
bpy.ops.wm.save_as_mainfile(filepath=path)
bpy.ops.export_scene.fbx(
    filepath=path.replace(".blend", ".fbx"), add_leaf_bones=False, use_mesh_modifiers=False
)
