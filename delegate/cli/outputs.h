// Turns the command line's outputs and colour options into render products.
#pragma once

#include "delegate/cli/commands.h"
#include "delegate/cli/scene_session.h"

namespace alabaster::cli {

/// The products of -o with --aov, --denoise, --display, --view, --look and --exposure applied. Ends the
/// command if the options contradict each other. `existing` are the description's products, used where -o is not given.
std::vector<hd::RenderProduct> make_products(const PictureArguments& arguments,
                                             const std::vector<hd::RenderProduct>& existing, const char* command,
                                             Console& console);
/// `file` with the last '#'s of its name replaced by the frame's number, which has leading zeros to their count. Empty
/// if the name has none.
std::string frame_file(const std::string& file, double frame);

/// The error message if two of `files` are the same file, however they are spelt; else empty.
std::string same_file_twice(const std::vector<std::string>& files);

}  // namespace alabaster::cli
