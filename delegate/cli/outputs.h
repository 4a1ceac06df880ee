// From the command line's outputs and colour options to render products.
#pragma once

#include "delegate/cli/commands.h"
#include "delegate/cli/scene_session.h"

namespace alabaster::cli {

/// The products of -o with --aov, --display, --view, --look and --exposure applied. Empty + *error on contradictions.
/// `existing`: what the description names, used where -o is not given.
std::vector<hd::RenderProduct> make_products(const RenderArguments& arguments,
                                             const std::vector<hd::RenderProduct>& existing, std::string* error);

/// "1280x720" and "x0,y0,x1,y1" as the value of a description's resolution and crop: "[1280,720]". Empty if malformed.
std::string size_value(const std::string& text);
std::string crop_value(const std::string& text);

}  // namespace alabaster::cli
