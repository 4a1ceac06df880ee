// The layers of a scene's description: the file, and over it what the options of a load set. Internal to this room.
#pragma once

#include "delegate/description/json_document.h"
#include "delegate/description/render_description.h"

namespace alabaster::hd::description {

/// The options as a description of their own, whose values have them as origin: the camera, the shutter, the overrides,
/// size and crop and, as the last light, the dome. Each comes over those before it. A preset of quality is written out
/// where it stands, so that it comes over settings of the file and below later overrides. False after a report: an
/// option is malformed.
bool read_options(const LoadOptions& options, const DiagnosticSink& sink, JsonDocument* given);
/// Puts them, and the choices of the model, over a description. A chosen camera takes the place of the file's. False
/// after a report: the choice of a model is ambiguous.
bool lay_over(const JsonDocument& given, const LoadOptions& options, const DiagnosticSink& sink,
              JsonDocument* document);

/// An option of a load as messages name it: "--camera NAME" or "camera=NAME"; without a value "--camera" or "camera".
std::string option_text(const LoadOptions& options, const std::string& name, const std::string& value = {});

/// Sets the settings of the file's preset beside it, where the file does not set them itself.
void expand_preset(nlohmann::json* description);

}  // namespace alabaster::hd::description
