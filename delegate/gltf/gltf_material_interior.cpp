#include <algorithm>
#include <cmath>

#include "core/subsurface/medium.h"
#include "delegate/gltf/gltf_material.h"
#include "delegate/gltf/gltf_material_parts.h"

namespace alabaster::hd::gltf {
namespace {

constexpr double kUnlimited = std::numeric_limits<float>::max();

// True if the volume has an extinction, as scattering requires.
bool attenuates(Extension volume) {
  return number_or(volume, "attenuationDistance", 0, 0, kUnlimited) > 0 &&
         color_or(volume, "attenuationColor", Vec3f(1)) != Vec3f(1);
}

bool scatters(const MaterialBuilder& material) {
  return material.extension("KHR_materials_volume_scatter") && attenuates(material.extension("KHR_materials_volume"));
}

double set_scatter_anisotropy(Extension scatter, MaterialBuilder* material) {
  const double authored = number_or(scatter, "scatterAnisotropy", 0, -1, 1), g = std::clamp(authored, -0.9, 0.9);
  if (g != authored)
    material->warn("material.scatter", "extensions.KHR_materials_volume_scatter.scatterAnisotropy",
                   "is outside -0.9 to 0.9; the nearest value is used");
  if (g != 0) material->set("scatterAnisotropy", g);
  return g;
}

}  // namespace

// A surface without a volume is a sheet. Diffuse transmission into a scattering volume is the walk (set_scatter).
void set_transmission(MaterialBuilder* material) {
  const Extension clear = material->extension("KHR_materials_transmission");
  const Extension diffuse = material->extension("KHR_materials_diffuse_transmission");
  const Extension volume = material->extension("KHR_materials_volume");
  const double clear_factor = number_or(clear, "transmissionFactor", 0);
  const double diffuse_factor = scatters(*material) ? 0 : number_or(diffuse, "diffuseTransmissionFactor", 0);
  if (clear_factor > 0) {
    material->set("specTrans", clear_factor);
    material->connect("specTrans", use_in(clear, "transmissionTexture"), number_reading("r"));
  }
  if (diffuse_factor > 0) {
    material->set("diffTrans", 2 * diffuse_factor);
    material->connect("diffTrans", use_in(diffuse, "diffuseTransmissionTexture"), alpha_reading());
    material->set("diffTransColor", color_or(diffuse, "diffuseTransmissionColorFactor", Vec3f(1)));
    material->connect("diffTransColor", use_in(diffuse, "diffuseTransmissionColorTexture"), color_reading());
  }
  if ((clear_factor <= 0 && diffuse_factor <= 0) || scatters(*material)) return;
  if (number_or(volume, "thicknessFactor", 0, 0, kUnlimited) <= 0) return material->set("thin", true);
  const double dispersion = number_or(material->extension("KHR_materials_dispersion"), "dispersion", 0, 0, 20);
  if (dispersion > 0) material->set("dispersion", dispersion);
  // A solid takes the square root of its colour at each surface (Burley 2015), the extension the colour itself.
  if (material->number("specTrans", 0) == 1 && !material->connected("specTrans")) material->square("baseColor");
  if (!attenuates(volume)) return;
  material->set("attenuationColor", color_or(volume, "attenuationColor", Vec3f(1)));
  material->set("attenuationDistance", number_or(volume, "attenuationDistance", 0, 0, kUnlimited));
}

void set_scatter(MaterialBuilder* material) {
  const Extension volume = material->extension("KHR_materials_volume");
  const Extension scatter = material->extension("KHR_materials_volume_scatter");
  if (!scatter) return;
  if (!volume)
    return material->warn("material.scatter", "extensions.KHR_materials_volume_scatter",
                          "requires KHR_materials_volume; the surface is opaque");
  if (!attenuates(volume))
    return material->warn("material.scatter", "extensions.KHR_materials_volume",
                          "has no extinction, which scattering requires; set attenuationDistance and attenuationColor");
  // The draft renamed the key; the later name takes precedence.
  const char* key = scatter->Has("multiscatterColorFactor") ? "multiscatterColorFactor" : "multiscatterColor";
  const double distance = number_or(volume, "attenuationDistance", 0, 0, kUnlimited);
  const Vec3f albedo = color_or(scatter, key, Vec3f(0)), attenuation = color_or(volume, "attenuationColor", Vec3f(1));
  const double g = set_scatter_anisotropy(scatter, material);
  Vec3f d;
  for (int c = 0; c < 3; ++c) d[c] = scatter_distance(double(attenuation[c]), distance, double(albedo[c]), g);
  material->set("scatterDistance", d);
  const TextureUse texture = use_in(scatter, "multiscatterColorTexture");
  if (material->connected("baseColor") && texture.index < 0)
    material->warn("material.scatter", "pbrMetallicRoughness.baseColorTexture",
                   "is left out because the scattering volume has one colour");
  if (texture.index >= 0)
    material->inform("material.scatter", "extensions.KHR_materials_volume_scatter.multiscatterColorTexture",
                     "colours the medium; the scatter distance is that of the factor's colour everywhere");
  material->set("baseColor", albedo);
  material->disconnect("baseColor");
  material->connect("baseColor", texture, color_reading());
  if (!material->extension("KHR_materials_diffuse_transmission"))
    material->inform("material.scatter", "",
                     "is drawn as a dense medium although it has no KHR_materials_diffuse_transmission");
}

float scatter_distance(double attenuation_color, double attenuation_distance, double albedo, double g) {
  if (attenuation_color <= 0 || attenuation_distance <= 0) return 0;
  const double sigma_t = -std::log(std::min(attenuation_color, 0.999)) / attenuation_distance;
  return float(1 / (sigma_t * (1 - g) * distance_scale(albedo)));
}

}  // namespace alabaster::hd::gltf
