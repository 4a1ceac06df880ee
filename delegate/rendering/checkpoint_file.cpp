#include "delegate/rendering/checkpoint_file.h"

#include <algorithm>
#include <charconv>
#include <cstring>
#include <utility>

#include "core/digest/digest.h"
#include "core/integrator/path_integrator.h"
#include "delegate/api/render_delegate.h"
#include "delegate/prims/scene_digest.h"
#include "delegate/support/json_bounds.h"
#include "delegate/support/output_file.h"
#include "delegate/support/parameters.h"
#include "delegate/support/size_text.h"

namespace alabaster::hd::rendering {
namespace {

using nlohmann::json;

// The number rises whenever the state or the header changes its meaning.
constexpr std::string_view kMagic = "Alabaster checkpoint 9\n", kAnyMagic = "Alabaster checkpoint ";

struct BlockHead {
  uint64_t size = 0, checksum = 0;
};

/// The number of samples decides pixels only where they are allocated or ended by noise.
bool is_compared(const SettingParameter& setting, const RenderSettings& settings) {
  if (setting.name == std::string_view("samples")) return settings.adaptive || settings.target_error > 0;
  return (setting.of & setting_use::kNoPixels) == 0;
}

json library_versions() {
  json versions = json::object();
  std::istringstream lines(AlabasterVersions());
  for (std::string line; std::getline(lines, line);) {
    const size_t space = line.find(' ');
    versions[space == std::string::npos ? "Alabaster" : line.substr(0, space)] =
        space == std::string::npos ? line : line.substr(space + 1);
  }
  versions["sampling"] = std::to_string(kSamplingVersion);
  return versions;
}

std::string aov_names(const RenderRequest& request) {
  const AovSet aovs = with_guides(request.aovs);
  std::string names;
  for (const AovInfo& info : kAovs)
    if (info.aov != Aov::light_group && (aovs & aov_bit(info.aov)))
      names += (names.empty() ? "" : ", ") + std::string(info.name);
  for (const UvSetName& primvar : request.primvars)
    names += (names.empty() ? "" : ", ") + (kPrimvarAov.name + primvar.text());
  for (const std::string& group : request.light_groups)
    names += (names.empty() ? "" : ", ") + (aov_info(Aov::light_group).name + group);
  return names;
}

/// Lists differences, a few of them by name.
class Differences {
 public:
  void add(const std::string& text) {
    constexpr int kNamed = 3;
    if (++count_ <= kNamed) text_ += (text_.empty() ? "" : "; ") + text;
  }
  std::string text() const {
    return count_ > 3 ? text_ + "; and " + std::to_string(count_ - 3) + " more differences" : text_;
  }

 private:
  int count_ = 0;
  std::string text_;
};

/// Calls different(name, text in a, text in b), null where one lacks the name, for what differs between two objects.
template <class Different>
void compare(const json& a, const json& b, const Different& different) {
  static const json kNone = json::object();
  const json &left = a.is_object() ? a : kNone, &right = b.is_object() ? b : kNone;
  const auto text_in = [](const json& object, const std::string& name) {
    const auto found = object.find(name);
    return found != object.end() && found->is_string() ? found->get_ptr<const std::string*>() : nullptr;
  };
  std::set<std::string> names;
  for (const json* object : {&left, &right})
    for (const auto& [name, value] : object->items()) names.insert(name);
  for (const std::string& name : names) {
    const std::string *l = text_in(left, name), *r = text_in(right, name);
    if (!l || !r || *l != *r) different(name, l, r);
  }
}

std::string text_of_header(const json& header) {
  return header.dump(-1, ' ', false, json::error_handler_t::replace);
}

const json& member(const json& header, const char* name) {
  static const json kNone;
  const auto found = header.find(name);
  return found == header.end() ? kNone : *found;
}

std::string text_of(const json& value) {
  return value.is_string() ? value.get<std::string>() : std::string("none");
}

std::string was_and_is(const std::string& what, const std::string* was, const std::string* is) {
  return what + " was " + (was ? *was : "not known") + " and is " + (is ? *is : "not known");
}

constexpr size_t kMostHeaderBytes = size_t(64) << 20;  // a scene has some hundred bytes for each of its prims
constexpr size_t kDigestBytes = 32;                    // of text: core/digest/digest.h
constexpr std::pair<const char*, json::value_t> kMembers[] = {
    {"library", json::value_t::object},  {"scene", json::value_t::object},  {"frame", json::value_t::object},
    {"settings", json::value_t::object}, {"names", json::value_t::object},  {"aovs", json::value_t::string},
    {"note", json::value_t::string},     {"samples", json::value_t::array}, {"complete", json::value_t::boolean}};

/// The members of an object, or the numbers of `samples`. Each of a scene's many names has a digest.
bool are_parts(const json& parts, bool of_scene) {
  constexpr size_t kMostNamed = 1000;
  if (!of_scene && parts.size() > (parts.is_array() ? 2 : kMostNamed)) return false;
  return std::all_of(parts.begin(), parts.end(), [&](const json& part) {
    if (parts.is_array()) return part.is_number_unsigned();
    return part.is_string() && (!of_scene || part.get_ref<const std::string&>().size() == kDigestBytes);
  });
}

bool is_header(const json& header) {
  if (!header.is_object()) return false;
  for (const auto& [name, value] : header.items()) {
    const auto* known = std::find_if(std::begin(kMembers), std::end(kMembers),
                                     [&member = name](const auto& one) { return member == one.first; });
    if (known == std::end(kMembers) || value.type() != known->second) return false;
    if (name == "note" && value.get_ref<const std::string&>().size() > kMostNoteBytes) return false;
    if (value.is_structured() && name != "names" && !are_parts(value, name == "scene")) return false;
  }
  return true;
}

/// Parses a header without trust: as any JSON, a hostile text takes gigabytes. `held` holds what is made
/// (MemoryRefused). Null if the text holds anything that no header has.
json parse_header(std::string_view text, MemoryReservation* held) {
  constexpr size_t kMostDepth = 2, kMemberBytes = 256, kUncounted = size_t(1) << 16;
  const support::JsonBounds bounds = support::bounds_of_json(text, kMostDepth);
  if (bounds.too_deep_at != std::string_view::npos || bounds.containers > std::size(kMembers)) return nullptr;
  const size_t bytes = text.size() + bounds.values * kMemberBytes;
  if (bytes > kUncounted) held->resize(bytes, "the header of a checkpoint");
  json header = json::parse(text.begin(), text.end(), nullptr, false);
  return is_header(header) ? std::move(header) : json();
}

// The members of names, by their kinds.
constexpr struct {
  const char* kind;
  prims::NamesById prims::IdNames::*names;
} kNames[] = {{"primId ", &prims::IdNames::prims},
              {"object ", &prims::IdNames::objects},
              {"asset ", &prims::IdNames::assets},
              {"materialId ", &prims::IdNames::materials}};
constexpr const char* kInstances = "instances ";  // members of names, too
constexpr const char* kLightGroup = "lightGroup ";

/// The number that a text ends with, from `begin` on; -1: none.
int32_t number_at(const std::string& text, size_t begin) {
  int32_t number = -1;
  std::from_chars(text.data() + begin, text.data() + text.size(), number);
  return number;
}

}  // namespace

prims::IdNames names_of(const CheckpointHeader& header) {
  constexpr int32_t kMostId = 1 << 24;
  prims::IdNames all;
  uint32_t instances = 0;
  for (const auto& [key, name] : member(header, "names").items()) {
    if (!name.is_string()) continue;
    for (const auto& [kind, names] : kNames) {
      const int32_t id = key.starts_with(kind) ? number_at(key, std::strlen(kind)) : -1;
      if (id >= 0 && id < kMostId) (all.*names)[id] = name.get<std::string>();
    }
    if (!key.starts_with(kInstances)) continue;
    const int32_t id = number_at(key, std::strlen(kInstances)), count = number_at(name.get<std::string>(), 0);
    if (id < 0 || count <= 0 || static_cast<uint32_t>(count) > prims::kMostInstanceMattes - instances) continue;
    instances += all.instances[id] = static_cast<uint32_t>(count);
  }
  for (size_t i = 0; i < kMostLightGroups; ++i)
    if (const std::string key = kLightGroup + std::to_string(i); member(header, "names").contains(key))
      all.light_groups.push_back(text_of(member(header, "names")[key]));
  prims::number_mattes(&all);
  return all;
}

CheckpointHeader checkpoint_header(const RenderRequest& request, const std::map<std::string, std::string>& scene,
                                   const prims::IdNames* names) {
  CheckpointHeader header;
  header["library"] = library_versions();
  header["scene"] = scene;
  header["scene"]["the camera"] = prims::digest_camera(request.camera);
  const PixelRect& window = request.data_window;
  header["frame"] = {{"size", support::size_text(request.width, request.height)},
                     {"data window", std::to_string(window.x0) + "," + std::to_string(window.y0) + "," +
                                         std::to_string(window.x1) + "," + std::to_string(window.y1)}};
  header["aovs"] = aov_names(request);
  json& settings = header["settings"] = json::object();
  for (const SettingParameter& parameter : setting_parameters())
    if (is_compared(parameter, request.settings)) {
      const Value value = support::get_parameter(parameter, request.settings);
      settings[parameter.name] = value.text_or(value.to_string());
    }
  if (names) {
    for (const auto& [kind, of_kind] : kNames)
      for (const auto& [id, name] : names->*of_kind) header["names"][kind + std::to_string(id)] = name;
    for (const auto& [id, count] : names->instances)
      header["names"][kInstances + std::to_string(id)] = std::to_string(count);
  }
  for (size_t i = 0; i < request.light_groups.size(); ++i)
    header["names"][kLightGroup + std::to_string(i)] = request.light_groups[i];
  // As a file gives it back: names that are not UTF-8 do not survive JSON.
  return json::parse(text_of_header(header));
}

std::string checkpoint_difference(const CheckpointHeader& file, const CheckpointHeader& render) {
  Differences all;
  compare(member(file, "library"), member(render, "library"),
          [&](const std::string& name, const std::string* was, const std::string* is) {
            all.add(was_and_is("the version of " + name, was, is));
          });
  compare(member(file, "frame"), member(render, "frame"),
          [&](const std::string& name, const std::string* was, const std::string* is) {
            all.add(was_and_is("the " + name + (name == "size" ? " of the frame" : ""), was, is));
          });
  if (const std::string was = text_of(member(file, "aovs")), is = text_of(member(render, "aovs")); was != is)
    all.add("the AOVs were " + was + " and are " + is);
  compare(member(file, "settings"), member(render, "settings"),
          [&](const std::string& name, const std::string* was, const std::string* is) {
            all.add(was_and_is("setting " + name, was, is));
          });
  compare(member(file, "scene"), member(render, "scene"),
          [&](const std::string& name, const std::string* was, const std::string* is) {
            all.add(name + (!was ? " is new" : !is ? " is gone" : " has changed"));
          });
  compare(member(file, "names"), member(render, "names"),
          [&](const std::string& id, const std::string* was, const std::string* is) {
            all.add(was_and_is(id.starts_with(kInstances)
                                   ? "the number of mattes of prim" + id.substr(std::strlen(kInstances) - 1)
                                   : "the name of " + id,
                               was, is));
          });
  return all.text();
}

std::string write_checkpoint(const std::string& file, const CheckpointHeader& header,
                             const std::function<bool(const BlockSink&)>& write) {
  const auto bytes = [](const auto* data, size_t size) {
    return std::span(reinterpret_cast<const uint8_t*>(data), size);
  };
  return support::StreamOutputFile(file, [&](const support::ByteSink& sink) {
    uint64_t number = 0;
    const auto put = [&](std::span<const std::byte> block) {
      const BlockHead head{block.size(), checksum(block, number++)};
      return sink(bytes(&head, sizeof head)) && sink(bytes(block.data(), block.size()));
    };
    const std::string text = text_of_header(header);
    return sink(bytes(kMagic.data(), kMagic.size())) && put(std::as_bytes(std::span(text))) && write(put) && put({});
  });
}

CheckpointReader::CheckpointReader(const std::string& file, const std::shared_ptr<MemoryBudget>& memory)
    : file_(file), held_(memory, MemoryUse::frames), header_(json::object()) {
  if (!file_) {
    fault_ = file_.fault() == InputFile::Fault::missing ? "there is no such file" : file_.reason();
    return;
  }
  left_ = file_.size();
  read_header();
}

bool CheckpointReader::fail(const std::string& fault) {
  if (fault_.empty()) fault_ = fault;
  return false;
}

bool CheckpointReader::read_header() {
  std::string magic(std::min(kMagic.size(), left_), ' ');
  if (!take(magic.data(), magic.size())) return false;
  if (!magic.starts_with(kAnyMagic)) return fail("it is not a checkpoint");
  if (magic != kMagic) return fail("it is a checkpoint of another version of Alabaster, in another format");
  std::vector<std::byte> block;
  if (!next(kMostHeaderBytes, &block)) return false;
  json parsed = parse_header({reinterpret_cast<const char*>(block.data()), block.size()}, &held_);
  if (!parsed.is_object()) return fail("it is damaged: its header does not describe a render");
  header_ = std::move(parsed);
  return true;
}

bool CheckpointReader::take(void* out, size_t size) {
  if (!file_.read(file_.size() - left_, out, size)) return fail("it cannot be read");
  left_ -= size;
  return true;
}

bool CheckpointReader::next(size_t most, std::vector<std::byte>* block) {
  BlockHead head;
  if (!fault_.empty()) return false;
  if (left_ < sizeof head) return fail("it is damaged: it ends too early");
  if (!take(&head, sizeof head)) return false;
  if (head.size > left_) return fail("it is damaged: it ends too early");
  if (head.size > most) return fail("it is damaged: block " + std::to_string(number_) + " is too large");
  block->resize(head.size);
  if (!take(block->data(), block->size())) return false;
  if (checksum(*block, number_) != head.checksum)
    return fail("it is damaged: the checksum of block " + std::to_string(number_) + " is wrong");
  ++number_;
  return true;
}

BlockSource CheckpointReader::source() {
  return [this](size_t most, std::vector<std::byte>* block) { return next(most, block); };
}

void CheckpointReader::finish(bool read) {
  std::vector<std::byte> last;
  if (!read)
    fail("it is damaged: block " + std::to_string(number_) + " does not hold what it should");
  else if (next(0, &last) && left_ > 0)
    fail("it is damaged: there is more after its end");
}

}  // namespace alabaster::hd::rendering
