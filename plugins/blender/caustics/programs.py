# SPDX-License-Identifier: Apache-2.0
"""The programs: where they are, and one of them running.

They run as children, not in Blender's own process: Blender has its own Embree and OpenEXR, which would take our calls."""
import json
import os
import shutil
import stat
import subprocess
import tempfile

from .errors import CausticsError

HERE = os.path.dirname(os.path.abspath(__file__))
VERSION = (0, 1)  # of the programs that this add-on speaks to
SCRATCH = "caustics-blender-"
POLITE = 5  # steps of priority
STOP_S = 5.0  # a renderer that is asked to stop answers well within


def folder():
    """The folder of the programs in the preferences; "" for those of the zip or the system."""
    import bpy
    addon = bpy.context.preferences.addons.get(__package__)
    return bpy.path.abspath(addon.preferences.programs) if addon and addon.preferences else ""


def find(name):
    """The path of a program, ready to run."""
    given = folder()
    places = [given] if given else [os.path.join(HERE, "bin"), *os.environ.get("PATH", "").split(os.pathsep)]
    for place in places:
        path = os.path.join(place, name)
        if os.path.isfile(path):
            return executable(path)
    raise CausticsError(f"The program {name} is not in {places[0]}; set the folder of the programs in the add-on's preferences.")


def executable(path):
    """Python's zip reader, which installs add-ons, forgets that a file may be run."""
    if not os.access(path, os.X_OK):
        try:
            os.chmod(path, os.stat(path).st_mode | stat.S_IXUSR)
        except OSError as error:
            raise CausticsError(f"{path} may not be run ({error.strerror}); make it executable.") from None
    return path


def environment():
    """The libraries of the zip are found by this variable alone: those that they need in turn have no path of their own."""
    made = dict(os.environ)
    libraries = os.path.join(HERE, "lib")
    if not folder() and os.path.isdir(libraries):
        made["LD_LIBRARY_PATH"] = os.pathsep.join(p for p in (libraries, made.get("LD_LIBRARY_PATH")) if p)
    return made


def check(name):
    """Raises a sentence unless the program runs and is of the version that the add-on speaks to."""
    path = find(name)
    try:
        run = subprocess.run([path, "--version"], env=environment(), capture_output=True, text=True, timeout=60)
    except (OSError, subprocess.TimeoutExpired) as error:
        raise CausticsError(f"{path} does not run: {getattr(error, 'strerror', None) or error}; reinstall the add-on for this platform.") from None
    words = run.stdout.split()
    if run.returncode or len(words) < 2:
        said = (run.stderr.strip().splitlines() or ["no answer"])[-1]
        raise CausticsError(f"{path} does not run: {said}; reinstall the add-on for this platform.")
    have = tuple(int(n) for n in words[1].split(".")[:2] if n.isdigit())
    if have != VERSION:
        raise CausticsError(f"{path} is version {words[1]}, this add-on needs {VERSION[0]}.{VERSION[1]}; install programs of that version.")
    return path


class Child:
    """A program that runs. Output goes to files, so that no thread has to read it."""

    def __init__(self, name, words, place, polite=False):
        """polite: Blender's own window comes first."""
        self.name, self.out = name, os.path.join(place, name + ".out")
        self.err = os.path.join(place, name + ".err")
        with open(self.out, "wb") as out, open(self.err, "wb") as err:
            self.process = subprocess.Popen([find(name), *words], stdin=subprocess.DEVNULL, stdout=out, stderr=err, env=environment())
        if polite:
            try:
                os.setpriority(os.PRIO_PROCESS, self.process.pid, os.getpriority(os.PRIO_PROCESS, 0) + POLITE)
            except OSError:  # it has ended, or is the nicest already
                pass

    def running(self):
        return self.process.poll() is None

    def progress(self):
        """The last line of --progress as a dictionary; {} before the first."""
        for line in reversed(self.text(self.err, last=2000).splitlines()):
            if line.startswith("{") and line.endswith("}"):
                try:
                    return json.loads(line)
                except ValueError:
                    continue
        return {}

    @staticmethod
    def text(path, last=None):
        with open(path, "rb") as f:
            if last:
                f.seek(0, os.SEEK_END)
                f.seek(max(f.tell() - last, 0))
            return f.read().decode("utf-8", "replace")

    def said(self):
        """What it printed to be read, without the progress: a list of lines."""
        return [line for line in self.text(self.err).splitlines() if line and not line.startswith("{")]

    def output(self):
        return self.text(self.out)

    def check(self):
        """Raises what it said when it failed."""
        code = self.process.returncode
        if code == 0:
            return
        lines = [line for line in self.said() if line.startswith(self.name)] or self.said()
        said = lines[-1].removeprefix(self.name + ": ") if lines else f"it ended with {code}"
        raise CausticsError(said[:1].upper() + said[1:] + ("" if said.endswith(".") else "."))

    def stop(self):
        if self.running():
            self.process.terminate()
            try:
                self.process.wait(STOP_S)
            except subprocess.TimeoutExpired:
                self.process.kill()
                self.process.wait()


def memory_bytes():
    """What this machine can give now."""
    try:
        with open("/proc/meminfo", encoding="ascii") as f:
            return next(int(line.split()[1]) * 1024 for line in f if line.startswith("MemAvailable"))
    except (OSError, StopIteration, ValueError):
        return 1 << 40


def scratch(need_bytes=1 << 28):
    """A new folder in shared memory; on disk where there is none or too little of it."""
    base = "/dev/shm"
    try:
        free = os.statvfs(base)
        if free.f_bavail * free.f_frsize < need_bytes or not os.access(base, os.W_OK):
            base = None
    except OSError:
        base = None
    sweep(base or tempfile.gettempdir())
    return tempfile.mkdtemp(prefix=f"{SCRATCH}{os.getpid()}-", dir=base)


def sweep(base):
    """Removes folders of a Blender that was killed: nobody else would, and shared memory is memory."""
    for name in os.listdir(base):
        owner = name.removeprefix(SCRATCH).partition("-")[0] if name.startswith(SCRATCH) else ""
        path = os.path.join(base, name)
        if owner.isdigit() and not os.path.exists(f"/proc/{owner}") and os.path.exists("/proc/self"):
            try:
                if os.lstat(path).st_uid == os.getuid():
                    remove(path)
            except OSError:  # another Blender was faster
                pass


def remove(path):
    shutil.rmtree(path, ignore_errors=True)
