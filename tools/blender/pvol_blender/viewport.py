"""A viewport whose picture refines while the artist works."""

import bpy

from . import final, preferences, pvol_module, render_options, screen, unmapped
from .translate import Translation, camera
from .translate.files import Files

_INTERVAL = 0.05  # seconds between looks at the picture


class View:
    """The picture of one viewport: begun anew when the scene, the view or the region changes."""

    def __init__(self, engine):
        self._engine = engine
        self._files = Files()
        self._live = None
        self._sections = None
        self._asked = None  # camera and options of the picture that is being made
        self._version = -1  # of the picture on the screen
        self._image = None
        self._message = ""

    def close(self):
        if bpy.app.timers.is_registered(self._look):
            bpy.app.timers.unregister(self._look)
        if self._live is not None:
            self._live.close()
            self._live = None
        self._files.close()

    def update(self, context, depsgraph):
        """The scene has changed."""
        try:
            module = preferences.load()
            for change in depsgraph.updates:
                if change.is_updated_geometry:
                    self._files.forget(change.id.name_full)
            translation = Translation(depsgraph, self._files, module)
            self._sections = final.with_volume(translation.sections(), module)
            unmapped.remember(depsgraph.scene.name, translation.notes)
            self._asked = None
            self._begin(context, depsgraph, module)
        except (pvol_module.Missing, ArithmeticError, LookupError, ValueError, OSError) as error:
            self._tell(str(error) or type(error).__name__)

    def draw(self, context, depsgraph):
        if self._sections is not None:
            try:
                self._begin(context, depsgraph, preferences.load())
            except ValueError as error:
                self._tell(str(error))
        self._take()
        if self._image is not None:
            self._image.draw(context.region.width, context.region.height)

    def _begin(self, context, depsgraph, module):
        """Begins anew if anything differs from what is being made."""
        scene, region = depsgraph.scene, context.region
        coarser = max(1, int(self._engine.get_preview_pixel_size(scene)))
        size = (max(1, region.width // coarser), max(1, region.height // coarser))
        view = context.region_data
        seen = camera.of_view(view.view_matrix, view.window_matrix)
        asked = (seen, render_options.viewport(scene, size))
        if asked == self._asked:
            return
        self._asked = asked
        sections = {**self._sections, "camera": seen}
        if self._live is None:
            self._live = module.Live(sections, force=True, **asked[1])
        else:
            self._live.change(sections, force=True, **asked[1])
        if not bpy.app.timers.is_registered(self._look):
            bpy.app.timers.register(self._look, first_interval=_INTERVAL)

    def _take(self):
        """The newest picture, if there is a newer one."""
        if self._live is None or self._live.version == self._version:
            return
        self._version = self._live.version
        picture = self._live.picture()
        if picture is not None:
            self._image = screen.Image(final.rgba(picture, self._asked[1]))
            self._tell(self._live.error or f"{picture.samples.mean():.0f} samples")

    def _tell(self, message):
        if message != self._message:
            self._message = message
            self._engine.update_stats("pvol", message)

    def _look(self):
        """A timer: asks for a redraw when there is something new."""
        try:
            if self._live.error:
                self._tell(self._live.error)
            if self._live.version != self._version:
                self._engine.tag_redraw()
            elif self._live.finished or self._live.error:
                return None
            return _INTERVAL
        except ReferenceError:  # Blender has freed the engine
            self.close()
            return None
