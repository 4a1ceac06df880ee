"""The picture of a viewport: a render that follows its camera and the scene's edits."""
import time
import weakref

import bpy
import gpu
import numpy
from gpu_extras.presets import draw_texture_2d

from . import camera, library, settings, sync

# Blender draws a whole region for each picture of ours: often while an edit is new, seldom afterwards.
SECONDS_BETWEEN_PICTURES = 0.04
SECONDS_OF_CARE = 1.0
SECONDS_BETWEEN_LATER_PICTURES = 0.25


class Viewport:
    def __init__(self, engine, notes, status):
        self.engine = weakref.ref(engine)
        self.notes, self.status = notes, status
        self.scene = self.exporter = self.renderer = self.render = None
        self.pixels = self.texture = self.shown = None
        self.frame = None
        self.changed = time.monotonic()
        self.ticking = False
        self.failed = False

    # Edits ----------------------------------------------------------------------------------------
    def update(self, context, depsgraph):
        """All of the scene at first, then what was edited."""
        if self.failed:
            return
        try:
            if self.renderer is None:
                self.begin(depsgraph, context.space_data)
            else:
                self.exporter.update(depsgraph, context.space_data)
                self.renderer.set(**settings.delegate_settings(depsgraph.scene_eval, True))
            if self.render is not None:
                self.render.update()
            self.changed = time.monotonic()
        except ImportError as error:
            self.failed = True
            self.notes.tell("ERROR", str(error))
            self.engine().update_stats("Alabaster", str(error))
        self.engine().tag_redraw()

    def begin(self, depsgraph, space):
        hdalabaster = library.load()
        self.scene = hdalabaster.Scene(report=self.notes.hear)
        self.exporter = sync.SceneSync(self.scene, True, self.notes.note)
        self.exporter.sync(depsgraph, space)
        self.renderer = hdalabaster.Renderer(self.scene, report=self.notes.hear,
                                           **settings.delegate_settings(depsgraph.scene_eval, True))

    # Pictures -------------------------------------------------------------------------------------
    def draw(self, context, depsgraph):
        if self.renderer is None:
            return
        region = context.region
        frame = {"width": region.width, "height": region.height, "camera": camera.viewport(context, depsgraph)}
        if self.render is None:
            self.render = self.renderer.start(aovs=["color"], **frame)
        elif frame != self.frame:
            self.render.update(**frame)
            self.changed = time.monotonic()
        self.frame = frame
        over = self.render.wait(0)
        self.take()
        self.paint(context, depsgraph.scene)
        self.tell(over)
        if not over:
            self.tick()

    def take(self):
        """Brings the texture up to date. Where the renderer has no picture of this size yet, the old one stays."""
        width, height = self.frame["width"], self.frame["height"]
        generation = self.render["color"].generation  # before show, which may copy a later picture: that is then copied again
        if self.texture is not None and (generation, width, height) == self.shown:
            return
        pixels = self.pixels
        if pixels is None or pixels.shape[:2] != (height, width):
            pixels = numpy.zeros((height, width, 4), numpy.float32)
        if not self.render.show("color", pixels, top_down=False):
            return
        self.pixels = pixels
        self.shown = generation, width, height
        data = gpu.types.Buffer("FLOAT", width * height * 4, pixels.reshape(-1))
        self.texture = gpu.types.GPUTexture((width, height), format="RGBA16F", data=data)

    def paint(self, context, scene):
        if self.texture is None:
            return
        engine = self.engine()
        gpu.state.blend_set("ALPHA_PREMULT")
        engine.bind_display_space_shader(scene)
        draw_texture_2d(self.texture, (0, 0), context.region.width, context.region.height)
        engine.unbind_display_space_shader()
        gpu.state.blend_set("NONE")

    def tell(self, over):
        text, _ = self.status(self.renderer)
        stats = self.renderer.stats()
        if "error" in stats:
            self.notes.tell("ERROR", str(stats["error"]))
            text = f"Error: {stats['error']}"
        self.engine().update_stats("Alabaster", text + (" | Done" if over else ""))

    def tick(self):
        """Draws again soon: pixels come from threads that may not ask for it."""
        if self.ticking:
            return
        self.ticking = True
        held = weakref.ref(self)

        def again():
            viewport = held()
            engine = viewport.engine() if viewport else None
            if engine is not None:
                viewport.ticking = False
                try:
                    engine.tag_redraw()
                except ReferenceError:  # Blender has freed it
                    pass

        new = time.monotonic() - self.changed < SECONDS_OF_CARE
        bpy.app.timers.register(again, first_interval=SECONDS_BETWEEN_PICTURES if new else SECONDS_BETWEEN_LATER_PICTURES)
