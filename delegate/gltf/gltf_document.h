// A glTF document, completely read and checked. After read_document every index resolves, every accessor lies in its
// buffer, the nodes form trees and every image has a name. Translation does not check again.
#pragma once

#include <array>

#include "delegate/gltf/gltf_accessor.h"
#include "delegate/gltf/gltf_container.h"
#include "delegate/gltf/gltf_scene.h"
#include "delegate/gltf/tinygltf_model.h"

namespace alabaster::hd::gltf {

/// EXT_lights_image_based of the scene that is used.
struct ImageLight {
  size_t index = 0;
  std::string element, name;
  double intensity = 1;
  std::array<double, 4> rotation{0, 0, 0, 1};  // a quaternion (x, y, z, w)
  std::array<size_t, 6> faces{};               // images of the largest map, in the order of CubeMap
  size_t face_size = 0;                        // texels along an edge
};

struct Document {
  std::string file;
  UriBase base;
  tinygltf::Model model;  // without materials, images and buffers; of the animations only the one that is used
  Json materials = Json::array();
  std::vector<Bytes> buffers;  // null: its data is stored compressed
  std::vector<Bytes> decoded;  // from compressed buffer views and primitives
  std::vector<AccessorView> accessors;
  std::vector<size_t> alike;      // of the meshes: the first one that differs from it in materials alone
  std::vector<AssetPath> images;  // not usable without `resolved` and `bytes` (reported)
  std::vector<int64_t> parents;   // of the nodes; -1: none
  std::optional<ImageLight> image_light;
  int scene = -1, variant = -1, animation = -1;  // that the options choose; -1: none
  MemoryReservation memory;                      // of all that is read, and of what it becomes
  bool is_choice_wrong = false;                  // the options name a scene, animation or variant that it lacks
  host::SceneFacts facts;
};

/// False if an error was reported; the document must not be used then. Throws MemoryRefused.
bool read_document(const std::string& file, const host::SourceOptions& options, Report& report, Document* document);

// The steps of read_document, in order. Each reports faults; the steps after an error are not run.

/// Gives every buffer its bytes from the GLB chunk, data URIs or files.
void load_buffers(const Json& root, const Bytes& binary_chunk, Report& report, Document* document);
/// Checks buffer views and accessors against the buffers.
void load_accessors(const Json& root, Report& report, Document* document);
/// Checks attributes against their semantics and each other, and indices against vertex counts. Finds meshes that are
/// alike.
void check_meshes(const Json& root, Report& report, Document* document);
/// Checks node trees, transforms, scenes, cameras and lights; then skins, morph weights and instances of nodes.
void check_nodes(const Json& root, Report& report, Document* document);
/// Checks animations, and removes those that are not used and channels that change nothing.
void check_animations(Json& root, Report& report, Document* document);
/// Gives every texture the source that is used: EXT_texture_webp's, else its own, else KHR_texture_basisu's, which is
/// then refused as an image. Finds every image's bytes or file. An image that cannot be used is a warning; the renderer
/// refuses it where it is used. Reports textures and samplers that cannot work.
void load_images(Json& root, Report& report, Document* document);
/// Finds the image-based light of the scene that is used.
void choose_image_light(const Json& root, Report& report, Document* document);

/// The base of classes that check a document.
class DocumentCheck {
 public:
  DocumentCheck(const Json& root, Document* document, Report& report)
      : root_(root), document_(*document), report_(report) {}

 protected:
  /// A list of the document; null if there is none.
  const Json& list(const char* name) const { return at(root_, name); }
  const AccessorView& accessor(const Json& index) const { return document_.accessors[index.get<size_t>()]; }

  const Json& root_;
  Document& document_;
  Report& report_;
};

/// The morph targets of a mesh, which all of its primitives should have; 0 if it has no primitives.
size_t target_count(const Json& mesh);

}  // namespace alabaster::hd::gltf
