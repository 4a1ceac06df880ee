// The layers of a scene's description: the file, and over it what the options of a load set. Internal to this room.
#pragma once

#include "delegate/description/json_document.h"
#include "delegate/description/render_description.h"

namespace alabaster::hd::description {

/// A change that an option makes: the same that a key of a description makes, or an entry of one of its lists.
struct Edit {
  std::string part, pattern, name;  // "materials", "skin", "roughness". Without a name `value` is all of the entry
  nlohmann::json value;
  std::string origin;  // the option, as messages name it
};
using Edits = std::vector<Edit>;

/// The edits of the options: the camera, the shutter, the choices of the model, the overrides, size and crop and, as
/// the last light, the dome. Each comes over those before it. A preset of quality is the edits of its settings, so that
/// it comes over those of the file and below later overrides. None after a report: an option is malformed.
std::optional<Edits> edits_of(const LoadOptions& options, const DiagnosticSink& sink);
/// Puts the edits over a description. A chosen camera takes the place of the file's. False after a report: the choice
/// of a model is ambiguous.
bool add_edits(const Edits& edits, const DiagnosticSink& sink, JsonDocument* document);

/// An option of a load as messages name it: "--camera NAME" or "camera=NAME"; without a value "--camera" or "camera".
std::string option_text(const LoadOptions& options, const std::string& name, const std::string& value = {});

/// Sets the settings of the file's preset beside it, where the file does not set them itself.
void expand_preset(nlohmann::json* description);

}  // namespace alabaster::hd::description
