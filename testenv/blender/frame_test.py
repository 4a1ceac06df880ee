"""Tests of final frames, and of the viewport beside them. addon_test.py runs them."""
import gc
import os
import pathlib
import tempfile
import threading
import time
import types
import unittest
import unittest.mock
import weakref

import bpy
import mathutils
import numpy
from bpy_extras.object_utils import world_to_camera_view

import hdalabaster
import scenes
from alabaster_render import engine, images, materials, passes, settings, world
from synced_scene import fresh


class Frames(unittest.TestCase):
    def setUp(self):
        fresh()
        scenes.principled_diffuse()
        scene = bpy.context.scene
        scene.alabaster.samples = 2
        scene.render.resolution_x, scene.render.resolution_y, scene.render.resolution_percentage = 40, 30, 100

    def test_passes(self):
        layer = bpy.context.view_layer
        layer.use_pass_z = layer.use_pass_normal = layer.use_pass_vector = True
        for aov in set(settings.PASSES) - {"denoised"}:
            setattr(layer.alabaster, aov, True)
        render = bpy.context.scene.render
        if hasattr(render.image_settings, "media_type"):
            render.image_settings.media_type = "MULTI_LAYER_IMAGE"  # Blender 5
        render.image_settings.file_format = "OPEN_EXR_MULTILAYER"
        with tempfile.TemporaryDirectory() as folder:
            render.filepath = folder + "/layers.exr"
            bpy.ops.render.render(write_still=True)
            header = (pathlib.Path(folder) / "layers.exr").read_bytes()[:8000]
        for name in ("Combined.R", "Depth.Z", "Normal.X", "Vector.X", "Diffuse.R", "Albedo.G", "Sample Count.X",
                     "Nonfinite Samples.X", "Subsurface Unscattered.B"):
            self.assertTrue(name.encode() in header, name)

    def test_passes_have_their_values(self):
        held = types.SimpleNamespace(channels=1, rect=types.SimpleNamespace(foreach_set=lambda values: kept.append(values.copy())))
        kept = []
        passes.fill(held, numpy.array([[0.0, 2.0]], numpy.float32), "cameraDepth")
        self.assertEqual(kept[0].reshape(-1).tolist(), [numpy.float32(passes.FAR), 2.0])

    def test_pass_vector_has_the_way_of_a_frame(self):
        """Without motion blur: where the middle of a mesh appears now, less where it appears in the next frame; as Cycles has it."""
        scene, ob = bpy.context.scene, next(ob for ob in bpy.data.objects if ob.type == "MESH")
        scene.render.use_motion_blur, bpy.context.view_layer.use_pass_vector = False, True
        first, seen = ob.location.copy(), []
        for frame, place in enumerate((first, first + mathutils.Vector((0.1, 0.05, 0)))):
            ob.location = place
            ob.keyframe_insert("location", frame=scene.frame_current + frame)
            bpy.context.view_layer.update()
            at = world_to_camera_view(scene, scene.camera, place)
            seen.append(numpy.array([at.x * 40, at.y * 30]))
        kept = {}
        with unittest.mock.patch.object(passes, "fill", side_effect=lambda _, pixels, aov, *__: kept.update(
                {aov: passes.converted(pixels.reshape(-1, pixels.shape[-1]), aov, None)})):
            bpy.ops.render.render()
        motion = kept["motion"]
        moved = numpy.median(motion[numpy.abs(motion).sum(axis=1) > 0.01], axis=0)
        numpy.testing.assert_allclose(moved, [*(seen[0] - seen[1])] * 2, rtol=0.2, atol=0.05)

    def test_border(self):
        render = bpy.context.scene.render
        render.use_border, render.use_crop_to_border = True, True
        render.border_min_x, render.border_max_x, render.border_min_y, render.border_max_y = 0.25, 0.75, 0.5, 1.0
        render.image_settings.file_format = "OPEN_EXR"
        with tempfile.TemporaryDirectory() as folder:
            render.filepath = folder + "/part.exr"
            bpy.ops.render.render(write_still=True)
            image = bpy.data.images.load(folder + "/part.exr")
            self.assertEqual(tuple(image.size), (20, 15))

    def pixels(self, file_name="frame.exr"):
        """F12's picture, rows from the bottom."""
        render = bpy.context.scene.render
        render.image_settings.file_format, render.image_settings.color_mode = "OPEN_EXR", "RGBA"
        with tempfile.TemporaryDirectory() as folder:
            render.filepath = f"{folder}/{file_name}"
            bpy.ops.render.render(write_still=True)
            image = bpy.data.images.load(render.filepath)
            pixels = numpy.empty(image.size[0] * image.size[1] * 4, numpy.float32)
            image.pixels.foreach_get(pixels)
            return pixels.reshape(image.size[1], image.size[0], 4)

    def test_lights_and_a_lens_that_move_are_the_mean_of_stills(self):
        fresh()
        scene, eye = bpy.context.scene, scenes.camera((0, -6, 3), (0, 0, 0.4))
        scenes.floor()
        scenes.ball(scenes.diffuse("ball", (0.8, 0.3, 0.1)))
        eye.data.dof.use_dof, eye.data.dof.focus_distance = True, 6.5
        lamps = (scenes.light("POINT", 300, (0, -1.5, 2.5), shadow_soft_size=0.2), scenes.light("AREA", 200, (0, 0, 3), size=0.8))
        for frame, side in ((0, -1), (2, 1)):
            eye.data.lens, eye.data.dof.aperture_fstop = 50 + 15 * side, 0.12 - 0.06 * side
            lamps[0].location.x, lamps[1].location.x = 1.5 * side, -2 * side
            for held, names in ((eye.data, ("lens", "dof.aperture_fstop")), (lamps[0], ("location",)), (lamps[1], ("location",))):
                for name in names:
                    held.keyframe_insert(name, frame=frame)
        for held in (eye.data, *lamps):
            scenes.linear(held)
        scene.frame_set(1)
        render = scene.render
        render.resolution_x, render.resolution_y, render.resolution_percentage = 32, 24, 100
        scene.alabaster.samples = 1024
        render.use_motion_blur, render.motion_blur_shutter = True, 2.0
        blurred = self.pixels()
        render.use_motion_blur, scene.alabaster.samples = False, 128
        stills = []
        for i in range(8):
            scene.frame_set(0, subframe=(i + 0.5) / 4) if i < 4 else scene.frame_set(1, subframe=(i - 3.5) / 4)
            stills.append(self.pixels())
        blocks = [picture.reshape(6, 4, 8, 4, 4).mean((1, 3))[..., :3] for picture in (blurred, sum(stills) / 8, stills[4])]
        apart = [abs(blocks[0] - other).max() / other.mean() for other in blocks[1:]]
        self.assertLess(apart[0], 0.03)
        self.assertGreater(apart[1], 0.2)

    def test_borders_cut_where_blender_cuts(self):
        """The picture within a border is the full frame's, pixel by pixel."""
        render = bpy.context.scene.render
        random = numpy.random.default_rng(7)
        cases = [(100, 100, 100, (0.29, 0.57, 0.2, 0.7)), (97, 61, 50, (0.1, 0.9, 0.3, 0.6))]
        cases += [(int(w), int(h), int(p), tuple(sorted(x)) + tuple(sorted(y))) for w, h, p, x, y in zip(
            random.integers(40, 120, 6), random.integers(30, 90, 6), random.integers(40, 101, 6),
            random.uniform(0, 1, (6, 2)).round(2), random.uniform(0, 1, (6, 2)).round(2))]
        for width, height, percentage, (left, right, bottom, top) in cases:
            render.resolution_x, render.resolution_y, render.resolution_percentage = width, height, percentage
            render.pixel_aspect_x = 1.5 if width % 2 else 1.0
            render.use_border = False
            full = self.pixels()
            render.use_border = True
            render.border_min_x, render.border_max_x, render.border_min_y, render.border_max_y = left, right + 0.1, bottom, top + 0.1
            part = self.pixels()
            ys, xs = numpy.nonzero(part[..., 3] > 0)
            self.assertGreater(len(ys), 0)
            inside = slice(ys.min(), ys.max() + 1), slice(xs.min(), xs.max() + 1)
            case = width, height, percentage, left, right, bottom, top
            self.assertEqual(float(abs(full[inside] - part[inside]).max()), 0, case)

    def glowing(self, space, file):
        """A plane before the camera that glows with an image in this space."""
        fresh()
        scenes.camera((0, 0, 2), (0, 0, 0))
        image = bpy.data.images.load(file)
        image.colorspace_settings.name = space
        material = bpy.data.materials.new("glow")
        material.use_nodes = True
        tree = material.node_tree
        tree.nodes.clear()
        texture, glow, output = (tree.nodes.new(f"ShaderNode{kind}") for kind in ("TexImage", "Emission", "OutputMaterial"))
        texture.image = image
        tree.links.new(texture.outputs["Color"], glow.inputs["Color"])
        tree.links.new(glow.outputs[0], output.inputs["Surface"])
        scenes.floor(material).data.uv_layers.new(name="map")
        render = bpy.context.scene.render
        render.resolution_x, render.resolution_y, render.resolution_percentage = 8, 8, 100

    def test_colour_spaces_are_blenders(self):
        """In each of Blender's spaces Cycles gives the same colour."""
        names = [item.identifier for item in bpy.types.ColorManagedInputColorspaceSettings.bl_rna.properties["name"].enum_items]
        with tempfile.TemporaryDirectory() as folder:
            fresh()
            made = scenes.picture("coloured", 4, 4, lambda u, v: (0.5, 0.25, 0.125))
            made.filepath_raw, made.file_format = f"{folder}/coloured.png", "PNG"
            made.save()
            for space in names:
                self.glowing(space, f"{folder}/coloured.png")
                bpy.context.scene.alabaster.samples = bpy.context.scene.cycles.samples = 2
                ours = self.pixels()[4, 4, :3]
                bpy.context.scene.render.engine, bpy.context.scene.cycles.use_denoising = "CYCLES", False
                theirs = self.pixels()[4, 4, :3]
                # Ours emits no negative light.
                numpy.testing.assert_allclose(ours, numpy.maximum(theirs, 0), rtol=0.01, atol=2e-3, err_msg=space)

    @unittest.skipUnless(hasattr(bpy.data, "colorspace"), "Blender before 5.0")
    def test_images_in_another_working_space(self):
        with tempfile.TemporaryDirectory() as folder:
            fresh()
            made = scenes.picture("coloured", 4, 4, lambda u, v: (0.5, 0.25, 0.125))
            made.filepath_raw, made.file_format = f"{folder}/coloured.png", "PNG"
            made.save()
            for space in ("sRGB", "Linear Rec.709", "Non-Color"):
                self.glowing(space, f"{folder}/coloured.png")
                bpy.ops.wm.set_working_color_space(working_space="ACEScg", convert_colors=True)
                scene = bpy.context.scene
                scene.alabaster.samples = scene.cycles.samples = 2
                ours = self.pixels()[4, 4, :3]
                scene.render.engine, scene.cycles.use_denoising = "CYCLES", False
                numpy.testing.assert_allclose(ours, self.pixels()[4, 4, :3], rtol=0.01, err_msg=space)

    def test_f12_without_an_image_or_a_denoiser(self):
        scenes.ball(scenes.textured_by_a_missing_image()[0])
        bpy.context.scene.alabaster.denoise = True
        bpy.context.view_layer.alabaster.denoised = True
        with unittest.mock.patch.dict(os.environ, {"ALABASTER_OIDN": "/nowhere"}):
            self.assertEqual(self.pixels().shape, (30, 40, 4))

    def test_a_damaged_image_is_a_warning(self):
        told = []
        notes = engine.Notes(types.SimpleNamespace.__class__)
        with unittest.mock.patch.object(engine.Notes, "tell", lambda _, severity, text: told.append(severity)):
            notes.hear("error", "image.unreadable", "a.png", "is damaged")
        self.assertEqual(told, ["WARNING"])

    def test_a_scene_that_memory_does_not_hold_fails(self):
        renderer = types.SimpleNamespace(stats=lambda: {"scene.outOfMemory": True, "scene.faults": "mesh: too large\nmore"})
        with self.assertRaisesRegex(RuntimeError, "^mesh: too large$"):
            engine.AlabasterRenderEngine.check(None, types.SimpleNamespace(state="running"), renderer)

    def test_cancel_is_prompt(self):
        scene = hdalabaster.Scene()
        scene.set_light("/dome", "domeLight", intensity=1)
        renderer = hdalabaster.Renderer(scene, samples=1 << 20)
        render = renderer.start(width=256, height=256, camera={"focalLength": 1.0})
        pressed = time.monotonic() + 0.5
        shown = []
        fake = types.SimpleNamespace(check=lambda *_: None, test_break=lambda: time.monotonic() > pressed, update_stats=lambda *_: None,
                                     update_progress=lambda _: None, show=lambda *rest: shown.append(rest[-1]))
        engine.AlabasterRenderEngine.refine(fake, renderer, render, None, [], (0, 0, 256, 256), {})
        self.assertLess(time.monotonic() - pressed, 1.0)
        self.assertEqual((render.state, bool(shown[-1])), ("stopped", True))

    def test_unregistering_ends_frames_first(self):
        """Blender frees the engine below the threads that render with it."""
        frames, told = engine.Frames(), []
        frames.open()

        def render():
            with frames.one():
                while not frames.closed:
                    time.sleep(0.01)
                time.sleep(0.1)
                told.append("over")
        thread = threading.Thread(target=render)
        thread.start()
        while not frames.threads:
            time.sleep(0.01)
        frames.close()
        told.append("closed")
        thread.join()
        self.assertEqual(told, ["over", "closed"])
        closing = time.monotonic() + 0.5
        fake = types.SimpleNamespace(check=lambda *_: None, test_break=lambda: time.monotonic() > closing and self.fail("goes on"),
                                     update_stats=lambda *_: None, update_progress=lambda _: None, show=lambda *_: None)
        renderer = types.SimpleNamespace(command=lambda _: None, stats=dict, progress=lambda: {"samples_total": 0, "fraction": 0.0})
        with unittest.mock.patch.object(engine, "frames", frames):
            engine.AlabasterRenderEngine.refine(fake, renderer, types.SimpleNamespace(wait=lambda _: False, cancel=lambda: None), None, [],
                                                (0, 0, 8, 8), {})

    def test_a_frame_does_not_wait_for_itself(self):
        """A handler that runs within the frame disables the add-on."""
        frames, began = engine.Frames(), time.monotonic()
        frames.PATIENCE = 5.0
        frames.open()
        with frames.one():
            with self.assertRaisesRegex(RuntimeError, "within its own frame"):
                frames.close()
        self.assertLess(time.monotonic() - began, 2.0)
        self.assertFalse(frames.closed)

    def test_noise_is_told_while_a_picture_refines(self):
        scene = hdalabaster.Scene()
        scene.set_light("/dome", "domeLight", intensity=1)
        scene.set_mesh("/floor", [(-1, -1, -3), (1, -1, -3), (0, 1, -3)], [[0, 1, 2]])
        renderer = hdalabaster.Renderer(scene, samples=1 << 20)
        render = renderer.start(width=64, height=64, camera={"focalLength": 1.0})
        end = time.monotonic() + 60
        while "Noise" not in engine.status(renderer)[0] and time.monotonic() < end:
            render.wait(0.05)
        self.assertRegex(engine.status(renderer)[0], r"^Sample \d+/1048576 \| Noise [\d.]+ %")
        render.cancel()

    def test_keyed_settings_and_world_move(self):
        scene = bpy.context.scene
        strength = scene.world.node_tree.nodes["Background"].inputs["Strength"]
        for frame in (1, 2):
            scene.alabaster.samples, strength.default_value = frame, 0.25 * frame
            scene.alabaster.keyframe_insert("samples", frame=frame)
            strength.keyframe_insert("default_value", frame=frame)
        scene.frame_start, scene.frame_end = 1, 2
        scene.frame_set(1)
        heard = []

        def told(function, name):
            def call(*args):
                made = function(*args)
                heard.append((made[1] if isinstance(made, tuple) else made)[name])
                if name == "samples":
                    heard.append(made["frame"])
                return made
            return call
        with tempfile.TemporaryDirectory() as folder, \
                unittest.mock.patch.object(settings, "delegate_settings", told(settings.delegate_settings, "samples")), \
                unittest.mock.patch.object(world, "translate", told(world.translate, "intensity")):
            scene.render.filepath = folder + "/"
            bpy.ops.render.render(animation=True)
        self.assertEqual(heard, [0.25, 1, 1, 0.5, 2, 2])

    def test_a_viewport_goes_with_its_engine(self):
        fake = type("Engine", (), {})()
        view = engine.AlabasterRenderEngine.viewport(fake)
        view.begin(bpy.context.evaluated_depsgraph_get(), None)
        held = weakref.ref(fake)
        del fake, view
        gc.collect()
        self.assertIsNone(held())

    def test_a_picture_that_comes_while_one_is_shown_is_shown_next(self):
        class Render:
            """A second picture comes right after the first was copied."""
            generation = 1

            def __getitem__(self, _):
                return self

            def show(self, _, pixels, **__):
                pixels[:] = self.generation
                self.generation = 2
                return True
        view = engine.Viewport(types.SimpleNamespace.__class__, None, None)
        view.render, view.frame = Render(), {"width": 2, "height": 2}
        drawn = []
        with unittest.mock.patch.object(view.take.__globals__["gpu"], "types", types.SimpleNamespace(
                Buffer=lambda _, __, data: data.copy(), GPUTexture=lambda *_, data, **__: drawn.append(data[0]) or data)):
            view.take()
            view.take()
            view.take()
        self.assertEqual(drawn, [1, 2])

    def test_errors_reach_the_panel(self):
        bpy.context.scene.camera = None
        with self.assertRaises(RuntimeError) as raised:
            bpy.ops.render.render()
        self.assertIn("camera", str(raised.exception))
