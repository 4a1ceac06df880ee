#include <algorithm>
#include <filesystem>

#include "core/files/input_file.h"
#include "delegate/description/description_reader.h"
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

// The file that a name leads to, through symbolic links.
std::string target_of(const fs::path& file) {
  std::error_code error;
  const fs::path whole = fs::weakly_canonical(fs::absolute(file), error);
  return (error ? fs::absolute(file).lexically_normal() : whole).string();
}

// A glTF document that others made is no copy of a scene.
bool is_foreign_gltf(const std::string& name) {
  const InputFile file(name);
  std::string text;
  return file && (!file.read(&text) || text.find(kGenerator) == std::string::npos);
}

}  // namespace

WrittenFiles::WrittenFiles(const std::string& description) {
  const fs::path whole = fs::absolute(description);
  folder_ = target_of(whole.parent_path());
  name_ = whole.stem().string();
}

void WrittenFiles::add(const std::string& ending, std::string bytes) {
  check_taken(ending);
  files_.emplace_back(ending, std::move(bytes));
}

// Throws where a file of the scene would be replaced.
void WrittenFiles::check_taken(const std::string& ending) const {
  const std::string file = target_of(fs::path(folder_) / beside(ending));
  for (const auto& [id, other] : named_)
    if (file == other) throw NotWritten(id, "names the file " + other + ", which would be replaced; write elsewhere");
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
  if (!is_utf8(given)) throw NotWritten(id, "names a file that is not UTF-8, as names in descriptions are; rename it");
  const std::string whole = target_of(given);
  named_.emplace_back(id, whole);
  for (const auto& [ending, bytes] : files_) check_taken(ending);
  check_taken(".exr");  // of the product
  const fs::path relative = fs::path(whole).lexically_relative(folder_);
  return relative.empty() || *relative.begin() == ".." ? whole : relative.string();
}

bool WrittenFiles::is_gltf_image(const Value& file) {
  const auto* asset = file.get<AssetPath>();
  std::vector<uint8_t> first(8);
  if (asset && asset->bytes)
    first = *asset->bytes;
  else if (const InputFile named(file.text_or("")); named && named.size() >= first.size())
    named.read(0, first.data(), first.size());
  const std::string ending = ending_of(first);
  return ending == ".png" || ending == ".jpg" || ending == ".webp";
}

std::string WrittenFiles::write() const {
  const auto whole = [&](const std::string& ending) { return (fs::path(folder_) / beside(ending)).string(); };
  for (const auto& [ending, bytes] : files_)
    if (const std::string fault = support::OutputFault(whole(ending)); !fault.empty())
      return whole(ending) + ": " + fault;
  if (is_foreign_gltf(whole(".gltf")))
    return whole(".gltf") + ": this glTF document is no written scene and would be replaced; choose another name";
  for (const auto& [ending, bytes] : files_) {
    const std::span<const uint8_t> all(reinterpret_cast<const uint8_t*>(bytes.data()), bytes.size());
    if (const std::string fault = support::WriteOutputFile(whole(ending), all); !fault.empty())
      return whole(ending) + ": " + fault;
  }
  return {};
}

}  // namespace alabaster::hd::description
