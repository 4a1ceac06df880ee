#include "delegate/gltf/gltf_names.h"

namespace alabaster::hd::gltf {
namespace {

constexpr size_t kLongestName = 120;

}  // namespace

std::string clean_name(const std::string& text) {
  std::string name = text;
  if (name.size() > kLongestName) {
    size_t end = kLongestName;  // not inside a UTF-8 sequence
    while (end > 0 && (static_cast<unsigned char>(name[end]) & 0xc0) == 0x80) --end;
    name.resize(end);
  }
  for (char& c : name)
    if (c == '/' || static_cast<unsigned char>(c) <= ' ' || c == 0x7f) c = '_';
  return name;
}

std::string prim_name(size_t index, const std::string& name) {
  std::string text = std::to_string(index);
  if (!name.empty()) text.append("_").append(clean_name(name));
  return text;
}

}  // namespace alabaster::hd::gltf
