"""Runs in a Blender with a window, for viewport_test.py: draws the viewport in two views and after
a change of the scene, and saves screenshots.

    xvfb-run blender --factory-startup -P tests/blender/window.py -- FOLDER"""

import os
import pathlib
import sys
import time
import traceback

import bpy

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parent))

import scenes

SHOTS = ("camera", "orthographic", "brighter")
_deadline = time.monotonic() + 60
_folder = pathlib.Path(sys.argv[sys.argv.index("--") + 1])


def make_scene():
    """Empty but for a grey world, in which the middle of the view is a black box."""
    bpy.ops.preferences.addon_enable(module="pvol_blender")
    scene = bpy.context.scene
    for thing in list(bpy.data.objects):
        bpy.data.objects.remove(thing)
    scene.world.use_nodes = True
    scenes.background((0.2, 0.2, 0.2))
    scenes.box(scenes.smoke(100, (0, 0, 0), attribute=""), scale=(0.5, 0.5, 0.5))
    scenes.camera((0, -5, 0))
    scene.view_settings.view_transform = "Standard"
    scene.render.engine = "PVOL"
    scene.render.threads_mode, scene.render.threads = "FIXED", 2
    scene.pvol.viewport_samples = 16
    bpy.context.preferences.view.show_splash = False


def area():
    window = bpy.context.window_manager.windows[0]
    return window, next(a for a in window.screen.areas if a.type == "VIEW_3D")


def begin(name):
    _, view = area()
    space = view.spaces[0]
    space.overlay.show_overlays = space.show_gizmo = False
    space.shading.type = "RENDERED"
    space.region_3d.view_perspective = "CAMERA" if name == "camera" else "ORTHO"
    if name == "camera":
        bpy.context.scene.camera.data.show_passepartout = False
    if name == "brighter":
        scenes.background((0.5, 0.5, 0.5))


def save(name):
    window, view = area()
    with bpy.context.temp_override(window=window, area=view):
        bpy.ops.screen.screenshot_area(filepath=str(_folder / (name + ".png")))


def steps():
    for name in SHOTS:
        begin(name)
        yield 3.0
        save(name)
        yield 0.1
    bpy.ops.wm.quit_blender()


_steps = steps()


def step():
    try:
        if time.monotonic() > _deadline:
            raise TimeoutError("no screenshots within a minute")
        return next(_steps)
    except StopIteration:
        return None
    except Exception:
        traceback.print_exc()
        os._exit(1)


make_scene()
bpy.app.timers.register(step, first_interval=1.0)
