// Internal to this room.
#pragma once

#include <OpenColorIO/OpenColorIO.h>

#include "core/color/display_encoding.h"

namespace alabaster {

/// How display `display` of `config` codes the colours of its view; empty where it is not known. Names of spaces in
/// display references are not looked at, but what they do to colours. Throws what OpenColorIO throws.
std::optional<DisplayEncoding> known_encoding(const OCIO_NAMESPACE::ConstConfigRcPtr& config, const char* display,
                                              const char* view);

}  // namespace alabaster
