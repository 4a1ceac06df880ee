// Values of a picture that the program wrote.
#pragma once

#include <OpenImageIO/imageio.h>

#include <filesystem>
#include <vector>

namespace alabaster::cli {

/// All channels of all pixels; empty where the file cannot be read.
inline std::vector<float> pixels_of(const std::filesystem::path& file) {
  const auto input = OIIO::ImageInput::open(file);
  if (!input) return {};
  std::vector<float> all(size_t(input->spec().image_pixels()) * size_t(input->spec().nchannels));
  input->read_image(0, 0, 0, input->spec().nchannels, OIIO::TypeDesc::FLOAT, all.data());
  return all;
}

}  // namespace alabaster::cli
