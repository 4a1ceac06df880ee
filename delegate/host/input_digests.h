// Digests of what decides a picture beside its scene's values, so that machines can tell if they have the same.
#pragma once

#include <map>
#include <optional>
#include <string>

#include "delegate/host/product_writer.h"

namespace alabaster::hd::host {

/// The digest of a regular file: 32 hexadecimal digits. Empty: it cannot be read. Any thread.
ALABASTER_API std::string FileDigest(const std::string& file);

struct ColorInputs {
  std::string origin;   // the file of the configuration, or "built-in"
  std::string library;  // the version of OpenColorIO that reads it, as the process has loaded it
  std::string digest;   // of its text, and of the display and view that it takes where none is named
  struct Lut {
    std::string file;    // where the search path finds it; empty: nowhere
    std::string digest;  // empty: it cannot be read
  };
  std::map<std::string, Lut> luts;  // of its transforms, by their names in it
  /// Variables of the environment that it depends on, with their values or defaults, without those that the system and
  /// the login of each machine set, such as HOME and PATH: LUTs found through them still count. Empty: not set.
  std::map<std::string, std::optional<std::string>> variables;
  /// A digest of all that changes pixels: equal wherever the configuration is, and whatever it is called.
  ALABASTER_API std::string all() const;
};

/// Reads all LUTs. Nothing after a report if the configuration cannot be read. Any thread.
ALABASTER_API std::optional<ColorInputs> ReadColorInputs(const OutputColors& colors, const DiagnosticSink& sink);

}  // namespace alabaster::hd::host
