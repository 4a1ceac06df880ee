// Paths of the build for tests. They are compiled into one file alone, so that ccache finds the others in any folder.
#pragma once

#include <string>

namespace alabaster::testing {

/// A file of the sources, given below their root.
std::string source_file(const std::string& below);
/// The text of such a file.
std::string source_text(const std::string& below);

extern const char* const kProgram;       // alabaster
extern const char* const kFakeOidn;      // stands in for Open Image Denoise
extern const char* const kPlainLibrary;  // a library that is no denoiser

}  // namespace alabaster::testing
