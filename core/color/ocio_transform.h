// The one place where pixels meet OCIO. Internal to this room.
#pragma once

#include <OpenColorIO/OpenColorIO.h>

#include <limits>

#include "core/color/color_config.h"

namespace alabaster {

inline constexpr float kLargestFloat = std::numeric_limits<float>::max();

/// Scales rgb by `scale`, sets what is not finite to 0, clamps to +-`largest`, and runs it through `processor` (null:
/// identity). May throw OCIO's exceptions.
std::shared_ptr<const ColorTransform> make_transform(const OCIO_NAMESPACE::ConstProcessorRcPtr& processor, float scale,
                                                     float largest);

/// Keeps OCIO from logging to stderr while it lives, and gives the host's logging level back afterwards. May be nested
/// and used from several threads.
class QuietOcio {
 public:
  QuietOcio();
  ~QuietOcio();
  QuietOcio(const QuietOcio&) = delete;
  QuietOcio& operator=(const QuietOcio&) = delete;
};

}  // namespace alabaster
