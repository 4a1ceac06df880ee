#!/usr/bin/env python3
"""The layer check finds each kind of wrong include, and lets the right ones through."""
import unittest

from check_layers import faults, hidden_headers, installed_headers

INSTALLED = installed_headers("set(ALABASTER_INSTALLED_HEADERS\n  delegate/api/types.h delegate/host/render_index.h)\n")
HIDDEN = hidden_headers({
    "core/texture/png_stream.h": "// PNG files made safe. Internal to this room.\n",
    "core/texture/texture.h": "// Textures.\n// Not a word of: Internal to this room.\n",
    "delegate/host/product_plan.h": "// Plans.\n",
    "delegate/host/render_index.h": "// The index.\n",
    "delegate/prims/records.h": "// Records.\n"}, INSTALLED)


def found(path, include):
    return [fault.split(": ")[-1] for fault in faults(path, f"#pragma once\n#include {include}\n", HIDDEN, INSTALLED)]


class Layers(unittest.TestCase):
    def test_right_includes_pass(self):
        for path, include in [("core/light/light.cpp", '"core/math/vector.h"'),
                              ("core/texture/texture.cpp", '"core/texture/png_stream.h"'),
                              ("delegate/rendering/render_pass.h", '"delegate/prims/records.h"'),
                              ("delegate/prims/mesh.cpp", '"core/session/render_session.h"'),
                              ("delegate/host/product_writer.cpp", '"delegate/host/product_plan.h"'),
                              ("delegate/cli/main.cpp", '"delegate/support/process_usage.h"'),
                              ("testenv/unit/delegate/host/plan_test.cpp", '"delegate/host/product_plan.h"'),
                              ("delegate/host/render_index.h", '"delegate/api/types.h"'),
                              ("delegate/cli/main.cpp", "<CLI/CLI.hpp>")]:
            self.assertEqual(found(path, include), [], path + " " + include)

    def test_arrows_point_one_way(self):
        self.assertEqual(found("core/math/a.h", '"core/light/light.h"'), ["room math lies below light"])
        self.assertEqual(found("core/light/a.h", '"delegate/api/types.h"'), ["core must not include it"])
        self.assertEqual(found("delegate/prims/a.h", '"testenv/support/stage.h"'), ["the library must not include its tests"])
        for path, include in [("delegate/api/a.h", "delegate/support/nearest_name.h"),
                              ("delegate/support/a.h", "delegate/prims/records.h"),
                              ("delegate/support/a.cpp", "core/math/vector.h"),
                              ("delegate/prims/a.cpp", "delegate/rendering/framing.h"),
                              ("delegate/prims/a.cpp", "delegate/host/render_index.h"),
                              ("delegate/host/a.cpp", "delegate/rendering/framing.h"),
                              ("delegate/host/a.cpp", "core/integrator/path_integrator.h"),
                              ("delegate/gltf/a.cpp", "delegate/description/render_description.h"),
                              ("delegate/tradeoff/a.cpp", "delegate/cli/console.h"),
                              ("delegate/cli/a.cpp", "delegate/prims/records.h"),
                              ("delegate/cli/a.cpp", "core/math/vector.h")]:
            self.assertEqual(len(found(path, f'"{include}"')), 1, path + " " + include)

    def test_internal_headers_stay_in_their_room(self):
        self.assertEqual(found("core/light/dome_light.cpp", '"core/texture/png_stream.h"'),
                         ["the header is internal to core/texture"])
        self.assertEqual(found("delegate/cli/outputs.cpp", '"delegate/host/product_plan.h"'),
                         ["the header is internal to delegate/host"])
        self.assertEqual(found("testenv/unit/delegate/cli/a_test.cpp", '"delegate/host/product_plan.h"'),
                         ["the header is internal to delegate/host"])

    def test_installed_headers_need_installed_ones_only(self):
        self.assertIn("an installed header must include installed headers only",
                      found("delegate/host/render_index.h", '"delegate/support/nearest_name.h"'))

    def test_libraries_stay_in_their_rooms(self):
        self.assertEqual(found("core/light/a.cpp", "<OpenImageIO/imageio.h>"),
                         ["belongs to core/images/open_image_io/"])
        self.assertEqual(found("core/light/a.cpp", '"light.h"'), ["write includes from the root of the repository"])


if __name__ == "__main__":
    unittest.main()
