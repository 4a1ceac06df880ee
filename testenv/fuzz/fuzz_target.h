// The functions that libFuzzer and the replay of kept inputs call. A target does what a host would do with a file or a
// call made of the bytes; it aborts where the library breaks a promise (delegate/manual/security.md).
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>

namespace alabaster::fuzz {

using Bytes = std::span<const uint8_t>;

struct Target {
  const char* name;
  void (*run)(Bytes input);
};

void run_gltf(Bytes input);          // a .gltf or .glb
void run_description(Bytes input);   // a render description beside a model and an image
void run_archive(Bytes input);       // a .alab, or the list of prims of one
void run_override(Bytes input);      // the text of --set
void run_mesh(Bytes input);          // topology, primvars and instances through the contract
void run_material(Bytes input);      // parameters of a material, lights and camera through the contract
void run_image(Bytes input);         // an image of any kind, as texture and as dome
void run_image_format(Bytes input);  // a header of a format, made of the input, and its texels
void run_ocio(Bytes input);          // an OpenColorIO config
void run_checkpoint(Bytes input);    // edits of a checkpoint, whose checksums are then made right
void run_job(Bytes input);           // names and options in the jobs of a farm
void run_c_api(Bytes input);         // calls of a host of the C interface, right and wrong ones
void run_path(Bytes input);          // names of files with placeholders and links, in scene files

inline constexpr Target kTargets[] = {
    {"gltf", run_gltf}, {"description", run_description}, {"archive", run_archive}, {"override", run_override},
    {"mesh", run_mesh}, {"material", run_material},       {"image", run_image},     {"image_format", run_image_format},
    {"ocio", run_ocio}, {"checkpoint", run_checkpoint},   {"job", run_job},         {"c_api", run_c_api},
    {"path", run_path},
};

}  // namespace alabaster::fuzz
