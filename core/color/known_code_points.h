// Internal to this room.
#pragma once

#include <OpenColorIO/OpenColorIO.h>

#include <optional>

#include "core/color/code_points.h"

namespace alabaster {

/// How display `display` of `config` codes the colours of its view; empty where H.273 has no name for it. Names of
/// spaces in display references are not looked at, but what they do to colours. Throws what OpenColorIO throws.
std::optional<CodePoints> known_code_points(const OCIO_NAMESPACE::ConstConfigRcPtr& config, const char* display,
                                            const char* view);

}  // namespace alabaster
