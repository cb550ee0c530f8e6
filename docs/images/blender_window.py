# SPDX-License-Identifier: Apache-2.0
"""Runs in Blender after the script of caustic-merge blender: a screenshot of the compositor as the last word says."""
import sys

import bpy

bpy.context.preferences.view.show_splash = False


def compositor():
    window = bpy.context.window_manager.windows[0]
    area = max(window.screen.areas, key=lambda a: a.width * a.height)
    return {"window": window, "area": area, "region": [r for r in area.regions if r.type == "WINDOW"][0]}


def show():
    area = compositor()["area"]
    area.ui_type = "CompositorNodeTree"
    area.spaces.active.show_region_ui = False
    tree = bpy.context.scene.node_tree
    for node in [n for n in tree.nodes if n.bl_idname == "CompositorNodeRLayers"]:
        tree.nodes.remove(node)
    bpy.app.timers.register(frame, first_interval=1)


def frame():
    with bpy.context.temp_override(**compositor()):
        bpy.ops.node.view_all()
    bpy.app.timers.register(save, first_interval=2)


def save():
    with bpy.context.temp_override(**compositor()):
        bpy.ops.screen.screenshot_area(filepath=sys.argv[-1])
    bpy.ops.wm.quit_blender()


bpy.app.timers.register(show, first_interval=1)
