"""Checks a foreign implementation of the stage `skin` against vectors of `cargo xtask vectors OUT/`.

    python3 vectors.py OUT/

The implementation is plain linear blend skinning of positions, in Python's f64. Put yours in its
place: skin() is given a palette and the mesh. Needs Python 3.8 and no packages.
"""

import array
import json
import pathlib
import sys


def skin(palette, positions, indices, weights, influence_len):
    """Skins one pose: a palette of 12 floats a transform, 3 floats a vertex, K influences of each."""
    out = []
    for vertex in range(len(positions) // 3):
        x, y, z = positions[3 * vertex : 3 * vertex + 3]
        for row in range(3):
            total = 0.0
            for k in range(vertex * influence_len, (vertex + 1) * influence_len):
                a, b, c, d = palette[12 * indices[k] + 4 * row :][:4]
                total += weights[k] * (a * x + b * y + c * z + d)
            out.append(total)
    return out


def read(folder, file):
    """Reads a file of little-endian values; its name tells the type."""
    values = array.array({".f32": "f", ".u32": "I"}[pathlib.Path(file).suffix])
    values.frombytes((folder / file).read_bytes())
    if sys.byteorder == "big":
        values.byteswap()
    return values.tolist()


def check(folder):
    """Returns the largest error of a case in units of its tolerance, and how many values it has."""
    case = json.loads((folder / "case.json").read_text())
    arrays = {entry["name"]: read(folder, entry["file"]) for entry in case["arrays"]}
    stage = next(stage for stage in case["stages"] if stage["stage"] == "skin")
    output = next(output for output in stage["outputs"] if output["array"] == "positions")
    poses, transforms = case["counts"]["poses"], case["counts"]["palette"]
    mesh = [arrays[name] for name in ("rest_positions", "influence_indices", "influence_weights")]
    found = []
    for pose in range(poses):
        palette = arrays["palette"][12 * transforms * pose : 12 * transforms * (pose + 1)]
        found += skin(palette, *mesh, case["counts"]["influences"])
    expected, tolerance = arrays["positions"], read(folder, output["tolerance"])
    if not len(found) == len(expected) == len(tolerance):
        return float("inf"), len(expected)
    errors = [abs(f - e) for f, e in zip(found, expected)]
    # Written so that a NaN fails.
    if not all(error <= t for error, t in zip(errors, tolerance)):
        return float("inf"), len(expected)
    return max((e / t for e, t in zip(errors, tolerance) if e > 0), default=0.0), len(expected)


folders = sorted(path.parent for path in pathlib.Path(sys.argv[1]).glob("*/case.json"))
# Kernels, shapes and filters have nothing to skin.
others = ("kernel-", "shapes-", "filter-")
folders = [folder for folder in folders if not folder.name.startswith(others)]
results = [(folder.name, *check(folder)) for folder in folders]
for name, ratio, values in results:
    print(f"{name}: {values} values, {ratio:.3f} of the tolerance")
sys.exit(0 if sum(values for *_, values in results) and max(r for _, r, _ in results) <= 1 else 1)
