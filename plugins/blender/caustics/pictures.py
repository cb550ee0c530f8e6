# SPDX-License-Identifier: Apache-2.0
"""EXR files on their way: Blender's own made fit for the sum, results put where the user wants them."""
import os
import shutil
import struct
import tempfile

import bpy

from .errors import CausticsError

ALBEDO = "Diffuse Color" if bpy.app.version >= (5, 0, 0) else "DiffCol"  # pass of the receivers' color
ASPECT = b"pixelAspectRatio\0float\0\4\0\0\0"  # name, type and size of that attribute


def set_aspect(path, aspect):
    """Blender up to 4.x writes 1 for the shape of a pixel, whatever the scene says (measured): mend the header."""
    with open(path, "r+b") as f:
        data, at = f.read(), -1
        while (at := data.find(ASPECT, at + 1)) >= 0:
            f.seek(at + len(ASPECT))
            f.write(struct.pack("<f", aspect))


def keep(path, to):
    """Moves a finished file to where the user wants it, whole or not at all."""
    folder = os.path.dirname(to)
    try:
        os.makedirs(folder, exist_ok=True)
        handle, beside = tempfile.mkstemp(prefix=".caustics-", dir=folder)
        os.close(handle)
        try:
            shutil.copyfile(path, beside)
            os.chmod(beside, 0o666 & ~current_umask())
            os.replace(beside, to)
        except OSError:
            os.unlink(beside)
            raise
    except OSError as error:
        raise CausticsError(f"{to} cannot be written ({error.strerror}); choose another output in the panel.") from None
    return to


def current_umask():
    mask = os.umask(0o22)
    os.umask(mask)
    return mask
