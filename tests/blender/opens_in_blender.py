# SPDX-License-Identifier: Apache-2.0
"""Blender's compositor shows our layers under their names, with our values, from both kinds of file.

Blender runs this file too, in its own Python, as  blender -b --python opens_in_blender.py -- FILE OUT_FOLDER."""
import json
import os
import subprocess
import sys


def inside_blender(path, folder):
    """Prints the names of the image node's sockets and writes what comes out of each as OUT_FOLDER/NAME0001.exr."""
    import bpy  # only Blender's Python has it

    scene = bpy.context.scene
    image = bpy.data.images.load(path)
    scene.use_nodes = True
    tree = scene.node_tree
    tree.nodes.clear()
    node = tree.nodes.new("CompositorNodeImage")
    node.image = image
    print("SOCKETS " + json.dumps([image.type, [s.name for s in node.outputs]]), flush=True)
    out = tree.nodes.new("CompositorNodeOutputFile")
    out.base_path = folder
    out.format.file_format, out.format.color_depth, out.format.exr_codec = "OPEN_EXR", "32", "NONE"
    out.file_slots.clear()
    for socket in node.outputs:
        out.file_slots.new(socket.name)
        tree.links.new(socket, out.inputs[-1])
    tree.links.new(node.outputs[0], tree.nodes.new("CompositorNodeComposite").inputs[0])
    # The compositor runs after a render; of an empty scene, of the layers' size.
    for thing in list(bpy.data.objects):
        if thing.type != "CAMERA":
            bpy.data.objects.remove(thing)
    render = scene.render
    render.engine, scene.cycles.samples, scene.cycles.device = "CYCLES", 1, "CPU"
    render.resolution_x, render.resolution_y, render.resolution_percentage = 32, 18, 100
    render.threads_mode, render.threads, render.use_sequencer = "FIXED", 1, False
    scene.frame_set(1)
    bpy.ops.render.render()


def run_blender(blender, path, folder):
    environment = {**os.environ, "HOME": folder, "BLENDER_USER_CONFIG": folder}
    command = [blender, "-b", "--factory-startup", "--python-exit-code", "3", "--python", __file__, "--", path, folder]
    done = subprocess.run(command, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True, env=environment,
                          check=False)
    said = [line for line in done.stdout.splitlines() if line.startswith("SOCKETS ")]
    if done.returncode or not said:
        raise SystemExit(f"blender: exit code {done.returncode}\n{done.stdout}")
    return json.loads(said[0][len("SOCKETS "):])


def main():
    import shutil
    import tempfile

    from layers import LONG, NAMED, SUFFIXES, Check, np, read, render

    blender = shutil.which(os.environ.get("BLENDER", "blender"))
    if not blender:
        print("not run: no blender in the path; Debian's package is called blender")
        sys.exit(77)
    print(subprocess.run([blender, "--version"], capture_output=True, text=True, check=True).stdout.splitlines()[0])
    check = Check()
    for options in ([], ["--interleave"], ["--type", "half"]):
        with tempfile.TemporaryDirectory(prefix="caustics_blender_") as folder:
            path = render(folder, "layers.exr", *options)
            planes, attributes = read(path)
            layers = json.loads(attributes["caustics/layers"])
            stem = next(x["layer"] for x in layers if x["light"] == LONG and x["kind"] == "radiance")
            names = NAMED + [stem + s for s in SUFFIXES]
            kind, sockets = run_blender(blender, path, folder)
            what = " ".join(options) or "one part per layer"
            check.that(kind == "MULTILAYER", f"{what}: opens as {kind}")
            # The bare R, G, B are Combined; Blender adds an alpha to it.
            check.that(sorted(sockets) == sorted(names + ["Combined", "Alpha"]),
                       f"{what}: {len(sockets)} sockets, of all layers: {' '.join(sockets)}")
            same = []
            for name in sockets:
                if name == "Alpha":
                    continue
                got = read(os.path.join(folder, name + "0001.exr"))[0]
                ours = [planes[f"{name}.{c}" if name != "Combined" else c] for c in "RGB"]
                same.append(all(np.array_equal(got[c], plane) for c, plane in zip("RGB", ours)))
            lit = sum(float(planes[f"{n}.G"].max()) > 0 for n in names)
            check.that(all(same) and lit == len(names),
                       f"{what}: {sum(same)} of {len(same)} sockets give the file's values bit for bit, {lit} not black")
    check.end()


if __name__ == "__main__":
    if "--" in sys.argv:
        inside_blender(*sys.argv[sys.argv.index("--") + 1:])
    else:
        main()
