"""Writes the armature of a scene without its meshes, as joints.fbx and joints.glb.

Arguments: the scene, and the folder of the files.
"""

import sys
from pathlib import Path

import bpy

scene, folder = sys.argv[-2:]
bpy.ops.wm.open_mainfile(filepath=scene)
rig = next(thing for thing in bpy.data.objects if thing.type == "ARMATURE")
bpy.ops.object.select_all(action="DESELECT")
rig.select_set(True)
bpy.context.view_layer.objects.active = rig
bpy.context.scene.frame_set(20)
joints = Path(folder) / "joints"
bpy.ops.export_scene.fbx(
    filepath=f"{joints}.fbx",
    use_selection=True,
    add_leaf_bones=False,
    bake_anim_use_all_actions=False,
    bake_anim_simplify_factor=0.0,
)
bpy.ops.export_scene.gltf(filepath=f"{joints}.glb", use_selection=True)
