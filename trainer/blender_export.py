"""Writes example poses of a rigged character, for `sinew train`.

Whatever Blender shows is what is written: muscles, correctives, simulation, any modifier that keeps
the meshes' vertices. For each frame it evaluates the meshes and the bones that deform them, in
world space. All visible meshes of the armature are joined, in the scene's order; the strips of its
NLA become clips by name, or all frames are one clip called as its action. Names, frame rate and
numbers, axes, unit, joint weights (vertex groups called as bones) and texture coordinates go with
them.

The rest mesh is taken at the first frame, with the armature in its rest position. Every keyed shape
key, custom property and bone has its default there, and drivers follow. Properties without keys keep
their value in all frames, and at rest too.

    blender rig.blend --background --python blender_export.py -- examples.npz
    python blender_export.py --blend rig.blend examples.npz        (with `pip install bpy`)

Options: --mesh NAME, several times for several (all of the armature otherwise), --armature NAME
(needed where there are several), --frames FIRST:LAST[:STEP] (the strips' own otherwise, or the
scene's), --clips one (frames of no strip too, as one clip), --importance GROUP (a vertex counts as
much as it weighs in the group: outside of it not at all, and fully in meshes without the group),
--bones all (the deforming ones otherwise).
"""

import argparse
import math
import sys
from functools import partial
from pathlib import Path

import bpy
import numpy as np

# Strips begin and end at fractions of frames, rounded.
FRACTION = 1e-3
ONE = "--clips one takes every frame, as one clip"


class Problem(Exception):
    """Something about the scene that the user can mend."""


def main(arguments):
    options = parse(arguments)
    if options.blend:
        bpy.ops.wm.open_mainfile(filepath=str(options.blend))
    scene = bpy.context.scene
    meshes, armature = find(scene, options)
    bones = deforming(armature, options.bones)
    clips = chosen_clips(scene, armature, options)
    frames = [frame for _, own in clips for frame in own]
    before = scene.frame_current
    try:
        parts, rest, shapes = at_rest(scene, frames[0], meshes, armature, bones, options.importance)
        posed = poses(scene, meshes, parts, armature, rest, bones, frames)
    finally:
        scene.frame_set(before)
    examples = {
        **joined(meshes, parts),
        **skeleton(rest, bones),
        **posed,
        **told(scene, clips, frames),
    }
    # The last name decides the format: numpy would add .npz to any other.
    with open(options.output, "wb") as file:
        np.savez_compressed(file, **examples)
    names = ", ".join(f"{name} ({own[0]} to {own[-1]})" for name, own in clips)
    print(
        f"wrote {options.output}: {len(examples['rest'])} vertices, {len(bones)} joints, "
        f"{len(frames)} frames at {float(examples['fps']):g} a second\n"
        f"  meshes: {', '.join(mesh.name for mesh in meshes)}\n"
        f"  clips: {names}\n"
        f"  rest mesh: of frame {frames[0]}, armature, keys and drivers at rest"
    )
    if shapes:
        note(f"shape keys that are on at rest, as no key moves them: {', '.join(shapes)}")


def parse(arguments):
    parser = argparse.ArgumentParser(prog="blender_export.py", description=__doc__,
                                     formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("output", type=Path, help="where to write the examples (.npz)")
    parser.add_argument("--blend", type=Path, help="the file to open, outside of Blender")
    parser.add_argument("--mesh", action="append", help="a mesh object; may be given several times")
    parser.add_argument("--armature", help="the armature object")
    parser.add_argument("--frames", help="FIRST:LAST or FIRST:LAST:STEP")
    parser.add_argument("--clips", choices=["strips", "one"], help="the NLA's strips, or all as one")
    parser.add_argument("--importance", metavar="GROUP", help="a vertex group")
    parser.add_argument("--bones", choices=["deforming", "all"], default="deforming")
    options = parser.parse_args(arguments)
    if options.output.suffix != ".npz":
        parser.error(f"{options.output}: expected a name that ends in .npz")
    return options


def note(text):
    print(f"blender_export.py: {text}", file=sys.stderr)


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


def chosen_clips(scene, armature, options):
    """Gives the clips in order, each a name and its frames' numbers: one a strip, or all as one."""
    asked = frame_numbers(scene, options.frames)
    strips, why = ([], "") if options.clips == "one" else shown_strips(armature)
    if not strips:
        if options.clips == "strips":
            raise Problem(f"the NLA of {armature.name} {why or 'plays no strip'}")
        if why:
            note(f"the NLA of {armature.name} {why}: all frames are one clip")
        action = armature.animation_data and armature.animation_data.action
        return [(action.name if action else scene.name, asked)]
    covered, clips = set(), []
    for strip, after in zip(strips, strips[1:] + [None]):
        last = strip.frame_end + FRACTION
        if after is not None:
            # The frame in which two strips meet is the later one's.
            last = min(last, after.frame_start - FRACTION)
        own = range(math.ceil(strip.frame_start - FRACTION), math.floor(last) + 1)
        covered.update(own)
        own = [f for f in asked if f in own] if options.frames else list(own[::scene.frame_step])
        if own:
            clips.append((strip.name, own))
    if not clips:
        raise Problem(f"--frames {options.frames}: no strip of {armature.name} is there ({ONE})")
    left = sum(frame not in covered for frame in asked)
    if left:
        note(f"frames of no strip are left out: {left} ({ONE})")
    return clips


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
    for strip, after in zip(strips, strips[1:]):
        if after.frame_start < strip.frame_end - FRACTION:
            return [], f"has strips that overlap, {strip.name} and {after.name}"
    return strips, ""


def told(scene, clips, frames):
    """What is told of the frames and of the space they are in."""
    units = scene.unit_settings
    lengths = [len(own) for _, own in clips]
    return {
        "clip_names": np.array([name for name, _ in clips]),
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
                part = faces(shape, np.linalg.det(world[:3, :3]) < 0)
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
    data = owner.animation_data
    if data is None:
        return set()
    actions = {data.action}
    tracks = [t for t in data.nla_tracks if not t.mute] if data.use_nla else []
    strips = [strip for track in tracks for strip in track.strips]
    while strips:
        strip = strips.pop()
        actions.add(strip.action)
        # Strips of a meta strip.
        strips += getattr(strip, "strips", [])
    return {(curve.data_path, curve.array_index)
            for action in actions - {None} for curve in curves_of(action)}


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


def faces(shape, mirrored):
    """Gives the faces by vertices and by texture coordinates, turned over where mirrored."""
    quads = [list(p.loop_indices) for p in shape.polygons if p.loop_total == 4]
    shape.calc_loop_triangles()
    others = {p.index for p in shape.polygons if p.loop_total != 4}
    tris = [list(t.loops) for t in shape.loop_triangles if t.polygon_index in others]
    uv, uv_of = coordinates(shape)
    vertices, totals = corners(shape)
    part = {"uv": uv, "corners": (vertices, totals)}
    for name, corner, count in (("quads", quads, 4), ("tris", tris, 3)):
        corner = np.array(corner, np.int32).reshape(-1, count)
        if mirrored:
            corner[:, 1:] = corner[:, :0:-1]
        part[name] = vertices[corner]
        part[f"{name}_uv"] = uv_of[corner] if len(uv) else np.zeros_like(corner)
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

    def behind(name, firsts):
        return np.concatenate([part[name] + first for part, first in zip(parts, firsts)])

    found = {"rest": np.concatenate([part["rest"] for part in parts])}
    for name in ("quads", "tris"):
        found[name] = behind(name, firsts)
        if textured:
            found[f"{name}_uv"] = behind(f"{name}_uv", first_uvs)
    if textured:
        found["uv"] = np.concatenate([part["uv"] for part in parts])
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


def poses(scene, meshes, parts, armature, rest, bones, frames):
    rest = np.linalg.inv(rest)
    vertices = np.empty((len(frames), sum(len(part["rest"]) for part in parts), 3), np.float32)
    maps = np.empty((len(frames), len(bones), 4, 4))
    for number, frame in enumerate(frames):
        scene.frame_set(frame)
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
    return {"vertices": vertices, "bone_transforms": maps}


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


if __name__ == "__main__":
    # Blender hands over what stands behind "--", with its own arguments before it.
    given = sys.argv[sys.argv.index("--") + 1:] if "--" in sys.argv else sys.argv[1:]
    try:
        main(given)
    except Problem as problem:
        sys.exit(f"blender_export.py: {problem}")
