// Turns the command line's outputs and colour options into render products.
#pragma once

#include "delegate/cli/commands.h"
#include "delegate/cli/scene_session.h"

namespace alabaster::cli {

/// The AOV of a --aov: "NAME", or "NAME=LAYER".
std::string aov_of(const std::string& given);

/// The products of -o with --aov, --denoise, --display, --view, --look and --exposure applied. Ends the
/// command if the options contradict each other. `existing` are the description's products, used where -o is not given.
std::vector<hd::RenderProduct> make_products(const PictureArguments& arguments,
                                             const std::vector<hd::RenderProduct>& existing, const char* command,
                                             Console& console);
/// The pixels of a product's file.
hd::Rect2i product_window(const hd::RenderSettingsDescription& frame, const hd::RenderProduct& product);
/// True if a product's file is there, whole and of its size.
bool is_there(const hd::RenderSettingsDescription& frame, const hd::RenderProduct& product);

/// Where a file's name has the number of a frame: the last of ####, ###.###, %04d and $F4 in it, none in its folders.
struct FramePlace {
  size_t begin = 0, end = 0;
  size_t width = 1, digits = 0;  // of the number with leading zeros, and of it after the point
};
std::optional<FramePlace> frame_place(const std::string& file);
/// `file` with the frame's number in that place. Empty if the name has none.
std::string frame_file(const std::string& file, double frame);
/// Ends the command if frames would go to the same file.
void check_frame_names(const std::vector<std::string>& files, const RenderArguments& a, Console& console);

/// The error message if two of `files` are the same file, however they are spelt; else empty.
std::string same_file_twice(const std::vector<std::string>& files);

}  // namespace alabaster::cli
