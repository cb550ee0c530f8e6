# SPDX-License-Identifier: Apache-2.0
"""Caustics in Blender: one button, in any Cycles scene. docs/blender.md is its manual."""

bl_info = {
    "name": "Caustics",
    "author": "The Caustics project",
    "version": (0, 1, 0),
    "blender": (3, 4, 0),
    "location": "Properties > Render > Caustics, and 3D View > Sidebar > Caustics",
    "description": "The light that Cycles leaves out, one layer per light",
    "category": "Render",
}

from . import command, engine, handlers, operators, panels, settings  # noqa: E402
from .command import export, generate  # noqa: E402,F401  what scripts call
from .errors import CausticsError  # noqa: E402,F401

MODULES = (settings, engine, operators, panels, handlers, command)


def register():
    for module in MODULES:
        module.register()


def unregister():
    for module in reversed(MODULES):
        module.unregister()
