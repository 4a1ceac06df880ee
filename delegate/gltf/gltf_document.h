// A glTF document, read and checked whole: after read_document every index resolves, every accessor lies in its buffer,
// the nodes form trees and every image can be named. Translation reads it without checking again.
#pragma once

#include "delegate/gltf/gltf_accessor.h"
#include "delegate/gltf/gltf_container.h"
#include "delegate/gltf/tinygltf_model.h"

namespace alabaster::hd::gltf {

struct Document {
  std::string file, folder;
  tinygltf::Model model;  // without images, buffers, skins and animations
  std::vector<Bytes> buffers;
  std::vector<AccessorView> accessors;
  std::vector<AssetPath> images;  // `authored` empty: not usable (reported)
  std::vector<std::string> extensionsUsed, extensionsRequired, extensionsIgnored;
};

/// False: at least one error was reported and the document is not to be used.
bool read_document(const std::string& file, size_t max_bytes, Report& report, Document* document);

// The steps of read_document, in its order. Each reports; after an error the following are not run.

/// Gives every buffer its bytes: the GLB chunk, data URIs, files; at most `max_bytes` together.
void load_buffers(const Json& root, const Bytes& binary_chunk, size_t max_bytes, Report& report, Document* document);
/// Checks buffer views and accessors against the buffers.
void load_accessors(const Json& root, Report& report, Document* document);
/// Attributes against their semantics and each other, indices against vertex counts.
void check_meshes(const Json& root, const Document& document, Report& report);
/// Node trees, transforms, scenes, cameras, lights.
void check_scene(const Json& root, Report& report);
/// Finds every image's bytes or file; what cannot be used is a warning.
void load_images(const Json& root, size_t max_bytes, Report& report, Document* document);
/// What parts of materials and textures would be lost or cannot work.
void check_materials(const Json& root, Report& report);

}  // namespace alabaster::hd::gltf
