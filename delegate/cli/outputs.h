// Turns the command line's outputs and colour options into render products.
#pragma once

#include "delegate/cli/commands.h"
#include "delegate/cli/scene_inputs.h"
#include "delegate/cli/scene_session.h"

namespace alabaster::cli {

/// The products of -o with --aov, --denoise, --display, --view, --look and --exposure applied. Empty, with *error set,
/// if the options contradict each other. `existing` are the description's products, used where -o is not given.
std::vector<hd::RenderProduct> make_products(const RenderArguments& arguments,
                                             const std::vector<hd::RenderProduct>& existing, std::string* error);

/// Parses "1280x720", with sides of 1 to 65536. Empty if malformed.
std::optional<hd::Vec2i> parse_size(const std::string& text);
/// The error message if the value of --size is malformed; empty if it is good or was not given.
std::string size_fault(const std::string& text);
/// Parses "x0,y0,x1,y1". Empty if malformed.
std::optional<hd::Rect2i> parse_crop(const std::string& text);
struct PixelChoice {
  int x = 0, y = 0;  // from the frame's upper left corner
  std::optional<uint32_t> sample;
};
/// Parses "x,y" and "x,y,sample"; the sample is not negative. Empty if malformed.
std::optional<PixelChoice> parse_pixel(const std::string& text);
/// Parses "open:close", two finite numbers in order.
std::optional<std::pair<double, double>> parse_interval(const std::string& text);
/// Parses "begin:end", whole numbers, 0 <= begin < end <= 1048576. Empty if malformed.
std::optional<std::pair<uint32_t, uint32_t>> parse_samples(const std::string& text);
/// Parses "first:last" and "first:last:step" as the frames' numbers, at most 100,000. Empty if malformed or none.
std::vector<uint32_t> parse_frames(const std::string& text);
/// `file` with the last '#'s of its name replaced by the frame's number, which has leading zeros to their count. Empty
/// if the name has none.
std::string frame_file(const std::string& file, uint32_t frame);

/// The error message if two of `files` are the same file, however they are spelt; else empty.
std::string same_file_twice(const std::vector<std::string>& files);

}  // namespace alabaster::cli
