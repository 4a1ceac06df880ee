// The file, the GLB container and the URIs of a glTF document. All sizes are checked before anything is read.
#pragma once

#include <memory>
#include <nlohmann/json.hpp>
#include <optional>
#include <string_view>

#include "core/memory/memory_budget.h"
#include "delegate/gltf/gltf_report.h"

namespace alabaster::hd::gltf {

using Json = nlohmann::json;
using Bytes = std::shared_ptr<const std::vector<uint8_t>>;

/// The member of that name; null if `object` is no object, or lacks it.
const Json& at(const Json& object, std::string_view name);
inline const Json& extension_of(const Json& object, std::string_view name) {
  return at(at(object, "extensions"), name);
}

struct Container {
  Json root;
  bool is_glb = false;
  Bytes binary_chunk;  // null: none
};

struct FileToRead {
  std::string name;
  std::string within;  // as of an AssetPath
};

/// Throws MemoryRefused.
inline void hold_more(MemoryReservation* memory, size_t bytes, const std::string& what) {
  memory->resize(memory->bytes() + bytes, what);
}

/// Reads .gltf or .glb, which it distinguishes by content, and has `memory` hold it in addition (MemoryRefused).
/// Reports faults; false if nothing is usable.
bool read_container(const FileToRead& file, MemoryReservation* memory, Report& report, Container* container);

/// Reads a whole regular file, which `memory` then holds in addition (MemoryRefused). Null and `reason` if it cannot be
/// read.
Bytes read_file(const FileToRead& file, MemoryReservation* memory, std::string* reason);

struct DataUri {
  std::string media_type;  // lower case
  std::vector<uint8_t> bytes;
};
inline constexpr const char* kIsVersion1 =
    "the file is glTF 1.0, and only glTF 2.0 is read; export it again as glTF 2.0, or convert it";

inline bool is_data_uri(std::string_view uri) {
  return uri.substr(0, 5) == "data:";
}

/// Decodes "data:[type][;parameter]...;base64,...". Empty and `reason` if malformed.
std::optional<DataUri> decode_data_uri(std::string_view uri, std::string* reason);

/// The folder that the names of a document are relative to, and that which its files must lie in (as of an AssetPath).
struct UriBase {
  std::string folder, within;
};

/// Percent-decodes a relative URI and joins it to the folder. Empty and `reason` if it names no file or has a scheme,
/// and unless it is allowed, if it is absolute or leaves the folder: a document must not reach files that its author
/// could not have shipped with it.
std::optional<std::string> resolve_uri(const UriBase& base, std::string_view uri, std::string* reason);

}  // namespace alabaster::hd::gltf
