// Which channels of an EXR are the picture. Internal to this room.
#pragma once

#include <array>
#include <string>
#include <vector>

#include "core/texture/exr_header.h"

namespace alabaster {

struct ExrLayer {
  size_t part = 0;
  /// Names of the channels of red, green, blue and alpha; all three colours the same for a grey image. Empty: there is
  /// none, which is 0, or opaque.
  std::array<std::string, 4> channels;
};

/// Finds the layer of that name: a part's name, what stands before the last '.' in the names of channels, both joined
/// by '.', or the name of a single channel. An empty `name` finds the picture: the plain R, G and B of an image that
/// has one part, or a layer with the name of a picture (rgba, beauty, Combined, ...), or the plain R, G and B of
/// another part whose name is not that of data, or the only layer. False, with the reason and the layers' names, if
/// there is no such layer.
bool find_exr_layer(const std::vector<ExrPart>& parts, const std::string& name, ExrLayer* layer, ImageFault* fault);

}  // namespace alabaster
