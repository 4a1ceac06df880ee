#include "delegate/tradeoff/state.h"

#include <cctype>
#include <cstdio>
#include <nlohmann/json.hpp>

#include "core/files/input_file.h"
#include "delegate/support/output_file.h"

namespace alabaster::tradeoff {
namespace {

namespace fs = std::filesystem;
using nlohmann::json;

constexpr int kFormat = 2;

std::string file_name(const StoredRender& render, const char* ending) {
  std::string name = render.configuration;
  for (char& c : name)
    if (!std::isalnum(static_cast<unsigned char>(c)) && c != '-') c = '_';
  return name + "." + std::to_string(render.samples) + "." + std::to_string(render.replica) + ending;
}

/// Calls visit(name, member) for each member that is stored.
template <class Render, class Visit>
void for_each_member(Render& render, const Visit& visit) {
  visit("configuration", render.configuration);
  visit("settings", render.fingerprint);
  visit("samples", render.samples);
  visit("replica", render.replica);
  visit("cpuSeconds", render.cost.cpu_seconds);
  visit("wallSeconds", render.cost.wall_seconds);
  visit("totalSeconds", render.cost.total_seconds);
  visit("reportedError", render.cost.reported_error);
  visit("file", render.file);
  visit("checksum", render.checksum);
  visit("denoiseCpuSeconds", render.cost.denoise_cpu_seconds);
  visit("denoiseWallSeconds", render.cost.denoise_wall_seconds);
  visit("denoisedFile", render.denoised_file);
  visit("denoisedChecksum", render.denoised_checksum);
}

json to_json(const StoredRender& render) {
  json entry;
  for_each_member(render, [&](const char* name, const auto& member) { entry[name] = member; });
  return entry;
}

StoredRender from_json(const json& entry) {
  StoredRender render;
  for_each_member(render, [&](const char* name, auto& member) { entry.at(name).get_to(member); });
  return render;
}

std::string write(const fs::path& file, const void* bytes, size_t size) {
  const std::string problem =
      hd::support::WriteOutputFile(file.string(), {static_cast<const uint8_t*>(bytes), size}, hd::support::Flush::none);
  return problem.empty() ? "" : file.string() + " cannot be written: " + problem + ".";
}

}  // namespace

std::string checksum(const void* bytes, size_t size) {
  uint64_t hash = 0xcbf29ce484222325u;
  for (size_t i = 0; i < size; ++i) hash = (hash ^ static_cast<const uint8_t*>(bytes)[i]) * 0x100000001b3u;
  char text[17];
  std::snprintf(text, sizeof text, "%016lx", static_cast<unsigned long>(hash));
  return text;
}

std::string StudyStore::open(const fs::path& folder, bool restart) {
  folder_ = folder;
  std::error_code error;
  fs::create_directories(folder, error);
  if (error) return folder.string() + " cannot be made: " + error.message() + ". Choose another folder with -o.";
  if (restart) return clear();
  const InputFile file(folder / "state.json");
  if (file.fault() == InputFile::Fault::missing) return "";
  std::string text;
  if (!file) return (folder / "state.json").string() + ": " + file.reason() + ".";
  if (!file.read(&text) || !parse(text))
    return (folder / "state.json").string() +
           " is damaged or from another version: start afresh with --restart, or choose another folder with -o.";
  std::erase_if(renders_, [&](const StoredRender& render) {
    if (read(render) && (render.denoised_file.empty() || read_denoised(render))) return false;
    notes_.push_back(render.file + " is missing or damaged and will be rendered again");
    spent -= render.cost.total_seconds;
    return true;
  });
  return "";
}

bool StudyStore::parse(const std::string& text) {
  try {
    const json state = json::parse(text);
    if (state.at("format") != kFormat) return false;
    state.at("scene").get_to(identity.scene);
    state.at("sceneHash").get_to(identity.scene_hash);
    state.at("width").get_to(identity.width);
    state.at("height").get_to(identity.height);
    identity.versions = state.value("versions", "");
    state.at("referenceSamples").get_to(reference_samples);
    state.at("spentSeconds").get_to(spent);
    for (const json& entry : state.at("renders")) renders_.push_back(from_json(entry));
    const auto possible = [](uint64_t samples) { return samples >= 1 && samples <= kMostSamples; };
    for (const StoredRender& render : renders_)
      if (!possible(render.samples)) return false;
    if (reference_samples != 0 && !possible(reference_samples)) return false;
    return identity.width > 0 && identity.height > 0 && identity.width <= 65536 && identity.height <= 65536;
  } catch (const json::exception&) {
    return false;
  }
}

std::string StudyStore::clear() {
  renders_.clear();
  notes_.clear();
  identity = {};
  reference_samples = 0;
  spent = 0;
  std::error_code error;
  std::vector<fs::path> files{folder_ / "state.json"};
  for (const fs::directory_entry& entry : fs::directory_iterator(folder_, error))
    if (entry.path().extension() == ".f32") files.push_back(entry.path());
  for (const fs::path& file : files)
    if (!error) fs::remove(file, error);
  return error ? folder_.string() + " cannot be emptied: " + error.message() + ". Choose another folder with -o." : "";
}

std::string StudyStore::add(StoredRender render, const Image& image, const Image& denoised) {
  const auto write_picture = [&](const Image& picture, const char* ending, std::string* file, std::string* sum) {
    const size_t size = picture.rgb.size() * sizeof(float);
    *file = file_name(render, ending);
    *sum = checksum(picture.rgb.data(), size);
    return write(folder_ / *file, picture.rgb.data(), size);
  };
  std::string problem = write_picture(image, ".f32", &render.file, &render.checksum);
  if (problem.empty() && !denoised.rgb.empty())
    problem = write_picture(denoised, ".denoised.f32", &render.denoised_file, &render.denoised_checksum);
  if (!problem.empty()) return problem;
  renders_.push_back(std::move(render));
  spent += renders_.back().cost.total_seconds;
  problem = save();
  if (problem.empty()) return "";
  spent -= renders_.back().cost.total_seconds;
  std::error_code ignored;
  for (const std::string& file : {renders_.back().file, renders_.back().denoised_file})
    if (!file.empty()) fs::remove(folder_ / file, ignored);
  renders_.pop_back();
  return problem;
}

std::string StudyStore::save() const {
  json state{{"format", kFormat},       {"scene", identity.scene},       {"sceneHash", identity.scene_hash},
             {"width", identity.width}, {"height", identity.height},     {"referenceSamples", reference_samples},
             {"spentSeconds", spent},   {"versions", identity.versions}, {"renders", json::array()}};
  for (const StoredRender& render : renders_) state["renders"].push_back(to_json(render));
  const std::string text = state.dump(1, ' ', false, json::error_handler_t::replace) + "\n";
  return write(folder_ / "state.json", text.data(), text.size());
}

std::optional<Image> StudyStore::read(const std::string& name, const std::string& expected_checksum) const {
  if (name.empty() || fs::path(name).has_parent_path()) return std::nullopt;  // state.json may have been edited
  const InputFile file(folder_ / name);
  Image image{identity.width, identity.height, {}};
  const size_t size = 3 * image.pixels() * sizeof(float);
  if (!file || file.size() != size) return std::nullopt;
  image.rgb.resize(3 * image.pixels());
  if (!file.read(0, image.rgb.data(), size)) return std::nullopt;
  if (checksum(image.rgb.data(), size) != expected_checksum) return std::nullopt;
  return image;
}

}  // namespace alabaster::tradeoff
