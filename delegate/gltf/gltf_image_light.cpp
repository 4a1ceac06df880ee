// EXT_lights_image_based: the scene's dome of light, given as the faces of a cube.
#include <cmath>
#include <cstring>
#include <filesystem>

#include "core/images/image_file.h"
#include "core/math/largest_half.h"
#include "core/texture/cube_map.h"
#include "core/texture/texture.h"
#include "delegate/gltf/gltf_nodes.h"
#include "delegate/gltf/gltf_translation.h"
#include "delegate/support/size_text.h"

namespace alabaster::hd::gltf {
namespace {

// Rec. 709, which are those of all colours of glTF.
constexpr std::array<float, 8> kPrimaries = {0.64f, 0.33f, 0.30f, 0.60f, 0.15f, 0.06f, 0.3127f, 0.3290f};

float linear_of_srgb(float v) {
  return v <= 0.04045f ? v / 12.92f : std::pow((v + 0.055f) / 1.055f, 2.4f);
}

// RGBD: the colour is divided by alpha, which an opaque image does not have.
std::vector<Rgb> decode_face(const Texture& image) {
  const int size = image.width();
  std::vector<Rgb> texels;
  texels.reserve(size_t(size) * size_t(size));
  for (int y = 0; y < size; ++y)
    for (int x = 0; x < size; ++x) {
      const Rgb coded = image.texel(x, y);
      const float alpha = image.alpha({(float(x) + 0.5f) / float(size), 1 - (float(y) + 0.5f) / float(size)});
      texels.push_back(Rgb(linear_of_srgb(coded.r), linear_of_srgb(coded.g), linear_of_srgb(coded.b)) *
                       (1 / std::max(alpha, 1 / 255.0f)));
    }
  return texels;
}

class HalfRows final : public RowSource {
 public:
  HalfRows(const std::vector<Rgb>& texels, size_t width) : texels_(texels), width_(width) {}
  size_t row_bytes() const override { return width_ * 3 * sizeof(Half); }
  void encode(int begin, int end, uint8_t* out) const override {
    for (size_t i = size_t(begin) * width_; i < size_t(end) * width_; ++i)
      for (int c = 0; c < 3; ++c, out += sizeof(Half)) {
        const Half value(std::min(texels_[i][c], kLargestHalf));
        std::memcpy(out, &value, sizeof value);
      }
  }

 private:
  const std::vector<Rgb>& texels_;
  const size_t width_;
};

class ImageLightTranslator {
 public:
  ImageLightTranslator(Document* document, Report& report)
      : document_(*document),
        light_(*document->image_light),
        report_(report),
        name_(std::filesystem::path(document->file).filename().string() + "#" + light_.element) {}

  AssetPath image() {
    CubeMap cube;
    cube.size = light_.face_size;
    const size_t texels = cube.size * cube.size;
    // The faces, the image, and the image encoded, twice while it grows.
    hold_more(&document_.memory, texels * (6 + 8) * sizeof(Rgb) + 2 * texels * 8 * 3 * sizeof(Half), light_.element);
    for (size_t f = 0; f < 6; ++f) {
      const auto begin = light_.faces.begin(), end = begin + std::ptrdiff_t(f), same = std::find(begin, end, *end);
      if (same != end)
        cube.faces[f] = cube.faces[size_t(same - begin)];
      else if (!read_face(f, &cube.faces[f]))
        return refused_;
    }
    return encode(to_lat_long(cube), 4 * cube.size);
  }

 private:
  bool fail(const std::string& element, const std::string& text, const AssetPath& refused) {
    report_.warning("light.image", element, text);
    refused_ = refused;
    return false;
  }

  bool read_face(size_t face, std::vector<Rgb>* texels) {
    const AssetPath& asset = document_.images[light_.faces[face]];
    const std::string element = element_name("images", light_.faces[face]);
    if (asset.resolved.empty() && !asset.bytes) return refused_ = asset, false;  // said where it was looked for
    std::string reason;
    const alabaster::DiagnosticSink sink = [&](const alabaster::Diagnostic& d) { reason = d.text; };
    TextureSource source;
    source.path = asset.resolved.empty() ? asset.authored : asset.resolved;
    source.bytes = asset.bytes, source.within = asset.within;
    source.color_space = "raw";
    source.filter = TextureFilter::nearest;
    const auto colors = ColorConfig::load("built-in", sink);
    const auto image =
        colors ? load_texture(source, *colors, sink, {.max_pixels = light_.face_size * light_.face_size}) : nullptr;
    // Without the bytes, which may be those of a sound picture that is larger than it is said to be.
    if (!image)
      return fail(element, "cannot be a face of " + light_.element + ": " + reason, {asset.authored, "", nullptr});
    if (size_t(image->width()) != light_.face_size || image->height() != image->width())
      return fail(element,
                  "has " + support::size_text(image->width(), image->height()) + " pixels, but specularImageSize is " +
                      std::to_string(light_.face_size) + "; correct the size, or scale the image",
                  {name_, "", nullptr});
    *texels = decode_face(*image);
    return true;
  }

  AssetPath encode(const std::vector<Rgb>& texels, size_t width) {
    ImageDescription description;
    description.width = int(width);
    description.height = int(width / 2);
    for (const char* channel : {"R", "G", "B"}) description.channels.push_back({channel, ChannelStore::half});
    description.fast = true;
    description.attributes.push_back({"chromaticities", kPrimaries});
    std::string fault;
    std::vector<unsigned char> file;
    const ImageFunctions* images = image_functions(&fault);
    if (images) fault = images->encode(description, HalfRows(texels, width), file);
    AssetPath asset{name_, "", nullptr};
    if (!fault.empty()) return fail(light_.element, "its image cannot be made: " + fault, asset), asset;
    asset.bytes = std::make_shared<const std::vector<uint8_t>>(std::move(file));
    return asset;
  }

  Document& document_;
  const ImageLight& light_;
  Report& report_;
  const std::string name_;
  AssetPath refused_;
};

}  // namespace

host::LightDescription translate_image_light(Document* document, Report& report) {
  const ImageLight& light = *document->image_light;
  host::LightDescription description;
  description.type = "domeLight";
  description.transform = trs_matrix(Vec3d(0), light.rotation.data(), Vec3d(1));
  description.parameters["intensity"] = float(light.intensity);
  description.parameters["texture:file"] = ImageLightTranslator(document, report).image();
  return description;
}

void choose_image_light(const Json& root, Report& report, Document* document) {
  if (document->scene < 0) return;
  const Json& use = extension_of(root["scenes"][size_t(document->scene)], "EXT_lights_image_based");
  if (use.is_null()) return;
  ImageLight chosen;
  chosen.index = use["light"].get<size_t>();
  const Json& light = extension_of(root, "EXT_lights_image_based")["lights"][chosen.index];
  chosen.element = element_name("extensions.EXT_lights_image_based.lights", chosen.index);
  chosen.name = light.value("name", std::string());
  chosen.intensity = light.value("intensity", 1.0);
  chosen.rotation = light.value("rotation", chosen.rotation);
  chosen.face_size = light["specularImageSize"].get<size_t>();
  const std::string element = chosen.element + ".specularImages";
  const Json& levels = at(light, "specularImages");
  if (!levels.is_array() || levels.empty() || !levels[0].is_array() || levels[0].size() != 6)
    return report.error("light.image", element, "must be an array of arrays of six images; export the file again");
  for (size_t f = 0; f < 6; ++f) {
    const Json& face = levels[0][f];
    if (!face.is_number_unsigned() || face.get<size_t>() >= document->images.size())
      return report.error("light.image", element_name(element + "[0]", f),
                          "must be an index into images; export the file again");
    chosen.faces[f] = face.get<size_t>();
  }
  document->image_light = std::move(chosen);
}

}  // namespace alabaster::hd::gltf
