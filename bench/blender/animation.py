# SPDX-License-Identifier: Apache-2.0
"""Thirty frames, killed in the middle, started again; and how much a caustic that stands still flickers.

  CAUSTICS_BIN=build/bin blender -b --factory-startup --python bench/blender/animation.py -- [FRAMES]

Starts a Blender of its own on a file with Render Animation and the add-on's "With Every Render", kills it with SIGKILL when half of
the frames are there, starts it again (frames that exist are not rendered again), and looks for every frame's three files.
Flicker: the scene stands still but for a box beyond the picture; standard deviation over the frames of each pixel, RMS over
the layer, beside the layer's own error, once with one seed for all frames (as the add-on does) and once with a seed per frame."""
import os
import signal
import subprocess
import sys
import tempfile
import time

import bpy

HERE = os.path.dirname(os.path.abspath(__file__))
ROOT = os.path.dirname(os.path.dirname(HERE))
sys.path.insert(0, os.path.join(ROOT, "tests", "blender_addon"))
from support import built, caustics, layers, np  # noqa: E402

FRAMES = int(sys.argv[sys.argv.index("--") + 1]) if sys.argv[-1].isdigit() else 30
PHOTONS = 100000
RENDER = "import sys; sys.path.insert(0, %r); import caustics; caustics.register(); import bpy; bpy.ops.render.render(animation=True)"


def scene_in(folder):
    scene = built.empty()
    built.table()
    scene.frame_start, scene.frame_end = 1, FRAMES
    moving = built.ball("Beyond", None, (30, 30, 0), 1)
    for frame, x in ((1, 30), (FRAMES, 40)):
        moving.location.x = x
        moving.keyframe_insert("location", frame=frame)
    s, r = scene.caustics, scene.render
    s.with_render, s.output, s.photons_million, s.threads = True, os.path.join(folder, "film", "shot"), PHOTONS / 1e6, 2
    im = r.image_settings
    if hasattr(im, "media_type"):
        im.media_type = "MULTI_LAYER_IMAGE"
    im.file_format, r.use_overwrite, r.filepath = "OPEN_EXR_MULTILAYER", False, os.path.join(folder, "beauty_")
    bpy.ops.wm.save_as_mainfile(filepath=os.path.join(folder, "shot.blend"))


def start(folder):
    words = ["-b", "--factory-startup", os.path.join(folder, "shot.blend"), "--python-expr", RENDER % os.path.join(ROOT, "plugins", "blender")]
    return subprocess.Popen([bpy.app.binary_path or "blender", *words], stdout=subprocess.DEVNULL, start_new_session=True)


def frames_there(folder):
    film = os.path.join(folder, "film")
    return {n for n in range(1, FRAMES + 1) if os.path.exists(os.path.join(film, f"shot_{n:04d}.exr"))}


def killed(folder):
    scene_in(folder)
    child = start(folder)
    while len(frames_there(folder)) < FRAMES // 2 and child.poll() is None:
        time.sleep(0.02)
    os.killpg(child.pid, signal.SIGKILL)
    child.wait()
    half = len(frames_there(folder))
    child = start(folder)
    child.wait()
    lost = [n for n in range(1, FRAMES + 1) for path in (f"film/shot_{n:04d}.exr", f"film/shot_{n:04d}_caustics.exr", f"beauty_{n:04d}.exr")
            if not os.path.exists(os.path.join(folder, path)) or not layers(os.path.join(folder, path))]
    print(f"ANIMATION {FRAMES} frames, killed at {half}: lost after the second start: {lost or 'none'}", flush=True)
    return not lost


def spread(folder, names):
    pictures = np.array([layers(os.path.join(folder, n))["caustics_Key"].mean(-1) for n in names])
    rms = np.sqrt((pictures.mean(0)**2).mean())
    return np.sqrt(pictures.var(0, ddof=1).mean()) / rms


def flicker(folder):
    same = spread(folder, [f"film/shot_{n:04d}_caustics.exr" for n in range(1, FRAMES + 1)])
    made = caustics.export(os.path.join(folder, "scene"))
    for n in range(1, 9):
        subprocess.run([os.path.join(os.environ["CAUSTICS_BIN"], "caustic-render"), made.path, "-o", os.path.join(folder, f"seed_{n}.exr"), "--photons",
                        str(PHOTONS), "--seed", str(n), "--quiet"], check=True)
    other = spread(folder, [f"seed_{n}.exr" for n in range(1, 9)])
    print(f"FLICKER one seed {100 * same:.2f} %, a seed per frame {100 * other:.2f} % (the spatial error of a frame)", flush=True)


caustics.register()
with tempfile.TemporaryDirectory() as place:
    good = killed(place)
    flicker(place)
os._exit(0 if good else 1)
