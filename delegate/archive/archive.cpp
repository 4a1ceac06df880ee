#include "delegate/archive/archive.h"

#include <algorithm>
#include <filesystem>
#include <set>

#include "core/digest/digest.h"
#include "core/files/input_file.h"
#include "core/files/real_path.h"
#include "core/memory/memory_budget.h"
#include "core/texture/udim.h"
#include "delegate/archive/tensors.h"
#include "delegate/host/scene_fields.h"
#include "delegate/support/output_file.h"

namespace alabaster::hd::archive {
namespace {

using nlohmann::json;
constexpr const char* kFormat = "alabaster scene";
constexpr const char* kScene = "scene.json";

std::string digest_of(const std::vector<uint8_t>& bytes) {
  Digest digest;
  digest.add(bytes);
  return digest.text();
}

/// The digest of all images of a set, with their places. hold(file, size) takes memory for one.
template <class Hold>
std::string digest_of(const std::vector<UdimTile>& tiles, const std::string& within, const Hold& hold) {
  Digest digest;
  for (const UdimTile& tile : tiles) {
    std::vector<uint8_t> bytes;
    const InputFile file(tile.path, within);
    [[maybe_unused]] const auto held = hold(tile.path, file ? file.size() : 0);
    if (file && !file.read(&bytes)) bytes.clear();
    digest.add(tile.place.x), digest.add(tile.place.y), digest.add(bytes);
  }
  return digest.text();
}

// A value of JSON takes a node of the document.
constexpr size_t kValueBytes = 300;

/// OpenColorIO configs that are no files.
bool is_named_config(const std::string& config) {
  return config == "built-in" || config.starts_with("ocio://");
}

/// Names of files below `folder` are relative to it.
std::string name_from(const std::string& folder, const std::string& file) {
  const std::string below = folder + "/";
  return file.starts_with(below) ? file.substr(below.size()) : file;
}

class Writer {
 public:
  Writer(const std::string& file, const WriteOptions& options) : options_(options) {
    std::error_code error;
    const std::filesystem::path parent = std::filesystem::path(file).parent_path();
    folder_ = std::filesystem::weakly_canonical(parent.empty() ? "." : parent, error).string();
  }
  void add(const host::Prims& prims, const SceneInfo& info) {
    for (const auto& [path, prim] : prims) {
      const auto* settings = std::get_if<RenderSettingsDescription>(&prim);
      const Token kind = host::TypeOf(prim);
      if (!kind.empty()) add(path, kind, host::GetFields(path, settings ? with_own_files(*settings) : prim));
    }
    json scene = json::object();
    if (!info.settings.empty()) scene["settings"] = info.settings.str();
    if (is_named_config(info.color_config.resolved))
      scene["ocio"] = {{"authored", info.color_config.resolved}};
    else if (!info.color_config.resolved.empty())
      scene["ocio"] = asset(info.color_config, false);
    const std::string others = scene.dump();  // of the object, without its first brace
    const std::string text = "{\"prims\":[" + prims_ + "]" + (scene.empty() ? "" : ",") + others.substr(1);
    tensors_.add_bytes(std::make_shared<const std::vector<uint8_t>>(text.begin(), text.end()), kScene);
  }
  std::string write(const std::string& file) {
    const std::string header = tensors_.header(kFormat, kVersion);
    if (!outside_.empty() && options_.sink)
      options_.sink({Severity::info, "archive.outside", file,
                     "It names files outside of its folder, such as " + outside_ +
                         ": read it with --allow-outside (hosts: option allow_outside), or store its images in it "
                         "(convert --embed)."});
    return support::StreamOutputFile(file, [&](const support::ByteSink& sink) {
      if (!sink({reinterpret_cast<const uint8_t*>(header.data()), header.size()})) return false;
      for (const std::span<const uint8_t> bytes : tensors_.order())
        if (!sink(bytes)) return false;
      return true;
    });
  }

 private:
  // Products that a description names beside itself are written beside the archive.
  static host::PrimDescription with_own_files(RenderSettingsDescription settings) {
    for (RenderProduct& product : settings.products) {
      std::error_code error;
      const auto file = std::filesystem::weakly_canonical(product.file, error);
      if (!product.within.empty() && !error) product.file = name_from(product.within, file.string());
    }
    return settings;
  }
  // A prim that SetPrim refuses would make the archive unreadable.
  void add(const Path& path, const Token& kind, const host::Fields& fields) {
    host::RetainedSceneDelegate scratch;
    const host::SetResult set = SetPrim(&scratch, path, kind, fields);
    if (!set.fault.empty()) throw Fault(path.str() + ": " + set.fault);
    json written = json::array();
    for (const auto& [name, value] : fields) {
      try {
        written.push_back({name, write_value(value, &tensors_,
                                             [this](const AssetPath& a) { return asset(a, options_.embed_images); })});
      } catch (const Fault& fault) {
        throw Fault(path.str() + ": '" + name + "': " + fault.what());
      }
    }
    const json prim = {{"path", path.str()}, {"kind", kind.str()}, {"fields", std::move(written)}};
    try {
      prims_ += (prims_.empty() ? "" : ",") + prim.dump();
    } catch (const json::exception&) {
      throw Fault(path.str() + " has a text that is not UTF-8, as texts in files are");
    }
  }
  json asset(const AssetPath& path, bool embeds) {
    json written = {{"authored", path.authored}};
    std::shared_ptr<const std::vector<uint8_t>> bytes = path.bytes;
    const bool is_file = !bytes && !path.resolved.empty();
    if (is_file) {
      const auto read = std::make_shared<std::vector<uint8_t>>();
      const InputFile file(path.resolved, path.within);
      if (file && file.read(read.get())) bytes = read;
      std::error_code error;
      const std::string name = name_from(folder_, std::filesystem::weakly_canonical(path.resolved, error).string());
      if (name.starts_with('/') && !embeds) outside_ = name;
      written["file"] = name;
    }
    if (!bytes && is_file && embeds)
      throw Fault(path.resolved + " is not stored: it cannot be read, or names a set of images");
    if (!path.fault.empty()) written["fault"] = path.fault;
    if (const auto tiles = udim_tiles(path.resolved); is_file && !bytes && !tiles.empty())
      written["digest"] = digest_of(tiles, path.within, [](const auto&, uint64_t size) { return size; });
    if (!bytes) return written;
    written["digest"] = digest_of(*bytes);
    if (is_file && !embeds) return written;
    // The same image of several materials is stored once.
    std::string& name = images_[written["digest"]];
    if (name.empty()) name = tensors_.add_bytes(bytes);
    written["bytes"] = name;
    return written;
  }

  const WriteOptions& options_;
  std::string folder_, outside_;  // outside_: a file that readers refuse without allow_outside
  std::string prims_;             // JSON, separated by commas
  TensorWriter tensors_;
  std::map<std::string, std::string> images_;  // digest -> tensor
};

class Reader {
 public:
  Reader(const std::string& file, const DiagnosticSink& sink, const ReadOptions& options)
      : file_(file),
        sink_(sink),
        options_(options),
        folder_(std::filesystem::path(file).parent_path().string()),
        memory_(std::make_shared<MemoryBudget>(options.memory_limit)),
        held_(memory_, MemoryUse::scene) {
    if (folder_.empty()) folder_ = ".";
    if (!options.allow_outside) within_ = allowed_folder(folder_);
  }
  void read(host::RetainedSceneDelegate* scene, ReadResult* result) {
    const InputFile input(file_, options_.within);
    if (!input) throw Fault(input.reason());
    held_.resize(input.size(), file_);
    const auto bytes = std::make_shared<std::vector<uint8_t>>();
    if (!input.read(bytes.get())) throw Fault("the file could not be read");
    const MemoryReservation header = for_json(TensorReader::header_of(*bytes));
    const TensorReader tensors(bytes);
    check_version(tensors.metadata());
    const std::span<const uint8_t> text = tensors.bytes(kScene);
    check_depth(text);
    const MemoryReservation parsed = for_json(text);
    const json root = json::parse(text.begin(), text.end(), nullptr, false);
    if (root.is_discarded()) throw Fault("tensor 'scene.json' is not JSON");
    if (!root.is_object() || !root.contains("prims") || !root["prims"].is_array())
      throw Fault("tensor 'scene.json' has no list of prims");
    for (const json& prim : root["prims"]) read_prim(prim, tensors, scene);
    if (root.contains("ocio")) result->info.color_config = color_config(root["ocio"], tensors);
    if (const auto settings = root.find("settings"); settings != root.end() && settings->is_string())
      result->info.settings = Path(options_.root + settings->get<std::string>());
    result->memory_bytes = held_.bytes();
    result->ok = true;
  }

 private:
  MemoryReservation for_json(std::span<const uint8_t> text) const {
    const auto values =
        std::count_if(text.begin(), text.end(), [](uint8_t c) { return c == ',' || c == '[' || c == '{'; });
    return {memory_, MemoryUse::scene, text.size() + size_t(values) * kValueBytes, file_ + ": its list of prims"};
  }
  // With the root before a path, and before the paths in names: "prototypes:/mesh", "/material/node.input".
  std::string placed(const std::string& path) const { return path.starts_with('/') ? options_.root + path : path; }
  std::string placed_name(const std::string& name) const {
    constexpr std::string_view kPrototypes = "prototypes:", kCategories = "categories:";
    if (name.starts_with(kPrototypes)) return std::string(kPrototypes) + placed(name.substr(kPrototypes.size()));
    if (name.starts_with(kCategories) && !options_.root.empty())
      return std::string(kCategories) + options_.root + " " + name.substr(kCategories.size());
    return placed(name);
  }
  // With the root before the categories that light links name, which are of this scene.
  Value placed_categories(const std::string& name, Value value) const {
    if (options_.root.empty()) return value;
    if (name == "lightLink" || name == "shadowLink") return Token(options_.root + " " + value.text_or(""));
    const auto* all = value.get<Array<Token>>();
    if (name != "categories" || !all) return value;
    std::vector<Token> categories;
    for (const Token& category : *all) categories.emplace_back(options_.root + " " + category.str());
    return categories;
  }
  Value placed(Value value) const {
    if (const auto* path = value.get<Path>()) return Path(placed(path->str()));
    const auto* all = value.get<Array<Path>>();
    if (!all) return value;
    std::vector<Path> paths;
    for (const Path& path : *all) paths.emplace_back(placed(path.str()));
    return paths;
  }
  static void check_version(const json& metadata) {
    const auto text = [&](const char* key) {
      return metadata.is_object() && metadata.contains(key) && metadata[key].is_string()
                 ? metadata[key].get<std::string>()
                 : std::string();
    };
    if (text("format") != kFormat) throw Fault("the file is no scene archive of Alabaster");
    const std::string version = text("version");
    const bool is_number = !version.empty() && version.find_first_not_of("0123456789") == std::string::npos;
    if (!is_number || version.size() > 9 || std::stoi(version) < 1)
      throw Fault("the archive's version is not a number from 1");
    if (std::stoi(version) > kVersion)
      throw Fault("the archive has version " + version + ", and this program reads up to version " +
                  std::to_string(kVersion) + ": use the program that wrote it, or a newer one");
  }
  void read_prim(const json& prim, const TensorReader& tensors, host::RetainedSceneDelegate* scene) {
    const auto text = [&](const char* key) {
      if (!prim.is_object() || !prim.contains(key) || !prim[key].is_string())
        throw Fault(std::string("a prim has no ") + key);
      return prim[key].get<std::string>();
    };
    const std::string path = text("path");
    if (path.find('\0') != std::string::npos) throw Fault("a path holds a zero character");
    if (!paths_.insert(path).second) throw Fault("two prims have the path " + path);
    host::Fields fields;
    if (!prim.contains("fields") || !prim["fields"].is_array()) throw Fault(path + " has no fields");
    for (const json& field : prim["fields"]) {
      if (!field.is_array() || field.size() != 2 || !field[0].is_string()) throw Fault(path + " has a wrong field");
      try {
        Value value = read_value(field[1], tensors, [&](const json& a) { return asset(a, tensors); });
        const auto& name = field[0].get_ref<const std::string&>();
        fields.emplace_back(placed_name(name), placed_categories(name, placed(std::move(value))));
      } catch (const Fault& fault) {
        throw Fault(path + ": '" + field[0].get<std::string>() + "': " + fault.what());
      }
    }
    const Path id(placed(path));
    const host::SetResult result = SetPrim(scene, id, Token(text("kind")), fields);
    if (!result.fault.empty()) throw Fault(path + ": " + result.fault);
    if (const auto* settings = host::FindPrim<RenderSettingsDescription>(scene->GetPrims(), id))
      scene->Set(id, with_placed_products(*settings));
  }
  std::string resolved(const std::string& name) const {
    const std::string file = (std::filesystem::path(folder_) / name).lexically_normal();
    const std::string fault = within_.empty() ? "" : outside_fault(within_, file);
    if (!fault.empty()) throw Fault(fault);
    return file;
  }
  RenderSettingsDescription with_placed_products(RenderSettingsDescription settings) const {
    for (RenderProduct& product : settings.products) product.file = resolved(product.file), product.within = within_;
    return settings;
  }
  AssetPath color_config(const json& given, const TensorReader& tensors) {
    AssetPath config = asset(given, tensors);
    if (config.resolved.empty() && is_named_config(config.authored)) config.resolved = config.authored;
    return config;
  }
  AssetPath asset(const json& given, const TensorReader& tensors) {
    const auto text = [&](const char* key) {
      const auto found = given.is_object() ? given.find(key) : given.end();
      if (!given.is_object() || (found != given.end() && !found->is_string())) throw Fault("a file has no name");
      return found == given.end() ? std::string() : found->get<std::string>();
    };
    AssetPath path;
    path.authored = text("authored");
    if (const std::string name = text("bytes"); !name.empty()) {
      auto& stored = stored_[name];
      if (!stored) {
        const std::span<const uint8_t> bytes = tensors.bytes(name);
        held_.resize(held_.bytes() + bytes.size(), file_ + ": " + path.authored);
        stored = std::make_shared<const std::vector<uint8_t>>(bytes.begin(), bytes.end());
      }
      path.bytes = stored;
      return path;
    }
    const std::string name = text("file");
    path.fault = text("fault");
    if (name.empty()) return path;
    path.resolved = resolved(name);
    path.within = within_;
    check_digest(path, text("digest"));
    return path;
  }
  void check_digest(const AssetPath& path, const std::string& digest) {
    if (digest.empty() || !sink_ || !compared_.insert({path.resolved, digest}).second) return;
    const auto hold = [this](const std::string& file, uint64_t size) {
      return MemoryReservation(memory_, MemoryUse::scene, size, file);
    };
    if (const auto tiles = udim_tiles(path.resolved); !tiles.empty()) {
      if (digest_of(tiles, path.within, hold) == digest) return;
    } else {
      std::vector<uint8_t> bytes;
      const InputFile file(path.resolved, path.within);
      const MemoryReservation read = hold(path.resolved, file ? file.size() : 0);
      if (!file || !file.read(&bytes) || digest_of(bytes) == digest) return;
    }
    sink_({Severity::warning, "archive.image", file_ + ": " + path.resolved,
           "The file has changed since the archive was written. Images can be stored in it (convert --embed)."});
  }

  std::string file_;
  const DiagnosticSink& sink_;
  const ReadOptions& options_;
  std::string folder_, within_;
  std::shared_ptr<MemoryBudget> memory_;
  MemoryReservation held_;  // the file, over which arrays lie, and copies of what is stored in it
  std::map<std::string, std::shared_ptr<const std::vector<uint8_t>>> stored_;  // by tensor
  std::set<std::pair<std::string, std::string>> compared_;                     // files and digests
  std::set<std::string> paths_;
};

}  // namespace

std::string WriteArchive(const std::string& file, const host::Prims& prims, const SceneInfo& info,
                         const WriteOptions& options) {
  try {
    if (!file.ends_with(".alab")) return "'" + file + "' must end in .alab";
    if (const std::string fault = support::OutputFault(file); !fault.empty()) return fault;
    Writer writer(file, options);
    writer.add(prims, info);
    return writer.write(file);
  } catch (const std::bad_alloc&) {
    return "memory ran out";
  } catch (const Fault& fault) {
    return fault.what();
  } catch (const std::exception& e) {
    return std::string("the scene cannot be written: ") + e.what();
  }
}

ReadResult ReadArchive(const std::string& file, host::RetainedSceneDelegate* scene, const DiagnosticSink& sink,
                       const ReadOptions& options) {
  ReadResult result;
  const auto fail = [&](const char* code, const char* text) {
    if (sink) sink({Severity::error, code, file, text});
  };
  try {
    Reader(file, sink, options).read(scene, &result);
  } catch (const Fault& fault) {
    fail("archive", fault.what());
  } catch (const MemoryRefused& refused) {
    result.out_of_memory = true;
    fail("archive.memory", refused.what());
  } catch (const std::bad_alloc&) {
    result.out_of_memory = true;
    fail("archive.memory", "Not enough memory to read the archive.");
  } catch (const std::exception& e) {
    fail("archive", e.what());
  }
  return result;
}

}  // namespace alabaster::hd::archive
