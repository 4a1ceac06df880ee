#include "delegate/archive/archive.h"

#include <fcntl.h>
#include <sys/mman.h>
#include <sys/stat.h>

#include <algorithm>
#include <cmath>
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
#include "delegate/support/process_usage.h"

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
      const auto name = info.names.find(path);
      if (!kind.empty())
        add(path, kind, name == info.names.end() ? std::string() : name->second,
            host::GetFields(path, settings ? with_own_files(*settings) : prim));
    }
    json scene = json::object();
    if (!(info.up == Token("Y"))) scene["upAxis"] = info.up.str();
    if (info.metersPerUnit != 1) scene["metersPerUnit"] = info.metersPerUnit;
    if (info.timeCodesPerSecond != 0) scene["timeCodesPerSecond"] = info.timeCodesPerSecond;
    if (info.range) scene["range"] = *info.range;
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
  void add(const Path& path, const Token& kind, const std::string& name, const host::Fields& fields) {
    host::RetainedSceneDelegate scratch;
    const host::SetResult set = SetPrim(&scratch, path, kind, fields);
    if (!set.fault.empty()) throw Fault(path.str() + ": " + set.fault);
    json written = json::array();
    for (const auto& [field, value] : fields) {
      try {
        written.push_back({field, write_value(value, &tensors_,
                                              [this](const AssetPath& a) { return asset(a, options_.embed_images); })});
      } catch (const Fault& fault) {
        throw Fault(path.str() + ": '" + field + "': " + fault.what());
      }
    }
    json prim = {{"path", path.str()}, {"kind", kind.str()}, {"fields", std::move(written)}};
    if (!name.empty()) prim["name"] = name;
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

// The last part of a path, or before it, without the number that glTF's reader puts before a name.
std::string former_name(const std::string& path, bool is_mesh) {
  std::string name = path.substr(0, is_mesh ? path.rfind('/') : path.size());
  name.erase(0, name.rfind('/') + 1);
  const size_t digits = name.find_first_not_of("0123456789");
  return digits == 0 || digits == std::string::npos || name[digits] != '_' ? name : name.substr(digits + 1);
}

// Memory of another process, which it has given up the means to change: reading it cannot fail.
FileBytes map_sealed(int descriptor) {
  constexpr int kSeals = F_SEAL_SHRINK | F_SEAL_GROW | F_SEAL_WRITE | F_SEAL_SEAL;
  const int seals = fcntl(descriptor, F_GET_SEALS);
  struct stat status {};
  if (seals < 0 || (seals & kSeals) != kSeals || fstat(descriptor, &status) != 0)
    throw Fault(
        "the memory is not sealed against shrinking, growing, writing and further seals: add these (F_ADD_SEALS) to a "
        "memfd_create once it is written");
  const auto size = static_cast<size_t>(status.st_size);
  if (size == 0) return {};  // an error follows: it is too short
  void* const data = mmap(nullptr, size, PROT_READ, MAP_PRIVATE, descriptor, 0);
  if (data == MAP_FAILED) throw std::bad_alloc();
  const std::shared_ptr<const void> owner(data,
                                          [size](const void* mapped) { munmap(const_cast<void*>(mapped), size); });
  return {owner, {static_cast<const uint8_t*>(data), size}};
}

class Reader {
 public:
  /// `folder`: where relative names begin.
  Reader(const std::string& file, std::string folder, const DiagnosticSink& sink, const ReadOptions& options)
      : file_(file),
        sink_(sink),
        options_(options),
        folder_(std::move(folder)),
        folders_(options.folders),
        memory_(std::make_shared<MemoryBudget>(options.memory_limit)),
        held_(memory_, MemoryUse::scene) {}
  void read(host::SceneEdits* edits, ReadResult* result) {
    if (folder_.empty()) folder_ = ".";
    folders_ = {allowed_folder(folder_)};
    const InputFile input(file_, options_.within);
    if (!input) throw Fault(input.reason());
    held_.resize(input.size(), file_);
    const auto bytes = std::make_shared<std::vector<uint8_t>>();
    if (!input.read(bytes.get())) throw Fault("the file could not be read");
    read({bytes, *bytes}, edits, result);
  }
  void read_sealed(int descriptor, host::SceneEdits* edits, ReadResult* result) {
    const FileBytes bytes = map_sealed(descriptor);
    held_.resize(bytes.all.size(), file_);
    read(bytes, edits, result);
  }

 private:
  void read(const FileBytes& bytes, host::SceneEdits* edits, ReadResult* result) {
    const MemoryReservation header = for_json(TensorReader::header_of(bytes.all));
    const TensorReader tensors(bytes);
    version_ = checked_version(tensors.metadata());
    const std::span<const uint8_t> text = tensors.bytes(kScene);
    check_depth(text);
    const MemoryReservation parsed = for_json(text);
    const json root = json::parse(text.begin(), text.end(), nullptr, false);
    if (root.is_discarded()) throw Fault("tensor 'scene.json' is not JSON");
    if (!root.is_object() || !root.contains("prims") || !root["prims"].is_array())
      throw Fault("tensor 'scene.json' has no list of prims");
    for (const json& prim : root["prims"]) read_prim(prim, tensors, edits);
    if (root.contains("removed")) read_removed(root["removed"], edits);
    if (root.contains("ocio")) result->info.color_config = color_config(root["ocio"], tensors);
    read_info(root, &result->info);
    result->info.names = edits->names;
    result->memory_bytes = held_.bytes();
    result->ok = true;
  }
  void read_removed(const json& removed, host::SceneEdits* edits) const {
    if (!options_.is_answer)
      throw Fault("it has a list of removed prims, as only the answers of a reader that follows time have");
    if (!removed.is_array()) throw Fault("the removed prims are no list");
    for (const json& path : removed) {
      if (!path.is_string()) throw Fault("a removed prim has no path");
      edits->removed.emplace_back(path.get<std::string>());
    }
  }
  static void read_info(const json& root, host::SceneInfo* info) {
    if (const auto settings = root.find("settings"); settings != root.end() && settings->is_string())
      info->settings = Path(settings->get<std::string>());
    if (root.contains("upAxis")) info->up = Token(root["upAxis"].is_string() ? root["upAxis"].get<std::string>() : "");
    if (!(info->up == Token("Y") || info->up == Token("Z")))
      throw Fault("its up axis is neither Y nor Z: write one of these as upAxis");
    const auto positive = [&](const char* name, double* number) {
      if (!root.contains(name)) return;
      *number = root[name].is_number() ? root[name].get<double>() : 0;
      if (!(*number > 0 && std::isfinite(*number)))
        throw Fault(std::string("its ") + name + " is no number above 0: write one, or leave it out");
    };
    positive("metersPerUnit", &info->metersPerUnit);
    positive("timeCodesPerSecond", &info->timeCodesPerSecond);
    const auto range = root.find("range");
    if (range == root.end()) return;
    if (!range->is_array() || range->size() != 2 || !(*range)[0].is_number() || !(*range)[1].is_number() ||
        !((*range)[0].get<double>() <= (*range)[1].get<double>()))
      throw Fault("its range is no pair of times in order: write the first and the last one, or leave it out");
    info->range = {(*range)[0].get<double>(), (*range)[1].get<double>()};
  }
  MemoryReservation for_json(std::span<const uint8_t> text) const {
    const auto values =
        std::count_if(text.begin(), text.end(), [](uint8_t c) { return c == ',' || c == '[' || c == '{'; });
    return {memory_, MemoryUse::scene, text.size() + size_t(values) * kValueBytes, file_ + ": its list of prims"};
  }
  static int checked_version(const json& metadata) {
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
    return std::stoi(version);
  }
  void read_prim(const json& prim, const TensorReader& tensors, host::SceneEdits* edits) {
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
        fields.emplace_back(field[0].get<std::string>(),
                            read_value(field[1], tensors, [&](const json& a) { return asset(a, tensors); }));
      } catch (const Fault& fault) {
        throw Fault(path + ": '" + field[0].get<std::string>() + "': " + fault.what());
      }
    }
    const Path id(path);
    if (options_.is_answer && !prim.contains("kind")) {
      for (const auto& [name, value] : fields)
        if (name.starts_with("products"))
          throw Fault(path + ": '" + name + "': products are not changed alone; set the prim whole, with its kind");
      edits->changes[id] = std::move(fields);
      return;
    }
    const host::SetResult result = SetPrim(&made_, id, Token(text("kind")), fields);
    if (!result.fault.empty()) throw Fault(path + ": " + result.fault);
    host::PrimDescription made = made_.GetPrims().at(id);
    made_.Remove(id);
    if (auto* settings = std::get_if<RenderSettingsDescription>(&made)) place_products(settings);
    const bool is_mesh = std::holds_alternative<host::MeshDescription>(made);
    std::string name = prim.contains("name") ? text("name") : version_ == 1 ? former_name(path, is_mesh) : "";
    edits->set(id, std::move(made), std::move(name));
  }
  // The file that is meant, and the folder that it must lie in.
  std::pair<std::string, std::string> resolved(const std::string& name) const {
    const std::string file = (std::filesystem::path(folder_) / name).lexically_normal();
    if (options_.allow_outside) return {file, std::string()};
    std::string fault = outside_text(file);
    for (const std::string& folder : folders_)
      if (fault = outside_fault(folder, file); fault.empty()) return {file, folder};
    throw Fault(fault);
  }
  void place_products(RenderSettingsDescription* settings) const {
    for (RenderProduct& product : settings->products) std::tie(product.file, product.within) = resolved(product.file);
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
    std::tie(path.resolved, path.within) = resolved(name);
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
  std::string folder_;
  std::vector<std::string> folders_;  // that its files lie in or below, unless outside is allowed
  int version_ = 0;
  host::RetainedSceneDelegate made_;
  std::shared_ptr<MemoryBudget> memory_;
  MemoryReservation held_;  // the file, over which arrays lie, and copies of what is stored in it
  std::map<std::string, std::shared_ptr<const std::vector<uint8_t>>> stored_;  // by tensor
  std::set<std::pair<std::string, std::string>> compared_;                     // files and digests
  std::set<std::string> paths_;
};

ReadResult read_guarded(const std::string& file, const DiagnosticSink& sink,
                        const std::function<void(ReadResult*)>& read) {
  ReadResult result;
  const auto fail = [&](const char* code, const char* text) {
    result.ok = false;
    if (sink) sink({Severity::error, code, file, text});
  };
  try {
    read(&result);
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

class ArchiveSource : public host::SceneSource {
 public:
  host::SourceFault Open(const std::string& file, const host::SourceOptions& options,
                         const DiagnosticSink& sink) override {
    const size_t limit = options.memory_limit ? options.memory_limit : support::default_memory_limit();
    const ReadResult read = ReadArchive(
        file, &edits_, sink, {.allow_outside = options.allow_outside, .within = options.within, .memory_limit = limit});
    static_cast<host::SceneInfo&>(facts_) = read.info;
    facts_.files = {file};
    facts_.is_complete = true;
    facts_.memory_bytes = read.memory_bytes;
    return read.ok              ? host::SourceFault::none
           : read.out_of_memory ? host::SourceFault::out_of_memory
                                : host::SourceFault::input;
  }
  const host::SceneFacts& Facts() const override { return facts_; }
  host::SourceFault Pose(std::optional<double>, const DiagnosticSink&, host::SceneEdits* edits) override {
    edits->prims.merge(edits_.prims);
    edits->names.merge(edits_.names);
    edits_ = {};
    return host::SourceFault::none;
  }

 private:
  host::SceneFacts facts_;
  host::SceneEdits edits_;  // until the first pose
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

ReadResult ReadArchive(const std::string& file, host::SceneEdits* edits, const DiagnosticSink& sink,
                       const ReadOptions& options) {
  return read_guarded(file, sink, [&](ReadResult* result) {
    Reader(file, std::filesystem::path(file).parent_path().string(), sink, options).read(edits, result);
  });
}

ReadResult ReadSealedArchive(int descriptor, const std::string& name, host::SceneEdits* edits,
                             const DiagnosticSink& sink, const ReadOptions& options) {
  return read_guarded(
      name, sink, [&](ReadResult* result) { Reader(name, "/", sink, options).read_sealed(descriptor, edits, result); });
}

ReadResult ReadArchive(const std::string& file, host::RetainedSceneDelegate* scene, const DiagnosticSink& sink,
                       const ReadOptions& options) {
  return read_guarded(file, sink, [&](ReadResult* result) {
    host::SceneEdits edits;
    Reader(file, std::filesystem::path(file).parent_path().string(), sink, options).read(&edits, result);
    if (const std::string fault = host::ApplyEdits(std::move(edits), scene); !fault.empty()) throw Fault(fault);
  });
}

std::unique_ptr<host::SceneSource> MakeArchiveSource() {
  return std::make_unique<ArchiveSource>();
}

}  // namespace alabaster::hd::archive
