# SPDX-License-Identifier: Apache-2.0
"""The renderer inside Blender, as an option: libcaustics-io by ctypes, with the interface of programs.Child.

Blender brings an Embree and an OpenEXR of its own, whose functions have the names that ours import. So the libraries are loaded
with RTLD_DEEPBIND, by which each looks in its own dependencies first, and RTLD_LOCAL, by which Blender does not see them.
That leaves a library of the very same file name that Blender has loaded already: the loader gives us that one.

Where Blender has an allocator in place of the C library's (Debian's has jemalloc) RTLD_DEEPBIND would give ours another one than
the C++ library has, and memory that one gives the other would free. There it is left out, and what Blender would then
capture is looked up: if anything, the render is refused."""
import ctypes
import os
import threading

from . import programs
from .errors import CausticsError

CORE, LIBRARY = "libcaustics.so.0", "libcaustics-io.so.0"
MODE = os.RTLD_LOCAL | os.RTLD_NOW
CAPTURED = ("rtcNewDevice", "rtcIntersect1", "exr_start_read", "exr_start_write")  # what hosts are known to export
CANCELLED = 3
WANT = {"radiance": 1, "irradiance": 4, "error": 8}
INDIRECT = {"AUTO": 0, "ON": 1, "OFF": 2}
ESTIMATOR = {"": 0, "P": 1, "R": 2, "W": 3}


class RenderOptions(ctypes.Structure):
    _fields_ = [("size", ctypes.c_size_t), ("photons", ctypes.c_uint64), ("time_s", ctypes.c_double), ("error", ctypes.c_double),
                ("seed", ctypes.c_uint64), ("threads", ctypes.c_uint), ("width", ctypes.c_int), ("height", ctypes.c_int),
                ("region", ctypes.c_int * 4), ("estimator", ctypes.c_int), ("layers", ctypes.c_uint), ("indirect", ctypes.c_int),
                ("physical_radiance", ctypes.c_int), ("memory_bytes", ctypes.c_size_t), ("shard_index", ctypes.c_uint),
                ("shard_count", ctypes.c_uint)]


class Progress(ctypes.Structure):
    _fields_ = [("passes", ctypes.c_uint64), ("photons_per_light", ctypes.c_uint64), ("error", ctypes.c_double),
                ("elapsed_s", ctypes.c_double), ("remaining_s", ctypes.c_double), ("stage", ctypes.c_char_p)]


class WriteOptions(ctypes.Structure):
    _fields_ = [("size", ctypes.c_size_t), ("half", ctypes.c_int), ("interleave", ctypes.c_int), ("crop", ctypes.c_int),
                ("complete", ctypes.c_int), ("seed", ctypes.c_uint64), ("photons", ctypes.c_uint64), ("shard_index", ctypes.c_uint),
                ("shard_count", ctypes.c_uint), ("stamp", ctypes.c_int)]


POINTER, TEXT, RESULT = ctypes.c_void_p, ctypes.c_char_p, ctypes.c_int32
CALLS = {  # name: (result, arguments)
    "cau_version": (TEXT, ()), "cau_context_create": (RESULT, (POINTER,)), "cau_context_destroy": (None, (POINTER,)),
    "cau_error_text": (TEXT, (POINTER,)), "cau_scene_load_file": (RESULT, (POINTER, TEXT, POINTER)), "cau_scene_destroy": (None, (POINTER,)),
    "cau_render_defaults": (RenderOptions, ()), "cau_render_create": (RESULT, (POINTER, POINTER, POINTER)),
    "cau_render_destroy": (None, (POINTER,)), "cau_render_start": (RESULT, (POINTER,)), "cau_render_poll": (Progress, (POINTER,)),
    "cau_render_cancel": (None, (POINTER,)), "cau_render_wait": (RESULT, (POINTER, ctypes.c_double, POINTER, POINTER)),
    "cau_render_explain": (TEXT, (POINTER,)), "cau_render_warning": (TEXT, (POINTER, ctypes.c_size_t)),
    "cau_render_write": (RESULT, (POINTER, POINTER, TEXT, POINTER)), "cau_render_write_report": (RESULT, (POINTER, POINTER, TEXT)),
}


# ---- loading ---------------------------------------------------------------------------------------------------------

def places():
    """Folders that may hold the library: the zip's, or beside the programs that are used, as built or installed."""
    given = programs.folder()
    if not given and os.path.isdir(os.path.join(programs.HERE, "lib")):
        return [os.path.join(programs.HERE, "lib")]
    beside = [given] if given else os.environ.get("PATH", "").split(os.pathsep)
    return [os.path.join(p, q) for p in beside if p for q in ("", "../lib", "..")]


def load():
    """The library, ready to call. Stays loaded: Embree's threads have no way back."""
    path = next((p for p in (os.path.join(place, LIBRARY) for place in places()) if os.path.isfile(p)), LIBRARY)
    allocator = own_allocator()
    mode = MODE | (0 if allocator else os.RTLD_DEEPBIND)
    try:
        if os.path.dirname(path):  # the one beside it, not one where it was built
            opened(os.path.join(os.path.dirname(path), CORE), mode)
        library = opened(path, mode)
    except OSError as error:
        raise CausticsError(f"The renderer cannot be loaded into Blender ({error}); switch In Process off in the add-on's preferences.") from None
    captured = [name for name in CAPTURED if address(None, name) not in (None, address(path, name))] if allocator else []
    if captured:
        raise CausticsError(f"This Blender has an allocator of its own and captures {captured[0]}, so that the renderer cannot be loaded into it; "
                            "switch In Process off in the add-on's preferences.")
    for name, (result, arguments) in CALLS.items():
        call = getattr(library, name)
        call.restype, call.argtypes = result, arguments
    have = library.cau_version().decode()
    if tuple(int(n) for n in have.split(".")[:2]) != programs.VERSION or library.cau_render_defaults().size != ctypes.sizeof(RenderOptions):
        raise CausticsError(f"{path} is version {have}, this add-on needs {programs.VERSION[0]}.{programs.VERSION[1]}; reinstall the add-on.")
    return library


def address(library, name):
    """Where a function is that a library (None: the whole process) would give; None where there is none."""
    try:
        return ctypes.cast(getattr(ctypes.CDLL(library, mode=MODE), name), ctypes.c_void_p).value
    except (AttributeError, OSError):
        return None


def own_allocator():
    """Whether the process has another allocator than the C library's: it replaces all four. Of a program at fixed addresses
    (Debian's python3) those alone differ that it passes on as pointers, and are the C library's all the same."""
    return all(address(None, name) != address("libc.so.6", name) for name in ("malloc", "calloc", "realloc", "free"))


def opened(path, mode):
    """A library, after those of its folder that it needs: the zip's have no path of their own. What Blender has loaded already
    is not missed, and taken as it is: a second C++ library beside the first would not do."""
    before = None
    while True:
        try:
            return ctypes.CDLL(path, mode=mode)
        except OSError as error:  # "NAME: cannot open shared object file: ..."
            needed = os.path.join(os.path.dirname(path), str(error).partition(":")[0])
            if needed in (path, before) or not os.path.isfile(needed):
                raise
            before = needed
        opened(needed, mode)


# ---- a render --------------------------------------------------------------------------------------------------------

class Render:
    """One render, on a thread of its own. Its scene, layers and report are files as those of the program."""

    def __init__(self, options, extract, albedo, path, report):
        self.library, self.failed, self.cancelled = load(), None, False
        self.lines, self.plan, self.render = [], "", None
        self.scene_path, self.path, self.report = extract.path, path, report
        self.options = self.fill(options, extract, albedo)
        self.lock = threading.Lock()  # of self.render: it is polled from one thread and destroyed on another
        self.thread = threading.Thread(target=self.run, name="caustics")
        self.thread.start()

    def fill(self, options, extract, albedo):
        made = self.library.cau_render_defaults()
        made.photons, made.time_s, made.error, made.seed = options.photons, options.time_s, options.error, options.seed
        made.threads, made.memory_bytes = options.threads, options.memory_bytes
        made.estimator, made.indirect = ESTIMATOR[options.estimator], INDIRECT[options.indirect]
        made.layers = sum(WANT[name] for name in options.layers(albedo))
        if extract.region:
            made.region[:] = extract.region
        return made

    def run(self):
        lib = self.library
        context, scene, render = POINTER(), POINTER(), POINTER()
        try:
            result = lib.cau_context_create(ctypes.byref(context))
            result = result or lib.cau_scene_load_file(context, os.fsencode(self.scene_path), ctypes.byref(scene))
            result = result or lib.cau_render_create(scene, ctypes.byref(self.options), ctypes.byref(render))
            result = result or self.wait(render)
            result = result or self.write(render, scene)
            if result:
                self.failed = "" if result == CANCELLED else lib.cau_error_text(context).decode("utf-8", "replace") if context else "out of memory"
        finally:
            with self.lock:
                self.render = None
            lib.cau_render_destroy(ctypes.byref(render))
            lib.cau_scene_destroy(ctypes.byref(scene))
            lib.cau_context_destroy(ctypes.byref(context))

    def wait(self, render):
        lib = self.library
        result = lib.cau_render_start(render)
        with self.lock:
            self.render = render
            if self.cancelled:
                lib.cau_render_cancel(render)
        return result or lib.cau_render_wait(render, 3600.0, None, None)

    def write(self, render, scene):
        lib, at = self.library, 0
        while (line := lib.cau_render_warning(render, at)) is not None:
            self.lines.append("warning: " + line.decode("utf-8", "replace"))
            at += 1
        self.plan = lib.cau_render_explain(render).decode("utf-8", "replace")
        options = WriteOptions(size=ctypes.sizeof(WriteOptions), complete=1, seed=self.options.seed,
                               photons=lib.cau_render_poll(render).photons_per_light)
        result = lib.cau_render_write(render, scene, os.fsencode(self.path), ctypes.byref(options))
        return result or lib.cau_render_write_report(render, scene, os.fsencode(self.report))

    # ---- as programs.Child ---------------------------------------------------------------------------------------

    def running(self):
        return self.thread.is_alive()

    def progress(self):
        with self.lock:
            if not self.render:
                return {}
            now = self.library.cau_render_poll(self.render)
        return {"stage": now.stage.decode(), "photons_per_light": now.photons_per_light, "elapsed_s": now.elapsed_s,
                "error": now.error if now.error >= 0 else None, "remaining_s": now.remaining_s if now.remaining_s >= 0 else None}

    def said(self):
        return list(self.lines)

    def output(self):
        return self.plan

    def check(self):
        if self.failed is not None:
            raise CausticsError(self.failed[:1].upper() + self.failed[1:] if self.failed else "The renderer was stopped.")

    def stop(self):
        with self.lock:
            self.cancelled = True
            if self.render:
                self.library.cau_render_cancel(self.render)
        self.thread.join()


def start(options, extract, albedo, path, report, place, polite=False):
    """A render of an extracted scene into `path`, inside or as a child, as the options say."""
    if options.in_process:
        return Render(options, extract, albedo, path, report)
    words = [extract.path, "-o", path, "--report", report, *options.words(extract, albedo)]
    return programs.Child("caustic-render", words, place, polite=polite)
