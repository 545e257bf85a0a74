"""Writes example poses of a rigged character, for `sinew train`.

Whatever Blender shows is what is written: muscles, correctives, simulation, any modifier that keeps
the meshes' vertices. For each frame it evaluates the meshes and the bones that deform them, in
world space. All visible meshes of the armature are joined, in the scene's order; the strips of its
NLA become clips by name, or all frames are one clip called as its action. Strips that overlap play
one at a time. Names, frame rate and numbers, axes, unit, joint weights (vertex groups called as
bones), texture coordinates, normals with hard edges, materials and their images go with them.

Keyed custom properties and shape keys become curves: numbers that move the skin beside the bones.
`sinew train --curves none` ignores them.

The rest mesh is taken at the first frame, with the armature in its rest position. Every keyed shape
key, custom property and bone has its default there, and drivers follow. Properties without keys keep
their value in all frames, and at rest too.

    blender rig.blend --background --python blender_export.py -- examples.npz
    python blender_export.py --blend rig.blend examples.npz        (with `pip install bpy`)

Options: --mesh NAME, several times for several (all of the armature otherwise), --armature NAME
(needed where there are several), --frames FIRST:LAST[:STEP] (the strips' own otherwise, or the
scene's), --clips one (frames of no strip too, as one clip), --actions (every action that moves the
armature is a clip), --curves all (driven properties and shape keys too) or none, --importance GROUP
(a vertex counts as much as it weighs in the group: outside of it not at all, and fully in meshes
without the group), --bones all (the deforming ones otherwise).

--range-of-motion poses the rig by itself: each moved bone and property alone, with its neighbours, and all
together, in --frames N poses (150 otherwise). Rotations stay within the bones' Limit Rotation constraints
and IK limits, everything else within its keys. --degrees D turns the keyed bones (the written ones without
keys) by up to D degrees instead, and moves shape keys and the properties that drive them over their sliders.
"""

import argparse
import json
import math
import random
import sys
from collections import namedtuple
from functools import partial
from pathlib import Path

import bpy
import numpy as np

# Strips begin and end at fractions of frames, rounded.
FRACTION = 1e-3
ONE = "--clips one takes every frame, as one clip"


# A clip: its name, the numbers of its frames, and a function that lets it play alone.
Clip = namedtuple("Clip", "name frames play")

# A number that may become a curve: its name, the thing that has it, a function that reads it from the
# evaluated scene, and whether a driver computes it.
Control = namedtuple("Control", "name holder read driven")


class Problem(Exception):
    """Something about the scene that the user can mend."""


class Parser(argparse.ArgumentParser):
    """A parser whose errors are one line."""

    def error(self, message):
        raise Problem(f"{message} (--help explains the options)")


def main(arguments):
    options = parse(arguments)
    if options.blend:
        open_scene(options.blend)
    if not options.output.parent.is_dir():
        raise Problem(f"{options.output.parent}: there is no such folder, make it first")
    scene = bpy.context.scene
    meshes, armature = find(scene, options)
    bones = deforming(armature, options.bones)
    restore = kept(scene, armature, meshes)
    moved = RangeOfMotion(scene, armature, meshes, bones, options) if options.range_of_motion else None
    try:
        if moved:
            moved.insert_keys()
            clips = [Clip("Range of motion", moved.frames, lambda: None)]
        else:
            clips = chosen_clips(scene, armature, meshes, options)
        frames = [frame for clip in clips for frame in clip.frames]
        clips[0].play()
        parts, rest, shapes = at_rest(scene, frames[0], meshes, armature, bones, options.importance)
        found = controls(meshes, armature, moved.owners() if moved else [], options.curves)
        posed, values = poses(scene, meshes, parts, armature, rest, bones, clips, found)
    finally:
        if moved:
            moved.restore()
        restore()
    curves = named_curves(found, values, options.curves)
    examples = {
        **joined(meshes, parts),
        **skeleton(rest, bones),
        **posed,
        **curves,
        **appearance(meshes, parts),
        **told(scene, clips, frames),
    }
    # The last name decides the format: numpy would add .npz to any other.
    try:
        with open(options.output, "wb") as file:
            np.savez_compressed(file, **examples)
    except OSError as error:
        raise Problem(f"{options.output}: cannot be written ({error.strerror}): give another name")
    names = ", ".join(f"{clip.name} ({clip.frames[0]} to {clip.frames[-1]})" for clip in clips)
    curve_names = ", ".join(curves.get("curve_names", []))
    print(
        f"wrote {options.output}: {len(examples['rest'])} vertices, {len(bones)} joints, "
        f"{len(frames)} frames at {float(examples['fps']):g} a second\n"
        f"  meshes: {', '.join(mesh.name for mesh in meshes)}\n"
        f"  clips: {names}\n"
        + (f"  curves: {curve_names}\n" if curve_names else "")
        + f"  rest mesh: of frame {frames[0]}, armature, keys and drivers at rest"
    )
    if shapes:
        note(f"shape keys that are on at rest, as no key moves them: {', '.join(shapes)}")


def parse(arguments):
    parser = Parser(prog="blender_export.py", description=__doc__,
                    formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("output", type=Path, help="where to write the examples (.npz)")
    parser.add_argument("--blend", type=Path, help="the file to open, outside of Blender")
    parser.add_argument("--mesh", action="append", help="a mesh object; may be given several times")
    parser.add_argument("--armature", help="the armature object")
    parser.add_argument("--frames", help="FIRST:LAST[:STEP]; the number of poses with --range-of-motion")
    clips = parser.add_mutually_exclusive_group()
    clips.add_argument("--clips", choices=["strips", "one"], help="the NLA's strips, or all as one")
    clips.add_argument("--actions", action="store_true", help="a clip for each action of the armature")
    parser.add_argument("--curves", choices=["keyed", "all", "none"], default="keyed",
                        help="custom properties and shape keys that become curves")
    parser.add_argument("--importance", metavar="GROUP", help="a vertex group")
    parser.add_argument("--bones", choices=["deforming", "all"], default="deforming")
    parser.add_argument("--range-of-motion", action="store_true", help="pose the rig: --frames N poses")
    parser.add_argument("--degrees", type=float, metavar="D", help="the range of motion of every bone")
    options = parser.parse_args(arguments)
    if options.degrees is not None and not (options.range_of_motion and 0 < options.degrees <= 180):
        parser.error("--degrees: expected up to 180 degrees, with --range-of-motion")
    if options.output.suffix != ".npz":
        parser.error(f"{options.output}: expected a name that ends in .npz")
    return options


def note(text):
    print(f"blender_export.py: {text}", file=sys.stderr)


def open_scene(path):
    if not path.is_file():
        raise Problem(f"{path}: there is no such file")
    try:
        bpy.ops.wm.open_mainfile(filepath=str(path))
    except RuntimeError as error:
        raise Problem(f"{path}: cannot be opened: {one_line(error)}: save it again with this Blender")


def one_line(error):
    return " ".join(str(error).split())


def find(scene, options):
    """Gives the meshes, in the scene's order, and the armature that deforms them."""
    armature = options.armature and named(scene, options.armature, "ARMATURE")
    if options.mesh:
        chosen = [named(scene, name, "MESH") for name in options.mesh]
        meshes = [o for o in scene.objects if o in chosen]
    else:
        meshes = [o for o in scene.objects if o.type == "MESH" and armature_of(o)]
        meshes = [o for o in meshes if armature in (None, armature_of(o))]
    # Blender evaluates nothing that is hidden.
    hidden = [o.name for o in meshes if not o.visible_get()]
    if hidden and options.mesh:
        raise Problem(f"hidden in the viewport: {', '.join(hidden)}: show what is to be written")
    if hidden:
        note(f"meshes that are hidden in the viewport are left out: {', '.join(hidden)}")
        meshes = [o for o in meshes if o.name not in hidden]
    if not meshes:
        rig = armature.name if armature else "an armature"
        raise Problem(f"no visible mesh follows {rig}: give --mesh NAME and --armature NAME")
    by_armature = {}
    for mesh in meshes:
        by_armature.setdefault(armature_of(mesh), []).append(mesh.name)
    if armature is None and len(by_armature) > 1:
        found = "; ".join(f"{', '.join(names)} of {rig.name if rig else 'none'}"
                          for rig, names in by_armature.items())
        raise Problem(f"meshes of several armatures ({found}): give --armature NAME")
    armature = armature or next(iter(by_armature))
    if armature is None:
        raise Problem(f"mesh {meshes[0].name} has no armature: give --armature NAME")
    return meshes, armature


def named(scene, name, kind):
    thing = scene.objects.get(name)
    if thing is None or thing.type != kind:
        known = ", ".join(o.name for o in scene.objects if o.type == kind) or "none"
        raise Problem(f"there is no {kind.lower()} {name}, only: {known}")
    return thing


def armature_of(mesh):
    modifiers = [m.object for m in mesh.modifiers if m.type == "ARMATURE" and m.object]
    if modifiers:
        return modifiers[0]
    parent = mesh.parent
    return parent if parent and parent.type == "ARMATURE" else None


def deforming(armature, which):
    bones = [bone for bone in armature.data.bones if which == "all" or bone.use_deform]
    if not bones:
        raise Problem(f"armature {armature.name} has no deforming bone: try --bones all")
    return bones


def frame_numbers(scene, text):
    if text is None:
        return list(range(scene.frame_start, scene.frame_end + 1, scene.frame_step))
    try:
        first, last, step = ([int(part) for part in text.split(":")] + [1])[:3]
        frames = list(range(first, last + 1, step))
    except ValueError:
        frames = []
    if not frames:
        raise Problem(f"--frames {text}: expected FIRST:LAST or FIRST:LAST:STEP")
    return frames


def chosen_clips(scene, armature, meshes, options):
    """Gives the clips in order: one a strip, one an action, or all frames as one."""
    asked = frame_numbers(scene, options.frames)
    if options.actions:
        return of_actions(scene, armature, meshes, options.frames and asked)
    strips, why = ([], "") if options.clips == "one" else shown_strips(armature)
    unplayed(armature, strips)
    if not strips:
        if options.clips == "strips":
            raise Problem(f"the NLA of {armature.name} {why or 'plays no strip'}")
        if why:
            note(f"the NLA of {armature.name} {why}: all frames are one clip")
        action = armature.animation_data and armature.animation_data.action
        return [Clip(action.name if action else scene.name, asked, lambda: None)]
    covered, clips = set(), []
    for strip in strips:
        # The frame in which two strips meet is the later one's.
        meets = any(abs(other.frame_start - strip.frame_end) <= FRACTION for other in strips)
        last = strip.frame_end + (-FRACTION if meets else FRACTION)
        own = range(math.ceil(strip.frame_start - FRACTION), math.floor(last) + 1)
        covered.update(own)
        own = [f for f in asked if f in own] if options.frames else list(own[::scene.frame_step])
        if own:
            clips.append(Clip(strip.name, own, partial(play_strip, strip, strips)))
    if not clips:
        raise Problem(f"--frames {options.frames}: no strip of {armature.name} is there ({ONE})")
    alone = [strip.name for strip in strips if any(overlap(strip, other) for other in strips)]
    if alone:
        note(f"strips that overlap play one at a time: {', '.join(alone)} ({ONE}, as they blend)")
    left = sum(frame not in covered for frame in asked)
    if left:
        note(f"frames of no strip are left out: {left} ({ONE})")
    return clips


def overlap(strip, other):
    shared = min(strip.frame_end, other.frame_end) - max(strip.frame_start, other.frame_start)
    return strip != other and shared > FRACTION


def play_strip(strip, strips):
    """Mutes the strips that overlap a strip."""
    for other in strips:
        other.mute = overlap(strip, other)


def shown_strips(armature):
    """Gives the strips that play, in order; or none, and why those that there are do not count."""
    data = armature.animation_data
    if data is None or not data.use_nla:
        return [], ""
    tracks = [t for t in data.nla_tracks if t.is_solo]
    tracks = tracks or [t for t in data.nla_tracks if not t.mute]
    strips = [s for t in tracks for s in t.strips if s.type in ("CLIP", "META") and not s.mute]
    strips.sort(key=lambda strip: strip.frame_start)
    if strips and data.action and data.action_blend_type == "REPLACE" and data.action_influence > 0:
        return [], f"is covered by the action {data.action.name}"
    return strips, ""


def unplayed(armature, strips):
    """Names the strips and actions that no clip plays."""
    data = armature.animation_data
    tracks = data.nla_tracks if data else []
    # Strips that an action covers are reported with the action.
    silent = [s.name for t in tracks for s in t.strips if t.mute or s.mute or not data.use_nla]
    if silent:
        note(f"muted strips of the NLA are left out: {', '.join(silent)}")
    known = {data.action} if data else set()
    known |= {action for track in tracks for action in actions_of(track.strips)}
    other = [action.name for action in moving_actions(armature) if action not in known]
    if other:
        note(f"actions that nothing plays are left out: {', '.join(other)} (--actions takes all)")


def actions_of(strips):
    """Gives the actions of strips, and of those inside meta strips."""
    return {strip.action for strip in strips}.union(
        *(actions_of(getattr(strip, "strips", [])) for strip in strips)) - {None}


def moving_actions(armature):
    """Lists the actions that have keys of the armature's bones."""
    bones = tuple(f'pose.bones["{bpy.utils.escape_identifier(bone.name)}"]'
                  for bone in armature.pose.bones)
    return [action for action in bpy.data.actions
            if any(curve.data_path.startswith(bones) for curve in curves_of(action))]


def of_actions(scene, armature, meshes, asked):
    """Makes a clip of each action that moves the armature."""
    actions = moving_actions(armature)
    if not actions:
        raise Problem(f"no action has keys of the bones of {armature.name}: give --clips one")
    owners = owners_of(armature, meshes)
    # These play on the meshes, in every clip.
    own = {owner.animation_data.action for owner in owners if owner.animation_data}
    left = [action.name for action in bpy.data.actions if action not in {*actions, *own}]
    if left:
        note(f"actions that move no bone of {armature.name} are left out: {', '.join(left)}")
    paths = sorted({(curve.data_path, curve.array_index)
                    for action in actions for curve in curves_of(action)})
    clips = []
    for action in actions:
        first, last = action.frame_range
        own = range(math.ceil(first - FRACTION), math.floor(last + FRACTION) + 1)
        own = [f for f in asked if f in own] if asked else list(own[::scene.frame_step])
        if own:
            clips.append(Clip(action.name, own, partial(play_action, action, owners, paths)))
    if not clips:
        raise Problem(f"--frames: no action of {armature.name} has a key there")
    return clips


def play_action(action, owners, paths):
    """Plays an action on the armature, and on the other owners for which it has a slot.

    Whatever another action keys goes to its default.
    """
    for number, owner in enumerate(owners):
        slots = [s for s in getattr(action, "slots", []) if s.target_id_type == owner.id_type]
        if number > 0 and not slots:
            continue
        data = owner.animation_data or owner.animation_data_create()
        data.use_nla = False
        data.action = action
        if slots and data.action_slot is None:
            data.action_slot = slots[0]
        for path, index in paths:
            reset(owner, path, index)


def owners_of(armature, meshes):
    """Lists the data-blocks that actions may move, the armature first."""
    found = [armature, armature.data]
    for mesh in meshes:
        found += [mesh, mesh.data.shape_keys]
    return list(dict.fromkeys(owner for owner in found if owner is not None))


def kept(scene, armature, meshes):
    """Returns a function that restores the frame, actions and strips."""
    frame, position = scene.frame_current, armature.data.pose_position
    animated = [(owner, owner.animation_data) for owner in owners_of(armature, meshes)]
    states = [(owner, data and (data.use_nla, data.action, getattr(data, "action_slot", None)))
              for owner, data in animated]
    strips = [(strip, strip.mute) for _, data in animated if data
              for track in data.nla_tracks for strip in track.strips]

    def restore():
        armature.data.pose_position = position
        for owner, state in states:
            data = owner.animation_data
            if state is None and data is not None:
                owner.animation_data_clear()
            elif state is not None:
                data.use_nla, data.action, slot = state
                if data.action and slot:
                    data.action_slot = slot
        for strip, mute in strips:
            strip.mute = mute
        scene.frame_set(frame)

    return restore


def controls(meshes, armature, others, which):
    """Lists the numbers that may become curves: shape keys, and custom properties of the objects, their data, bones and
    others.
    """
    found, odd = [], []
    objects = [armature, *meshes]
    holders = [*objects, *(thing.data for thing in objects), *others]
    for holder in dict.fromkeys(holders) if which != "none" else []:
        add_properties(found, odd, holder, holder, "", which)
        if holder == armature:
            for bone in armature.pose.bones:
                path = f'pose.bones["{bpy.utils.escape_identifier(bone.name)}"]'
                add_properties(found, odd, armature, bone, path, which)
        keys = getattr(holder.data, "shape_keys", None) if holder in objects else None
        if keys is not None and keys.use_relative:
            add_shapes(found, holder, keys, which)
    if odd:
        note(f"keyed custom properties that are no single number are left out: {', '.join(odd)}")
    driven = [control.name for control in found if control.driven]
    if driven and which == "keyed":
        names = ", ".join(dict.fromkeys(driven))
        note(f"driven, and so no curves: {names} (--curves all takes them)")
    return [control for control in found if which == "all" or not control.driven]


def add_properties(found, odd, owner, holder, path, which):
    """Adds the custom properties of a thing or of a bone."""
    moved, driven = {path for path, _ in keyed(owner)}, drivers(owner)
    for name in holder.keys():
        own = f'{path}["{bpy.utils.escape_identifier(name)}"]'
        if own not in moved | driven and which != "all":
            continue
        if not isinstance(holder[name], (bool, int, float)):
            odd += [f"{holder.name} {name}"] if own in moved else []
            continue
        read = partial(property_of, owner, path, name)
        # A key on a driven property has no effect.
        found.append(Control(name, holder.name, read, own in driven))


def property_of(owner, path, name):
    there = owner.evaluated_get(bpy.context.evaluated_depsgraph_get())
    return float((there.path_resolve(path) if path else there)[name])


def add_shapes(found, mesh, keys, which):
    """Adds the shape keys of a mesh that are not muted."""
    moved, driven = {path for path, _ in keyed(keys)}, drivers(keys)
    for key in keys.key_blocks:
        own = f'key_blocks["{bpy.utils.escape_identifier(key.name)}"].value'
        if key == keys.reference_key or key.mute:
            continue
        if own in moved | driven or which == "all":
            read = partial(shape_of, keys, key.name)
            found.append(Control(key.name, mesh.name, read, own in driven))


def shape_of(keys, name):
    there = keys.evaluated_get(bpy.context.evaluated_depsgraph_get())
    return float(there.key_blocks[name].value)


def drivers(owner):
    data = owner.animation_data
    return {driver.data_path for driver in data.drivers} if data else set()


def named_curves(found, values, which):
    """Gives the curves and their names. Controls of one name are one curve if they always agree.

    Of all controls, only those count that change.
    """
    by_name = {}
    for place, control in enumerate(found):
        by_name.setdefault(control.name, []).append(place)
    names, places, renamed = [], [], []
    for name, own in by_name.items():
        alike = all(np.array_equal(values[:, place], values[:, own[0]]) for place in own)
        own = own[:1] if alike else own
        if which == "all":
            own = [place for place in own if np.ptp(values[:, place]) > 0]
        names += [name if alike else f"{found[place].holder}.{name}" for place in own]
        places += own
        renamed += [] if alike else [name]
    if renamed:
        note(f"curves of several things, named THING.NAME as they differ: {', '.join(renamed)}")
    if not names:
        return {}
    return {"curves": values[:, places].astype(np.float32), "curve_names": np.array(names)}


# First bytes of the images that a glTF file can hold.
IMAGES = (b"\x89PNG\r\n\x1a\n", b"\xff\xd8\xff", b"RIFF")


def appearance(meshes, parts):
    """Gives the materials as glTF states them, the material of each face, and the images."""
    materials, found = [], {"quads_material": [], "tris_material": []}
    for mesh, part in zip(meshes, parts):
        own = [slot.material for slot in mesh.material_slots]
        materials += [m for m in dict.fromkeys(own) if m is not None and m not in materials]
        # The last number is for faces of a slot that does not exist.
        numbers = np.array([-1 if m is None else materials.index(m) for m in own] + [-1], np.int32)
        for name, faces in found.items():
            faces.append(numbers[np.minimum(part[name], len(own))])
    if not materials:
        return {}
    images, left = [], []
    described = [described_material(material, images, left) for material in materials]
    if left:
        note(f"images without a file, or not PNG, JPEG or WebP, are left out: {', '.join(left)}")
    members = {
        "materials": described,
        "textures": [{"source": number} for number in range(len(images))],
        "images": [{"name": image.name} for image, _ in images],
    }
    files = {f"image_{n}": np.frombuffer(data, np.uint8) for n, (_, data) in enumerate(images)}
    faces = {name: np.concatenate(own) for name, own in found.items()}
    faces = {name: own for name, own in faces.items() if len(own)}
    return {**faces, **files, "materials": np.array(json.dumps(members))}


def described_material(material, images, left):
    """Describes name, base colour with its image, metal and roughness of a material."""
    nodes = material.node_tree.nodes if material.node_tree else []
    shader = next((node for node in nodes if node.type == "BSDF_PRINCIPLED"), None)
    surface = {"metallicFactor": round(material.metallic, 6),
               "roughnessFactor": round(material.roughness, 6)}
    colour, image = list(material.diffuse_color[:3]), None
    if shader:
        for name, factor in (("Metallic", "metallicFactor"), ("Roughness", "roughnessFactor")):
            surface[factor] = round(shader.inputs[name].default_value, 6)
        colour = list(shader.inputs["Base Color"].default_value[:3])
        image = image_before(shader.inputs["Base Color"])
    known = [own for own, _ in images]
    if image and image not in known:
        data = image_file(image)
        if data is None:
            left += [] if image.name in left else [image.name]
            image = None
        else:
            images.append((image, data))
            known.append(image)
    if image:
        surface["baseColorTexture"] = {"index": known.index(image)}
    else:
        surface["baseColorFactor"] = [round(min(max(x, 0.0), 1.0), 6) for x in colour] + [1.0]
    return {"name": material.name, "pbrMetallicRoughness": surface}


def image_before(socket):
    """Finds the first image texture in front of a socket."""
    sockets, seen = [socket], set()
    while sockets:
        for link in sockets.pop(0).links:
            node = link.from_node
            if node.type == "TEX_IMAGE" and node.image:
                return node.image
            if node not in seen:
                seen.add(node)
                sockets += node.inputs
    return None


def image_file(image):
    """Reads the file of an image, packed or not; none for other kinds of images."""
    if image.packed_file:
        data = bytes(image.packed_file.data)
    else:
        try:
            data = Path(bpy.path.abspath(image.filepath, library=image.library)).read_bytes()
        except OSError:
            return None
    return data if data.startswith(IMAGES) else None


def told(scene, clips, frames):
    """What is told of the frames and of the space they are in."""
    units = scene.unit_settings
    lengths = [len(clip.frames) for clip in clips]
    return {
        "clip_names": np.array([clip.name for clip in clips]),
        "clip_starts": np.array(starts(lengths), np.int32),
        "frame_numbers": np.array(frames, np.int32),
        "fps": np.array(scene.render.fps / scene.render.fps_base),
        "up": np.array("z"),
        "forward": np.array("-y"),
        "unit": np.array(1.0 if units.system == "NONE" else units.scale_length),
    }


def starts(lengths):
    return [sum(lengths[:number]) for number in range(len(lengths))]


def at_rest(scene, frame, meshes, armature, bones, importance):
    """Evaluates the meshes at a frame, with every keyed property at rest, each as arrays by name.

    Returns the rest frames of the bones, too, and the names of the shape keys that are on.
    """
    if importance and not any(importance in mesh.vertex_groups for mesh in meshes):
        known = ", ".join(sorted({g.name for mesh in meshes for g in mesh.vertex_groups}))
        raise Problem(f"no mesh has a vertex group {importance}, only: {known or 'none'}")
    position, restore = armature.data.pose_position, []
    armature.data.pose_position = "REST"
    try:
        scene.frame_set(frame)
        restore = settle(scene)
        bpy.context.view_layer.update()
        rest = rest_frames(armature, bones)
        parts, shapes = [], []
        for mesh in meshes:
            with Evaluated(mesh) as (shape, world):
                part = faces(shape, world)
                part["rest"] = positions(shape, world)
                groups = {group.name: group.index for group in mesh.vertex_groups}
                own = [groups.get(bone.name) for bone in bones]
                part["joint_weights"] = weights(shape, own)
                if importance:
                    part["importance"] = np.ones(len(shape.vertices), np.float32)
                    if importance in groups:
                        part["importance"] = weights(shape, [groups[importance]])[:, 0]
            parts.append(part)
            shapes += shapes_that_are_on(mesh)
    finally:
        armature.data.pose_position = position
        for back in reversed(restore):
            back()
    if not any(len(part["quads"]) + len(part["tris"]) for part in parts):
        raise Problem(f"mesh {meshes[0].name} has no faces")
    return parts, rest, shapes


TRANSFORMS = ("location", "rotation_", "scale", "bbone_")


def settle(scene):
    """Puts keyed bones, custom properties and shape keys at their defaults; drivers follow.

    Returns functions that restore the values.
    """
    owners = [scene, scene.world]
    for thing in scene.objects:
        owners += [thing, thing.data, getattr(thing.data, "shape_keys", None)]
    restore = []
    for owner in dict.fromkeys(owner for owner in owners if owner is not None):
        for path, index in sorted(keyed(owner)):
            holder, _, name = path.rpartition(".")
            shape = holder.startswith("key_blocks[") and name == "value"
            bone = holder.startswith("pose.bones[") and name.startswith(TRANSFORMS)
            own = path.endswith('"]') and not path.startswith("modifiers[")
            if shape or bone or own:
                restore += reset(owner, path, index)
    return restore


def keyed(owner):
    """Lists the properties that the action and the NLA of a data-block move, each as path and index."""
    return {(curve.data_path, curve.array_index) for curve in curves_moving(owner)}


def curves_moving(owner):
    """Lists the animation curves of a data-block: of its action and its strips."""
    data = owner.animation_data
    if data is None:
        return []
    tracks = [t for t in data.nla_tracks if not t.mute] if data.use_nla else []
    actions = {data.action}.union(*(actions_of(track.strips) for track in tracks)) - {None}
    return [curve for action in actions for curve in curves_of(action)]


def curves_of(action):
    # From Blender 4.4 on an action has layers, and before 5.0 its curves as well.
    if hasattr(action, "layers"):
        bags = [bag for layer in action.layers for strip in layer.strips for bag in strip.channelbags]
        found = [curve for bag in bags for curve in bag.fcurves]
        if found:
            return found
    return list(getattr(action, "fcurves", []))


def reset(owner, path, index):
    """Puts a property at its default; returns a function that restores it, or none without a default."""
    try:
        if path.endswith("]"):
            holder, _, name = path[:-2].rpartition('["')
            name = bpy.utils.unescape_identifier(name)
            holder = owner.path_resolve(holder) if holder else owner
            default = holder.id_properties_ui(name).as_dict().get("default", 0)
            get, put = holder.__getitem__, holder.__setitem__
        else:
            holder, _, name = path.rpartition(".")
            holder = owner.path_resolve(holder)
            prop = holder.bl_rna.properties[name]
            default = prop.default_array if prop.is_array else prop.default
            if name == "value":
                # A shape key is off at rest; Blender 5 adds new ones switched on.
                default = 0
            get, put = partial(getattr, holder), partial(setattr, holder)
        before = get(name)
        if hasattr(before, "__len__"):
            before = list(before)
            value = list(before)
            value[index] = default[index] if hasattr(default, "__len__") else default
        else:
            value = type(before)(default)
        put(name, value)
    except (AttributeError, KeyError, TypeError, ValueError, IndexError):
        # A key without its property moves nothing.
        return []
    owner.update_tag()
    return [partial(put, name, before)]


def shapes_that_are_on(mesh):
    keys = mesh.data.shape_keys
    if keys is None or not keys.use_relative:
        return []
    keys = keys.evaluated_get(bpy.context.evaluated_depsgraph_get())
    on = [key for key in keys.key_blocks if key.value != 0 and not key.mute]
    return [f"{mesh.name} {key.name} ({key.value:.2f})" for key in on
            if key != keys.reference_key]


def faces(shape, world):
    """Gives the faces by vertices, texture coordinates, normals and material, turned over if mirrored."""
    quads = [p for p in shape.polygons if p.loop_total == 4]
    shape.calc_loop_triangles()
    others = {p.index: p.material_index for p in shape.polygons if p.loop_total != 4}
    tris = [t for t in shape.loop_triangles if t.polygon_index in others]
    uv, uv_of = coordinates(shape)
    normals, normal_of = corner_normals(shape, world)
    vertices, totals = corners(shape)
    part = {"uv": uv, "normals": normals, "corners": (vertices, totals)}
    for name, corner, count, material in (
        ("quads", [list(p.loop_indices) for p in quads], 4, [p.material_index for p in quads]),
        ("tris", [list(t.loops) for t in tris], 3, [others[t.polygon_index] for t in tris]),
    ):
        corner = np.array(corner, np.int32).reshape(-1, count)
        if np.linalg.det(world[:3, :3]) < 0:
            corner[:, 1:] = corner[:, :0:-1]
        part[name] = vertices[corner]
        part[f"{name}_uv"] = uv_of[corner] if len(uv) else np.zeros_like(corner)
        part[f"{name}_normals"] = normal_of[corner]
        part[f"{name}_material"] = np.array(material, np.int32)
    return part


def corners(shape):
    """Gives the vertex of every corner, and how many corners each face has."""
    vertices = np.empty(len(shape.loops), np.int32)
    shape.loops.foreach_get("vertex_index", vertices)
    totals = np.empty(len(shape.polygons), np.int32)
    shape.polygons.foreach_get("loop_total", totals)
    return vertices, totals


def coordinates(shape):
    """Texture coordinates, and which of them each corner has; none without a texture."""
    if shape.uv_layers.active is None:
        return np.empty((0, 2), np.float32), np.empty(0, np.int32)
    flat = np.empty(2 * len(shape.loops), np.float32)
    shape.uv_layers.active.data.foreach_get("uv", flat)
    uv, uv_of = np.unique(flat.reshape(-1, 2), axis=0, return_inverse=True)
    return uv, uv_of.reshape(-1).astype(np.int32)


def corner_normals(shape, world):
    """Normals in world space, with hard edges and custom normals, and which of them each corner has."""
    flat = np.empty(3 * len(shape.loops), np.float32)
    if hasattr(shape, "corner_normals"):
        shape.corner_normals.foreach_get("vector", flat)
    else:
        # Before Blender 4.1.
        shape.calc_normals_split()
        shape.loops.foreach_get("normal", flat)
    turned = flat.reshape(-1, 3) @ np.linalg.pinv(world[:3, :3])
    length = np.linalg.norm(turned, axis=1, keepdims=True)
    turned = (turned / np.where(length > 0, length, 1)).astype(np.float32)
    normals, normal_of = np.unique(turned, axis=0, return_inverse=True)
    return normals, normal_of.reshape(-1).astype(np.int32)


def weights(shape, groups):
    """How much each vertex weighs in some groups, by their numbers; nothing where there is none."""
    places = {group: place for place, group in enumerate(groups) if group is not None}
    found = np.zeros((len(shape.vertices), len(groups)), np.float32)
    for vertex in shape.vertices:
        for own in vertex.groups:
            if own.group in places:
                found[vertex.index, places[own.group]] = own.weight
    return found


def joined(meshes, parts):
    """Joins the meshes, the vertices of each behind those of the one before it."""
    firsts = starts([len(part["rest"]) for part in parts])
    textured = any(len(part["uv"]) for part in parts)
    for part in parts:
        if not len(part["uv"]):
            # As little as a texture can say.
            part["uv"] = np.zeros((1, 2), np.float32)
    first_uvs = starts([len(part["uv"]) for part in parts])
    first_normals = starts([len(part["normals"]) for part in parts])

    def behind(name, firsts):
        return np.concatenate([part[name] + first for part, first in zip(parts, firsts)])

    found = {"rest": np.concatenate([part["rest"] for part in parts])}
    for name in ("quads", "tris"):
        found[name] = behind(name, firsts)
        found[f"{name}_normals"] = behind(f"{name}_normals", first_normals)
        if textured:
            found[f"{name}_uv"] = behind(f"{name}_uv", first_uvs)
    if textured:
        found["uv"] = np.concatenate([part["uv"] for part in parts])
    found["normals"] = np.concatenate([part["normals"] for part in parts])
    for name in ("joint_weights", "importance"):
        if name in parts[0]:
            found[name] = np.concatenate([part[name] for part in parts])
    found["mesh_names"] = np.array([mesh.name for mesh in meshes])
    found["mesh_starts"] = np.array(firsts, np.int32)
    return {name: array.astype(np.int32) if array.dtype.kind == "i" else array
            for name, array in found.items() if len(array)}


def skeleton(rest, bones):
    numbers = {bone.name: number for number, bone in enumerate(bones)}

    def parent(bone):
        above = bone.parent
        while above is not None and above.name not in numbers:
            above = above.parent
        return -1 if above is None else numbers[above.name]

    return {
        "bone_names": np.array([bone.name for bone in bones]),
        "bone_parents": np.array([parent(bone) for bone in bones], np.int32),
        "joint_world_rest": np.array([rigid(frame) for frame in rest]),
    }


def rest_frames(armature, bones):
    world = np.array(armature.matrix_world)
    return np.array([world @ np.array(bone.matrix_local) for bone in bones])


def poses(scene, meshes, parts, armature, rest, bones, clips, found):
    """Evaluates meshes and bones frame by frame, and the values of the controls."""
    rest = np.linalg.inv(rest)
    frames = [(clip, frame) for clip in clips for frame in clip.frames]
    vertices = np.empty((len(frames), sum(len(part["rest"]) for part in parts), 3), np.float32)
    maps = np.empty((len(frames), len(bones), 4, 4))
    values = np.empty((len(frames), len(found)))
    playing = None
    for number, (clip, frame) in enumerate(frames):
        if clip is not playing:
            clip.play()
            playing = clip
        scene.frame_set(frame)
        values[number] = [control.read() for control in found]
        first = 0
        for mesh, part in zip(meshes, parts):
            with Evaluated(mesh) as (shape, world):
                check_same(frame, mesh, shape, part)
                vertices[number, first:first + len(shape.vertices)] = positions(shape, world)
                first += len(shape.vertices)
        posed = armature.evaluated_get(bpy.context.evaluated_depsgraph_get())
        world = np.array(posed.matrix_world)
        for joint, bone in enumerate(bones):
            maps[number, joint] = world @ np.array(posed.pose.bones[bone.name].matrix) @ rest[joint]
    return {"vertices": vertices, "bone_transforms": maps}, values


def check_same(frame, mesh, shape, part):
    remedy = "turn off the modifier that changes them"
    found, expected = len(shape.vertices), len(part["rest"])
    if found != expected:
        raise Problem(
            f"frame {frame}: mesh {mesh.name} has {found} vertices, at rest {expected}: {remedy}"
        )
    if not all(np.array_equal(a, b) for a, b in zip(corners(shape), part["corners"])):
        raise Problem(f"frame {frame}: mesh {mesh.name} has other faces than at rest: {remedy}")


def rigid(matrix):
    """Takes the scale out of a frame, which an armature in other units has."""
    matrix = matrix.copy()
    matrix[:3, :3] /= np.linalg.norm(matrix[:3, :3], axis=0)
    return matrix


def positions(shape, world):
    flat = np.empty(3 * len(shape.vertices), np.float32)
    shape.vertices.foreach_get("co", flat)
    return (flat.reshape(-1, 3) @ world[:3, :3].T + world[:3, 3]).astype(np.float32)


class Evaluated:
    """The mesh of an object as it is shown, and its world matrix."""

    def __init__(self, thing):
        self.thing = thing.evaluated_get(bpy.context.evaluated_depsgraph_get())

    def __enter__(self):
        return self.thing.to_mesh(), np.array(self.thing.matrix_world)

    def __exit__(self, *_):
        self.thing.to_mesh_clear()


# Range of motion: poses as `sinew poses` samples them.
# Share of a keyed range that is added on either side. An end this near to rest stays.
MARGIN = 0.1
# Turning channels of a bone by its rotation mode; the other modes are Euler angles.
TURNS = {"QUATERNION": "rotation_quaternion", "AXIS_ANGLE": "rotation_axis_angle"}


class RangeOfMotion:
    """Poses in which the bones and properties of a rig move alone, with neighbours, and all together.

    A mover is a bone or a property. Its channels are (owner, path, index, lowest, highest).
    """

    def __init__(self, scene, armature, meshes, bones, options):
        try:
            count = int(options.frames or 150)
        except ValueError:
            count = 0
        if count < 6:
            raise Problem(f"--frames {options.frames}: with --range-of-motion, expected a number of poses from 6")
        self.frames = list(range(1, count + 1))
        self.armature, self.back, self.movers = armature, [], {}
        keys = keyed_ranges(scene)
        turned = {bone_of(c[0], c[1], armature) for c in keys if is_bone(c[1])} - {None}
        if options.degrees:
            keys, turned = {}, turned or turning_bones(armature, bones)
        for bone in armature.pose.bones:
            if turned and bone.name not in turned:
                # Limits of a mechanism's bones are no controls.
                continue
            channels = rotations(armature, bone, keys, options.degrees)
            if channels:
                self.movers[bone.name] = channels
        limited = set(self.movers)
        for (owner, path, index), ends in keys.items():
            name = (owner, path)
            if is_bone(path):
                name = bone_of(owner, path, armature)
            if name and not (name in limited and ".rotation_" in path):
                self.movers.setdefault(name, []).append((owner, path, index, *ends))
        if all(isinstance(mover, str) for mover in self.movers):
            self.movers.update((channel[:2], [channel]) for channel in sliders(meshes))
        if not self.movers:
            raise Problem(f"no key and no limit says how far {armature.name} moves: give --degrees D, or limit the "
                          "bones' rotation")
        self.plan = plan(self.movers, self.parents(), count)

    def parents(self):
        """Gives the nearest moved ancestor of each moved bone."""
        found = {}
        for name in self.movers:
            if isinstance(name, str):
                above = self.armature.pose.bones[name].parent
                while above is not None and above.name not in self.movers:
                    above = above.parent
                found[name] = above and above.name
        return found

    def owners(self):
        """Lists the things that have the moved properties."""
        return [channel[0] for channels in self.movers.values() for channel in channels]

    def insert_keys(self):
        """Puts the poses into new actions, a frame each."""
        for owner in dict.fromkeys([self.armature, *self.owners()]):
            data = owner.animation_data or owner.animation_data_create()
            slot = getattr(data, "action_slot", None)
            self.back.append(partial(put_action, owner, data.action, slot, data.use_nla))
            data.use_nla, data.action = False, None
        for name, channels in self.movers.items():
            if isinstance(name, str) and any("rotation_euler" in c[1] for c in channels):
                bone = self.armature.pose.bones[name]
                if bone.rotation_mode in ("QUATERNION", "AXIS_ANGLE"):
                    self.back.append(partial(setattr, bone, "rotation_mode", bone.rotation_mode))
                    bone.rotation_mode = "XYZ"
            for number, channel in enumerate(channels):
                owner, path, index, least, most = channel
                get, put, default = accessors(owner, path, index)
                self.back.append(partial(put, get()))
                element = index if hasattr(owner.path_resolve(path), "__len__") else -1
                for frame, places in zip(self.frames, self.plan):
                    place = places.get(name)
                    put(default if place is None else least + (most - least) * place[number])
                    owner.keyframe_insert(path, index=element, frame=frame)

    def restore(self):
        for back in reversed(self.back):
            back()


def put_action(owner, action, slot, use_nla):
    data = owner.animation_data
    made = data.action
    data.action, data.use_nla = action, use_nla
    if slot is not None:
        data.action_slot = slot
    if made is not None:
        bpy.data.actions.remove(made)


def is_bone(path):
    return path.startswith("pose.bones[") and not path.endswith("]")


def bone_of(owner, path, armature):
    """Gives the name of the armature's bone that a path moves; none if it moves another or nothing."""
    holder, _, name = path.rpartition(".")
    if owner != armature:
        return None
    bone = owner.path_resolve(holder)
    return None if name.startswith("rotation_") and name != turning(bone) else bone.name


def turning(bone):
    return TURNS.get(bone.rotation_mode, "rotation_euler")


def turning_bones(armature, bones):
    """Gives the names of the written bones that nothing else turns, else of the controls: bones with a custom shape."""
    def is_free(bone):
        driven = any(not c.mute and not c.type.startswith("LIMIT_") for c in bone.constraints)
        return not driven and not all(bone.lock_rotation)

    free = [bone for bone in armature.pose.bones if is_free(bone)]
    written = {bone.name for bone in bones}
    return {b.name for b in free if b.name in written} or {b.name for b in free if b.custom_shape}


def keyed_ranges(scene):
    """Gives the range of the keys of each bone channel, custom property and shape key, and a margin."""
    owners = [scene, scene.world]
    for thing in scene.objects:
        owners += [thing, thing.data, getattr(thing.data, "shape_keys", None)]
    found = {}
    for owner in dict.fromkeys(owner for owner in owners if owner is not None):
        for curve in curves_moving(owner):
            path, index = curve.data_path, curve.array_index
            holder, _, name = path.rpartition(".")
            shape = holder.startswith("key_blocks[") and name == "value"
            bone = holder.startswith("pose.bones[") and name.startswith(TRANSFORMS)
            own = path.endswith('"]') and not path.startswith("modifiers[")
            access = (shape or bone or own) and accessors(owner, path, index)
            if access:
                values = [point.co[1] for point in curve.keyframe_points] + [access[2]]
                least, most = found.get((owner, path, index), (access[2], access[2]))
                found[owner, path, index] = min(values + [least]), max(values + [most])
    for (owner, path, index), (least, most) in list(found.items()):
        rest, margin = accessors(owner, path, index)[2], MARGIN * (most - least)
        if margin < 1e-5:
            del found[owner, path, index]
            continue
        least -= margin if rest - least > margin else 0
        most += margin if most - rest > margin else 0
        found[owner, path, index] = least, most
    return found


def accessors(owner, path, index):
    """Gives functions that read and write a number, and its default; none for other properties."""
    try:
        if path.endswith("]"):
            holder, _, name = path[:-2].rpartition('["')
            name = bpy.utils.unescape_identifier(name)
            holder = owner.path_resolve(holder) if holder else owner
            default = holder.id_properties_ui(name).as_dict().get("default", 0)
            get, put = partial(holder.__getitem__, name), partial(holder.__setitem__, name)
        else:
            holder, _, name = path.rpartition(".")
            holder = owner.path_resolve(holder)
            prop = holder.bl_rna.properties[name]
            # A shape key is off at rest; Blender 5 adds new ones switched on.
            default = 0 if name == "value" else prop.default_array if prop.is_array else prop.default
            get, put = partial(getattr, holder, name), partial(setattr, holder, name)
        value = get()
        if hasattr(value, "__len__") and not isinstance(value, str):
            default = default[index] if hasattr(default, "__len__") else default

            def put_one(number):
                whole = list(get())
                whole[index] = number
                put(whole)

            return (lambda: get()[index]), put_one, default
        kind = type(value)
        if kind is not float:
            return get, (lambda number: put(kind(round(number)))), kind(default)
        return get, put, default
    except (AttributeError, KeyError, TypeError, ValueError, IndexError):
        return None


def rotations(armature, bone, keys, degrees):
    """Gives the channels by which a bone turns: within its limits, or by some degrees."""
    limits = {}
    for axis, name in enumerate("xyz"):
        if getattr(bone, f"use_ik_limit_{name}"):
            limits[axis] = [getattr(bone, f"ik_{end}_{name}") for end in ("min", "max")]
        for limit in bone.constraints:
            if (limit.type == "LIMIT_ROTATION" and limit.owner_space == "LOCAL" and not limit.mute
                    and getattr(limit, f"use_limit_{name}")):
                limits[axis] = [getattr(limit, f"{end}_{name}") for end in ("min", "max")]
    if degrees:
        for axis in range(3):
            limits.setdefault(axis, [-math.radians(degrees), math.radians(degrees)])
    base = f'pose.bones["{bpy.utils.escape_identifier(bone.name)}"].'
    if bone.rotation_mode in TURNS and any((armature, base + turning(bone), i) in keys for i in range(4)):
        # Keyed quaternions are no angles about axes; the limits hold all the same.
        return []
    return [(armature, base + "rotation_euler", axis, *ends) for axis, ends in sorted(limits.items())
            if not bone.lock_rotation[axis] and ends[1] > ends[0]]


def sliders(meshes):
    """Gives the shape keys that nothing drives, and the custom properties that drive others, over their sliders."""
    found = {}
    for keys in dict.fromkeys(mesh.data.shape_keys for mesh in meshes):
        if keys is None or not keys.use_relative:
            continue
        drivers = list(keys.animation_data.drivers) if keys.animation_data else []
        driven = {driver.data_path for driver in drivers}
        for key in keys.key_blocks:
            path = key.path_from_id("value")
            if key != keys.reference_key and path not in driven and not key.mute:
                found[keys, path] = (keys, path, 0, key.slider_min, key.slider_max)
        targets = [t for d in drivers for v in d.driver.variables if v.type == "SINGLE_PROP" for t in v.targets]
        for target in targets:
            path = target.data_path
            if target.id is not None and path.endswith('"]') and accessors(target.id, path, 0):
                holder, _, name = path[:-2].rpartition('["')
                holder = target.id.path_resolve(holder) if holder else target.id
                ends = holder.id_properties_ui(bpy.utils.unescape_identifier(name)).as_dict()
                # A property without sliders has the range of all numbers.
                ends = [ends.get("soft_min", 0), ends.get("soft_max", 1)]
                ends = ends if max(map(abs, ends)) < 1e3 else [0, 1]
                found[target.id, path] = (target.id, path, 0, *ends)
    return list(found.values())


def plan(movers, parents, count):
    """Plans poses: at most a third for movers alone, at most a third for pairs, and the rest for all.

    Each pose has a place from 0 to 1 in the range of each channel of the movers that move in it.
    """
    chance = random.Random(0)
    joints = [name for name in movers if isinstance(name, str)]
    others = [name for name in movers if not isinstance(name, str)]
    pairs = [[parents[name], name] for name in joints if parents[name]]
    pairs += [[a, b] for number, b in enumerate(others) for a in others[:number]]
    chance.shuffle(pairs)
    lines = {name: [name] for name in joints}
    for line in lines.values():
        while parents[line[-1]]:
            line.append(parents[line[-1]])

    def steps(a, b):
        if a == b:
            return 0
        if a not in lines or b not in lines:
            return 1
        return next((up + lines[b].index(name) for up, name in enumerate(lines[a]) if name in lines[b]), math.inf)

    # Two poses reach both ends of a range.
    gaps = {a: {b: steps(a, b) for b in movers} for a in movers}
    alone = share_out([[name] for name in movers], count // 3, 2, gaps)
    paired = share_out(pairs, count // 3, 1, gaps)
    poses = []
    for block in (alone, paired, [list(movers)] * (count - len(alone) - len(paired))):
        own = [{} for _ in block]
        for name, channels in movers.items():
            moved = [number for number, names in enumerate(block) if name in names]
            columns = [strata(len(moved), channel, chance) for channel in channels]
            for row, number in enumerate(moved):
                own[number][name] = [column[row] for column in columns]
        poses += own
    return poses


def share_out(sets, count, each, gaps):
    """Gives each set of movers its own poses; if there are too few, sets that are far apart share them."""
    places = min(len(sets), count // each)
    shared = [set() for _ in range(places)]
    nearest = [dict.fromkeys(gaps, math.inf) for _ in range(places)]
    for movers in sets if places else []:
        best = max(range(places), key=lambda at: (
            min(nearest[at][name] for name in movers), -len(shared[at]), -at))
        shared[best].update(movers)
        for name in movers:
            nearest[best] = {other: min(gap, gaps[name][other]) for other, gap in nearest[best].items()}
    return [names for names in shared for _ in range(count // places)]


def strata(count, channel, chance):
    """Gives evenly spaced numbers from 0 to 1 in random order, without an end at rest: other poses show it."""
    owner, path, index, least, most = channel
    rest = accessors(owner, path, index)[2]
    first, steps = int(least == rest), count - 1 + (least == rest) + (most == rest)
    if steps < 1:
        return [chance.random() for _ in range(count)]
    numbers = [number / steps for number in range(first, count + first)]
    chance.shuffle(numbers)
    return numbers


if __name__ == "__main__":
    # Blender hands over what stands behind "--", with its own arguments before it.
    given = sys.argv[sys.argv.index("--") + 1:] if "--" in sys.argv else sys.argv[1:]
    try:
        main(given)
    except Problem as problem:
        sys.exit(f"blender_export.py: {problem}")
    except Exception as error:
        sys.exit(f"blender_export.py: the scene has something that this script does not expect "
                 f"({type(error).__name__}: {one_line(error)}): leave meshes out with --mesh, and report it")
