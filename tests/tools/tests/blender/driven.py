"""Makes driven.blend in the folder of the first argument: a square on one bone, with driven and animated shape keys.

- Grin: driven by a custom property of the bone, keyed 0, 1, 1.
- Tilt: driven by the bone's rotation, which is keyed too.
- Puff: driven by a custom property of the armature's object, with the default 0.5, keyed 1, 1, 0.
- Wink: keyed directly, 1, 0, 1.
- Style: always 0.5, without keys and without a driver.
- Calm: driven by a custom property of the armature's data, without keys, 0.25.

The bone may turn from -0.5 to 0.8 about x, which its keys do not use up.

The scene is saved at its last frame.
"""

import math
import sys
from pathlib import Path

import bpy

bpy.ops.wm.read_factory_settings(use_empty=True)
scene = bpy.context.scene
rig = bpy.data.objects.new("Rig", bpy.data.armatures.new("Rig"))
scene.collection.objects.link(rig)
bpy.context.view_layer.objects.active = rig
bpy.ops.object.mode_set(mode="EDIT")
bone = rig.data.edit_bones.new("head")
bone.head, bone.tail = (0, 0, 0), (0, 0, 1)
bpy.ops.object.mode_set(mode="OBJECT")

data = bpy.data.meshes.new("Face")
data.from_pydata([(0, 0, 0), (1, 0, 0), (1, 0, 1), (0, 0, 1)], [], [(0, 1, 2, 3)])
face = bpy.data.objects.new("Face", data)
scene.collection.objects.link(face)
face.parent = rig
face.vertex_groups.new(name="head").add(range(4), 1.0, "REPLACE")
face.modifiers.new("Armature", "ARMATURE").object = rig

face.shape_key_add(name="Basis")
keys = {}
for name, vertex, axis in (
    ("Grin", 0, 0), ("Tilt", 0, 1), ("Puff", 1, 0), ("Wink", 1, 1), ("Style", 2, 0), ("Calm", 2, 1)
):
    keys[name] = face.shape_key_add(name=name, from_mix=False)
    keys[name].value = 0
    keys[name].data[vertex].co[axis] += 0.1
head = rig.pose.bones["head"]
head.rotation_mode = "XYZ"
limit = head.constraints.new("LIMIT_ROTATION")
limit.owner_space = "LOCAL"
limit.use_limit_x, limit.min_x, limit.max_x = True, -0.5, 0.8
head["smile"], rig["puff"], rig.data["calm"] = 0.0, 0.5, 0.25
rig.id_properties_ui("puff").update(default=0.5)


def drive(key, thing, path):
    driver = keys[key].driver_add("value").driver
    driver.type = "SUM"
    variable = driver.variables.new()
    variable.targets[0].id_type = "ARMATURE" if thing == rig.data else "OBJECT"
    variable.targets[0].id = thing
    variable.targets[0].data_path = path


drive("Grin", rig, 'pose.bones["head"]["smile"]')
drive("Tilt", rig, 'pose.bones["head"].rotation_euler[0]')
drive("Puff", rig, '["puff"]')
drive("Calm", rig.data, '["calm"]')
keys["Style"].value = 0.5
for frame, smile, puff, wink, degrees in ((1, 0, 1, 1, 30), (2, 1, 1, 0, 0), (3, 1, 0, 1, 45)):
    head["smile"], rig["puff"] = float(smile), float(puff)
    head.rotation_euler[0] = math.radians(degrees)
    keys["Wink"].value = wink
    head.keyframe_insert('["smile"]', frame=frame)
    head.keyframe_insert("rotation_euler", frame=frame)
    rig.keyframe_insert('["puff"]', frame=frame)
    keys["Wink"].keyframe_insert("value", frame=frame)
scene.frame_start, scene.frame_end = 1, 3
scene.frame_set(3)
bpy.ops.wm.save_as_mainfile(filepath=str(Path(sys.argv[-1]) / "driven.blend"))
