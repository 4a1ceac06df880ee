#include <algorithm>
#include <filesystem>
#include <fstream>

#include "delegate/description/written_parts.h"
#include "delegate/support/output_file.h"

namespace alabaster::hd::description {
namespace {

namespace fs = std::filesystem;

// Images are recognized by their content; the ending is for people.
const char* ending_of(const std::vector<uint8_t>& bytes) {
  const std::string_view text(reinterpret_cast<const char*>(bytes.data()), bytes.size());
  if (text.starts_with("\x89PNG")) return ".png";
  if (text.starts_with("\xff\xd8")) return ".jpg";
  if (text.starts_with("RIFF")) return ".webp";
  if (text.starts_with("v/1\x01")) return ".exr";
  if (text.starts_with("#?")) return ".hdr";
  return ".image";
}

std::string absolute(const std::string& file) {
  return fs::absolute(file).lexically_normal().string();
}

}  // namespace

WrittenFiles::WrittenFiles(const std::string& description) {
  const fs::path whole = fs::absolute(description).lexically_normal();
  folder_ = whole.parent_path().string();
  name_ = whole.stem().string();
}

void WrittenFiles::add(const std::string& ending, std::string bytes) {
  const std::string file = (fs::path(folder_) / beside(ending)).string();
  for (const auto& [id, other] : named_)
    if (file == other) throw NotWritten(id, "names the file " + other + ", which would be replaced; write elsewhere");
  files_.emplace_back(ending, std::move(bytes));
}

std::string WrittenFiles::name_of(const Path& id, const Value& file) {
  const auto* asset = file.get<AssetPath>();
  if (asset && asset->bytes) {
    std::string& name = images_[asset->bytes.get()];
    if (!name.empty()) return name;
    const std::string ending = "_image" + std::to_string(images_.size()) + ending_of(*asset->bytes);
    add(ending, std::string(asset->bytes->begin(), asset->bytes->end()));
    return name = beside(ending);
  }
  const std::string given = file.text_or("");
  if (given.empty()) return given;
  const std::string whole = absolute(given);
  named_.emplace_back(id, whole);
  for (const auto& [ending, bytes] : files_)
    if (whole == (fs::path(folder_) / beside(ending)).string())
      throw NotWritten(id, "names the file " + whole + ", which would be replaced; write elsewhere");
  const fs::path relative = fs::path(whole).lexically_relative(folder_);
  return relative.empty() || *relative.begin() == ".." ? whole : relative.string();
}

bool WrittenFiles::is_gltf_image(const Value& file) {
  const auto* asset = file.get<AssetPath>();
  std::vector<uint8_t> first(8);
  if (asset && asset->bytes)
    first = *asset->bytes;
  else
    std::ifstream(file.text_or(""), std::ios::binary).read(reinterpret_cast<char*>(first.data()), 8);
  const std::string ending = ending_of(first);
  return ending == ".png" || ending == ".jpg" || ending == ".webp";
}

std::string WrittenFiles::write() const {
  const auto whole = [&](const std::string& ending) { return (fs::path(folder_) / beside(ending)).string(); };
  for (const auto& [ending, bytes] : files_)
    if (const std::string fault = support::OutputFault(whole(ending)); !fault.empty())
      return whole(ending) + ": " + fault;
  for (const auto& [ending, bytes] : files_) {
    const std::span<const uint8_t> all(reinterpret_cast<const uint8_t*>(bytes.data()), bytes.size());
    if (const std::string fault = support::WriteOutputFile(whole(ending), all); !fault.empty())
      return whole(ending) + ": " + fault;
  }
  return {};
}

}  // namespace alabaster::hd::description
