// Finds images (glTF 2.0, section 3.8.3) as file names or encoded bytes, without decoding them. Checks textures and
// samplers.
#include <algorithm>
#include <cstring>
#include <filesystem>
#include <map>
#include <string_view>

#include "core/files/input_file.h"
#include "core/texture/udim.h"
#include "delegate/gltf/gltf_document.h"

namespace alabaster::hd::gltf {
namespace {

bool is_webp(const uint8_t* data, size_t size) {
  return size >= 12 && std::memcmp(data, "RIFF", 4) == 0 && std::memcmp(data + 8, "WEBP", 4) == 0;
}

// The reason why an image that begins with these bytes cannot be used; null if it can.
const char* kind_fault(const uint8_t* data, size_t size) {
  const auto begins_with = [&](std::string_view magic) {
    return size >= magic.size() && std::memcmp(data, magic.data(), magic.size()) == 0;
  };
  if (begins_with({"\x89PNG\r\n\x1a\n", 8})) return nullptr;
  // JPEG: start of image, then another marker (0xC0 to 0xFE)
  if (size >= 4 && begins_with("\xff\xd8\xff") && data[3] >= 0xc0 && data[3] != 0xff) return nullptr;
  if (is_webp(data, size)) return nullptr;
  if (begins_with("\xabKTX 20"))
    return "is KTX2 (KHR_texture_basisu), which is not supported; convert the image to PNG, JPEG or WebP";
  return "is neither PNG nor JPEG nor WebP, convert the image";
}

class ImageLoader : DocumentCheck {
 public:
  ImageLoader(const Json& root, Report& report, Document* document) : DocumentCheck(root, document, report) {
    for (const Json& name : list("extensionsUsed")) allows_webp_ |= name == "EXT_texture_webp";
  }

  AssetPath load(const Json& image, size_t index) {
    element_ = element_name("images", index);
    name_ = std::filesystem::path(document_.file).filename().string() + "#" + element_;
    if (image.contains("bufferView") == image.contains("uri")) {
      if (image.contains("uri")) return unusable("has both a uri and a bufferView; remove one");
      return unusable("has neither a uri nor a bufferView; add one");
    }
    if (image.contains("bufferView")) {
      const auto view = image["bufferView"].get<size_t>();
      return once(&views_[view], [&] { return from_view(list("bufferViews")[view]); });
    }
    const auto& uri = image["uri"].get_ref<const std::string&>();
    return is_data_uri(uri) ? once(&data_[uri], [&] { return from_data(uri); }) : from_file(uri);
  }

 private:
  // Images of the same bytes share them, so that the renderer decodes them once.
  template <class Read>
  static AssetPath once(AssetPath* known, const Read& read) {
    if (!known->bytes) *known = read();
    return *known;
  }

  AssetPath unusable(const std::string& text) {
    report_.warning("image", element_, text);
    AssetPath unread{name_, "", nullptr};
    unread.fault = text;
    return unread;
  }

  // The reason why the image cannot be used; null if it can.
  const char* check_kind(const uint8_t* data, size_t size) {
    if (is_webp(data, size) && !allows_webp_)
      report_.warning("image", element_, "is WebP, which needs EXT_texture_webp in extensionsUsed; add it");
    return kind_fault(data, size);
  }

  AssetPath embedded(std::vector<uint8_t> bytes) {
    if (const char* fault = check_kind(bytes.data(), bytes.size())) return unusable(fault);
    AssetPath asset;
    asset.authored = name_;
    asset.bytes = std::make_shared<const std::vector<uint8_t>>(std::move(bytes));
    return asset;
  }

  AssetPath from_view(const Json& view) {
    const Bytes& buffer = document_.buffers[view["buffer"].get<size_t>()];
    if (!buffer) return unusable("lies in a buffer without data; export the file again");
    const size_t offset = view.value("byteOffset", size_t(0)), length = view["byteLength"].get<size_t>();
    hold_more(&document_.memory, length, element_);
    return embedded({buffer->data() + offset, buffer->data() + offset + length});
  }

  AssetPath from_data(const std::string& uri) {
    std::string reason;
    hold_more(&document_.memory, uri.size() / 4 * 3, element_);
    auto data = decode_data_uri(uri, &reason);
    return data ? embedded(std::move(data->bytes)) : unusable(reason);
  }

  AssetPath from_file(const std::string& uri) {
    std::string reason;
    const auto file = resolve_uri(document_.base, uri, &reason);
    if (!file) return unusable(reason);
    std::vector<std::string> files;
    for (const UdimTile& tile : udim_tiles(*file)) files.push_back(tile.path);
    if (files.empty()) files.push_back(*file);
    for (const std::string& one : files) check_file(one);
    return {uri, *file, nullptr, document_.base.within};
  }

  // The renderer opens it again, and reports it then as a fault.
  void check_file(const std::string& name) {
    const InputFile file(name, document_.base.within);
    if (!file) return report_.warning("image", element_, "'" + name + "': " + file.reason());
    uint8_t head[12] = {};
    const size_t size = std::min<uint64_t>(sizeof head, file.size());
    const char* fault = file.read(0, head, size) ? check_kind(head, size) : "cannot be read; check the disk";
    if (fault) report_.warning("image", element_, fault);
  }

  bool allows_webp_ = false;
  std::string element_, name_;  // of the image that is loaded
  // The images so far, by buffer view and by data URI; those without bytes cannot be used.
  std::map<size_t, AssetPath> views_;
  std::map<std::string_view, AssetPath> data_;
};

void choose_source(Json* texture) {
  const Json& webp = at(extension_of(*texture, "EXT_texture_webp"), "source");
  const Json& basisu = at(extension_of(*texture, "KHR_texture_basisu"), "source");
  const Json& own = at(*texture, "source");
  if (const Json source = !webp.is_null() ? webp : !own.is_null() ? own : basisu; !source.is_null())
    (*texture)["source"] = source;
}

void check_sampler(const Json& sampler, const std::string& element, Report& report) {
  for (const char* name : {"wrapS", "wrapT"}) {
    const int wrap = sampler.value(name, TINYGLTF_TEXTURE_WRAP_REPEAT);
    if (wrap != TINYGLTF_TEXTURE_WRAP_REPEAT && wrap != TINYGLTF_TEXTURE_WRAP_CLAMP_TO_EDGE &&
        wrap != TINYGLTF_TEXTURE_WRAP_MIRRORED_REPEAT)
      report.warning("sampler", element_name(element, name), "is unknown; repeat is used");
  }
}

}  // namespace

void load_images(Json& root, Report& report, Document* document) {
  const Json &images = at(root, "images"), &samplers = at(root, "samplers");
  ImageLoader loader(root, report, document);
  for (size_t i = 0; i < images.size(); ++i) document->images.push_back(loader.load(images[i], i));
  for (size_t t = 0; t < at(root, "textures").size(); ++t) {
    choose_source(&root["textures"][t]);
    if (!root["textures"][t].contains("source"))
      report.warning("texture", element_name("textures", t), "has no usable image, so it is left out");
  }
  for (size_t s = 0; s < samplers.size(); ++s) check_sampler(samplers[s], element_name("samplers", s), report);
}

}  // namespace alabaster::hd::gltf
