// The layers of a scene's description: the file, and over it what the options of a load set. Internal to this room.
#pragma once

#include "delegate/description/json_document.h"
#include "delegate/description/render_description.h"

namespace alabaster::hd::description {

/// Sets in `document` what the options set: the camera, the shutter, the choices of the model, the overrides, size and
/// crop and, as its last light, the dome. Each layer comes over those before it. A preset of quality sets its settings,
/// so that it comes over those of the file and below later overrides. A chosen camera takes the place of the file's.
/// False after a report: an override is malformed, or the choice of a model is ambiguous.
bool add_options(const LoadOptions& options, const DiagnosticSink& sink, JsonDocument* document);

/// An option of a load as messages name it: "--camera NAME" or "camera=NAME"; without a value "--camera" or "camera".
std::string option_text(const LoadOptions& options, const std::string& name, const std::string& value = {});

/// Sets the settings of the file's preset beside it, where the file does not set them itself.
void expand_preset(nlohmann::json* description);

}  // namespace alabaster::hd::description
