"""Makes the scenes of the test in the folder of the first argument.

- limb.blend, and the same scene as limb.fbx: a limb of two deforming bones with a bone between them that
  deforms nothing, in centimetres under a node that scales them to metres.
- strips.blend: the limb with a sleeve (mirrored, without a texture), two hidden meshes, a vertex group for
  importance, three strips of the NLA, and another unit.
- muted.blend: strips.blend with a muted strip and a muted track; off.blend: strips.blend with its NLA off.
- muddled.blend: strips.blend with overlapping strips and visible meshes. The number of vertices of one mesh
  grows, and the faces of the other change.
- mirrored.blend: strips.blend with the whole rig mirrored.
"""

import math
import sys
from pathlib import Path

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
# A seam: the edge from vertex 2 to 3 has other texture coordinates in the triangle than in the quad.
texture = [(0, 0), (1, 0), (1, 1), (0, 1), (0, 2), (1, 2), (2, 3), (0, 0), (0, 1), (3, 1), (3, 0), (1, 0)]
for corner, uv in zip(shape.uv_layers.new(name="Texture").data, texture, strict=True):
    corner.uv = uv
limb = add("Limb", shape)
limb.parent = rig
for name, vertices in (("upper", [0, 1]), ("lower", [2, 3, 4, 5])):
    limb.vertex_groups.new(name=name).add(vertices, 1.0, "REPLACE")
limb.vertex_groups["upper"].add([1], 0.75, "REPLACE")
limb.vertex_groups["lower"].add([1], 0.25, "REPLACE")
limb.modifiers.new("Armature", "ARMATURE").object = rig


def follow(name, corners, faces):
    """Adds a mesh without a texture that follows the upper bone."""
    data = bpy.data.meshes.new(name)
    data.from_pydata(corners, [], faces)
    mesh = add(name, data)
    mesh.parent = rig
    mesh.vertex_groups.new(name="upper").add(range(len(corners)), 1.0, "REPLACE")
    mesh.modifiers.new("Armature", "ARMATURE").object = rig
    return mesh


# No skin can do this: the first vertex moves by a shape key.
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
folder = Path(sys.argv[-1])


def save(name):
    bpy.ops.wm.save_as_mainfile(filepath=str(folder / name))


save("limb.blend")
bpy.ops.export_scene.fbx(
    filepath=str(folder / "limb.fbx"), add_leaf_bones=False, use_mesh_modifiers=False
)

follow("Sleeve", [(-20, 0, 0), (20, 0, 0), (20, 0, 90), (-20, 0, 90)], [(0, 1, 2), (0, 2, 3)])
bpy.data.objects["Sleeve"].scale.x = -1
hair = follow("Hair", [(0, 0, 0), (10, 0, 0), (0, 10, 0), (0, 0, 10)], [(0, 1, 2), (0, 2, 3)])
growth = hair.modifiers.new("Build", "BUILD")
growth.frame_start, growth.frame_duration = 0, 3
scales = follow("Scales", [(0, 0, 0), (10, 0, 0), (10, 0, 10), (0, 0, 10)], [(0, 1, 2, 3)])
cut = scales.modifiers.new("Triangulate", "TRIANGULATE")
for frame in (1, 3):
    cut.show_viewport = frame == 3
    cut.keyframe_insert("show_viewport", frame=frame)
for mesh in (hair, scales):
    mesh.hide_set(True)
matters = limb.vertex_groups.new(name="Matters")
matters.add([0], 1.0, "REPLACE")
matters.add([3], 0.25, "REPLACE")
scene.unit_settings.scale_length = 0.1
scene.render.fps, scene.render.fps_base = 24, 1.001

animation = rig.animation_data
bend, animation.action = animation.action, None
lower.rotation_euler = (0, 0, 0)
for frame, degrees in ((5, 0), (6, 90), (7, 90)):
    lower.rotation_euler = (0, math.radians(degrees), 0)
    lower.keyframe_insert("rotation_euler", frame=frame)
twist, animation.action = animation.action, None
scene.frame_end = 10
# The last two strips meet in frame 7.
for name, action, first in (("Bend", bend, 1), ("Twist", twist, 5), ("Again", bend, 7)):
    animation.nla_tracks.new().strips.new(name, first, action).extrapolation = "NOTHING"
save("strips.blend")

tracks = animation.nla_tracks
for muted in (True, False):
    tracks[1].strips[0].mute = tracks[2].mute = muted
    if muted:
        save("muted.blend")
animation.use_nla = False
save("off.blend")
animation.use_nla = True

animation.nla_tracks[1].strips[0].frame_start_ui = 2
for mesh in (hair, scales):
    mesh.hide_set(False)
save("muddled.blend")

metres.scale.x *= -1
save("mirrored.blend")
