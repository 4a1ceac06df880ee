"""The render engine: final frames, and the viewport."""
import contextlib
import threading
import time
import weakref

import bpy
import numpy

from . import camera, denoiser, images, library, motion, names, passes, settings, sync
from .viewport import Viewport

SECONDS_BETWEEN_PICTURES = 1.0
SECONDS_BETWEEN_LOOKS = 0.1  # for Escape
SECONDS_BETWEEN_LINES = 0.5  # each makes Blender draw its window


def clock(seconds):
    """1:05, or 2:10:00"""
    hours, rest = divmod(int(max(seconds, 0.0) + 0.5), 3600)
    return f"{hours}:{rest // 60:02}:{rest % 60:02}" if hours else f"{rest // 60}:{rest % 60:02}"


def cut(border, size):
    """The pixel at which a border of 0 to 1 cuts, by Blender's own single precision."""
    return int(numpy.float32(border) * numpy.float32(size))


def status(renderer):
    """The status line of a picture, with samples, noise and time left; and the fraction that is done."""
    renderer.command("measureNoise")  # for the next line
    now, stats = renderer.progress(), renderer.stats()
    parts = [f"Sample {now['samples_done']}/{now['samples_total']}"] if now["samples_total"] else ["Preparing"]
    if "error.relativeRmse" in stats:
        parts.append(f"Noise {100 * stats['error.relativeRmse']:.1f} %")
    if 0.01 < now["fraction"] < 1:
        parts.append(f"Remaining {clock(now['seconds'] * (1 / now['fraction'] - 1))}")
    if stats.get("scene.faultCount"):
        parts.append(f"{stats['scene.faultCount']} faults, see the console")
    return " | ".join(parts), now["fraction"]


class Frames:
    """The frames that threads of Blender render. They end before the engine is unregistered, which frees it below them."""

    PATIENCE = 60.0  # seconds
    AFTERWARDS = 0.3  # seconds in which Blender takes a frame that is over away

    def __init__(self):
        self.condition, self.threads, self.closed = threading.Condition(), [], True  # threads: one for each frame

    def open(self):
        self.closed = False

    def close(self):
        """Raises in a thread that renders a frame, as a handler of frame changes does: it would wait for itself."""
        with self.condition:
            if threading.get_ident() in self.threads:
                raise RuntimeError("Alabaster cannot be disabled by what runs within its own frame; do so when the render is over")
            self.closed = True
            if self.threads and self.condition.wait_for(lambda: not self.threads, self.PATIENCE):
                time.sleep(self.AFTERWARDS)

    @contextlib.contextmanager
    def one(self):
        thread = threading.get_ident()
        with self.condition:
            self.threads.append(thread)
        try:
            yield
        finally:
            with self.condition:
                self.threads.remove(thread)
                self.condition.notify_all()


frames = Frames()


class Notes:
    """Tells the info panel of each thing once.

    An hdalabaster.Scene holds its Notes, a viewport's engine holds the scene, and Python's collector does not see through the
    scene. So the engine is held weakly.
    """

    def __init__(self, engine):
        self.engine, self.told = weakref.ref(engine), set()

    def note(self, text):
        self.tell("WARNING", text)

    def tell(self, severity, text):
        if text not in self.told:
            self.told.add(text)
            print(f"Alabaster: {text}")
            engine = self.engine()
            if engine is not None:
                engine.report({severity}, f"Alabaster: {text}")

    def hear(self, severity, _code, where, text):
        """As hdalabaster.Renderer reports. Blender drops a frame for which an ERROR is reported, but the renderer draws the frame
        without the faulty part. A render that fails raises an exception, too."""
        if denoiser.is_missing(text):
            return  # draw_frame says what it does about it
        self.tell("INFO" if severity == "info" else "WARNING", f"{where}: {text}" if where else text)


class AlabasterRenderEngine(bpy.types.RenderEngine):
    bl_idname = "ALABASTER"
    bl_label = "Alabaster"
    bl_use_preview = True
    bl_use_shading_nodes_custom = False
    bl_use_eevee_viewport = True
    bl_use_postprocess = True
    bl_use_spherical_stereo = False

    # Final frames ---------------------------------------------------------------------------------
    def update_render_passes(self, scene=None, renderlayer=None):
        self.register_pass(scene, renderlayer, "Combined", 4, "RGBA", "COLOR")
        for _, name, channels, kind in passes.wanted(renderlayer):
            self.register_pass(scene, renderlayer, name, len(channels), channels, kind)

    def render(self, depsgraph):
        try:
            with frames.one():
                if not frames.closed:
                    self.render_frame(depsgraph, library.load())
        except Exception as error:  # Blender shows a traceback in the console alone
            self.error_set(f"Alabaster: {error}")
            self.report({"ERROR"}, f"Alabaster: {error}")
            if not isinstance(error, ImportError) and type(error).__module__ != "hdalabaster._hdalabaster":
                raise

    def render_frame(self, depsgraph, hdalabaster):
        scene, layer = depsgraph.scene, depsgraph.view_layer
        if scene.camera is None:
            raise ValueError("the scene has no camera")
        notes = Notes(self)
        self.update_stats("", "Alabaster: reading the scene")
        held = hdalabaster.Scene(report=notes.hear)
        exporter = sync.SceneSync(held, False, notes.note)
        shutter = motion.Shutter(depsgraph.scene_eval, depsgraph.view_layer_eval.use_pass_vector)
        if shutter.times():
            motion.sample(self, depsgraph, shutter, exporter)
        exporter.sync(depsgraph)
        frame = self.frame_of(depsgraph, shutter, exporter)
        values = settings.delegate_settings(depsgraph.scene_eval, self.is_preview)
        renderer = hdalabaster.Renderer(held, report=notes.hear, **values)
        self.draw_frame(renderer, frame, layer, notes, exporter.material_names)

    def draw_frame(self, renderer, frame, layer, notes, materials):
        """As rendered where there is no denoiser."""
        wanted = passes.wanted(layer)
        while True:
            try:
                render = renderer.start(aovs=["color", *(aov for aov, *_ in wanted)], **frame)
                return self.refine(renderer, render, layer, wanted, frame["window"], materials)
            except RuntimeError as error:
                if not denoiser.is_missing(error):
                    raise
                notes.note(f"{error} This frame is as rendered. The preferences of the add-on name the denoiser's folder, too")
                renderer.set(denoise=False)
                wanted = [one for one in wanted if one[0] != "denoised"]

    def frame_of(self, depsgraph, shutter, exporter):
        """Arguments of Renderer.start: size, window and camera."""
        scene, view = depsgraph.scene, depsgraph.scene.render
        width = max(1, view.resolution_x * view.resolution_percentage // 100)
        height = max(1, view.resolution_y * view.resolution_percentage // 100)
        window = (0, 0, width, height)
        if view.use_border:
            left, right = (cut(end, width) for end in (view.border_min_x, view.border_max_x))
            bottom, top = (cut(end, height) for end in (view.border_min_y, view.border_max_y))
            window = (left, height - top, right, height - bottom)
        aspect = view.pixel_aspect_x / view.pixel_aspect_y
        eye = scene.camera.evaluated_get(depsgraph)
        parameters = camera.final(eye, depsgraph, width, height, aspect)
        if eye.data.type == "PANO":
            exporter.note(f"camera '{eye.name}': panoramic cameras are not translated; it renders as perspective")
        moved = exporter.motion.get((scene.camera.name_full, ()))
        if shutter.moves:
            parameters.update(shutterOpen=shutter.open, shutterClose=shutter.close)
        return {"width": width, "height": height, "window": window, "pixel_aspect": aspect,
                "camera": {"transform": names.matrix(camera.placement(eye)), "motion": moved, **parameters, **exporter.lens}}

    def refine(self, renderer, render, layer, wanted, window, materials):
        """Shows pictures until the render is over or Escape is pressed. The picture so far stays."""
        size = window[2] - window[0], window[3] - window[1]
        shown = told = time.monotonic()
        over = False
        while not over and not frames.closed and not self.test_break():
            over = render.wait(SECONDS_BETWEEN_LOOKS)
            if not over and time.monotonic() - told < SECONDS_BETWEEN_LINES:
                continue
            told = time.monotonic()
            self.check(render, renderer)
            text, fraction = status(renderer)
            self.update_stats("", text)
            self.update_progress(fraction)
            if not over and told - shown > SECONDS_BETWEEN_PICTURES and fraction > 0:
                self.show(render, layer, size, [], None)
                shown = time.monotonic()
        render.cancel()
        self.check(render, renderer)
        self.show(render, layer, size, wanted, passes.Names(renderer, materials))

    def check(self, render, renderer):
        """Raises where there is no picture, or one without what memory did not hold."""
        stats = renderer.stats()
        if stats.get("scene.outOfMemory"):
            raise RuntimeError(stats["scene.faults"].splitlines()[0])
        if render.state == "failed" or "error" in stats:
            raise RuntimeError(stats.get("error", "the render failed"))

    def show(self, render, layer, size, wanted, names):
        """names: None, or for the last picture the passes.Names of its passes."""
        result = self.begin_result(0, 0, *size, layer=layer.name)
        held = result.layers[0].passes
        passes.fill(held["Combined"], render["color"].numpy()[::-1], "color")
        for aov, name, *_ in wanted:
            if name in held:
                passes.fill(held[name], numpy.asarray(render[aov])[::-1], aov, names)
        if names:
            names.stamp(self.get_result(), layer)
        else:
            self.update_result(result)
        self.end_result(result)

    # The viewport ---------------------------------------------------------------------------------
    def view_update(self, context, depsgraph):
        self.viewport().update(context, depsgraph)

    def view_draw(self, context, depsgraph):
        self.viewport().draw(context, depsgraph)

    def viewport(self):
        # Blender makes engines by other ways than __init__, which differ between its versions.
        held = getattr(self, "_viewport", None)
        if held is None:
            held = self._viewport = Viewport(self, Notes(self), status)
        return held


# Panels of Blender's own that this engine leaves out: they are those of other engines' settings.
LEFT_OUT = {"VIEWLAYER_PT_filter", "VIEWLAYER_PT_layer_passes"}


def panels():
    for panel in bpy.types.Panel.__subclasses__():
        engines = getattr(panel, "COMPAT_ENGINES", None)
        if engines is not None and "BLENDER_RENDER" in engines and panel.__name__ not in LEFT_OUT:
            yield engines
        elif engines is not None and panel.__name__ in CYCLES_PANELS:
            yield engines


CYCLES_PANELS = {"EEVEE_MATERIAL_PT_surface", "DATA_PT_EEVEE_light", "EEVEE_WORLD_PT_surface", "MATERIAL_PT_preview",
                 "DATA_PT_EEVEE_light_distance", "EEVEE_MATERIAL_PT_context_material", "DATA_PT_camera_dof", "DATA_PT_camera_dof_aperture"}


def register():
    bpy.utils.register_class(AlabasterRenderEngine)
    frames.open()
    for engines in panels():
        engines.add(AlabasterRenderEngine.bl_idname)


def unregister():
    for engines in panels():
        engines.discard(AlabasterRenderEngine.bl_idname)
    bpy.utils.unregister_class(AlabasterRenderEngine)
    images.clear()
