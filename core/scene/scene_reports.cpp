#include "core/scene/scene_reports.h"

#include <algorithm>
#include <map>
#include <set>

#include "core/diagnostics/plain_format.h"
#include "core/scene/contents.h"
#include "core/scene/mesh_lights.h"
#include "core/scene/world_placement.h"
#include "core/subsurface/body.h"

namespace alabaster {
namespace {

const std::string& name_of(const ReportedScene& scene, uint32_t index) {
  if (index < scene.drawn.alone.size()) return scene.drawn.alone[index]->name;
  const auto& arrays = scene.snapshot.arrays;
  const auto after =
      std::upper_bound(arrays.begin(), arrays.end(), index, [](uint32_t i, const auto& a) { return i < a.first; });
  return scene.drawn.looks[static_cast<size_t>(std::prev(after) - arrays.begin())]->name;
}

// The members of a body that have open shells: the first in the order of their names, and how many names there are.
struct OpenMembers {
  const Instance* first = nullptr;
  std::set<std::string> names;
};
OpenMembers open_members(const ReportedScene& scene, const SubsurfaceBody& body) {
  OpenMembers open;
  for (const auto& member : body.members) {
    if (!member.shells->any_open) continue;
    const std::string& name = name_of(scene, member.instance);
    if (open.names.empty() || name < *open.names.begin()) open.first = &scene.snapshot.instance(member.instance);
    open.names.insert(name);
  }
  return open;
}

void report_open_bodies(const ReportedScene& scene) {
  std::set<std::string> reported;  // instances share a name
  for (const auto& body : scene.snapshot.bodies) {
    scene.cancel.check();
    const OpenMembers open = open_members(scene, *body);
    if (!open.first || !reported.insert(*open.names.begin()).second) continue;
    const MeshPrototype& prototype = *open.first->prototype;
    const auto& materials = open.first->materials;
    const bool is_clear = std::any_of(materials.begin(), materials.end(), [](const DisneyMaterial* m) {
      return m->scatters() && m->constants.spec_trans > 0;
    });
    std::string text =
        (is_clear ? "specTrans with scattering in a mesh that is not closed: it has no inside, so it is clear, and "
                    "light does not scatter behind it"
                  : "subsurface scattering in a mesh that is not closed: the medium goes on behind it without end, and "
                    "light that does not come back is lost (stats: walk.lostEnergy)") +
        describe_open_edges(prototype.interior.open_edges(prototype.mesh)) +
        "; or bind a material without scatterDistance and meanFreePath";
    text += describe_open_fellows(open.names.size() - 1);
    report(scene.sink, Severity::warning, "mesh.open", *open.names.begin(), text);
  }
}

// True if walks begin beyond the far side of the member's thinnest shell: as far below the surface as rounding can
// displace it.
bool is_too_thin(const SubsurfaceBody& body, const SubsurfaceBody::Member& m) {
  if (!m.shells->any_closed) return false;
  TriangleHit middle;
  middle.triangle = m.shells->thinnest, middle.u = middle.v = 1.0f / 3;
  const SurfacePoint at = surface_point(*m.mesh, middle, m.to_body, m.to_object);
  const float thickness = m.shells->least_thickness;
  return body.is_union() ? thickness * m.least_stretch < at.offset : thickness < at.offset_object;
}

void report_thin_shells(const ReportedScene& scene) {
  std::set<const Mesh*> seen;  // instances share them
  for (const auto& body : scene.snapshot.bodies)
    for (const auto& member : body->members) {
      if (!seen.insert(member.mesh).second || !is_too_thin(*body, member)) continue;
      report(
          scene.sink, Severity::warning, "subsurface.thin", name_of(scene, member.instance),
          "a closed part of this mesh is thinner than the rounding of its points: no light can be followed below its "
          "surface, which stays dark; make it thicker, move its points nearer to the origin of the mesh, or bind a "
          "material with `thin`");
    }
}

// The shortest scatter distance of the member's materials that its points are too coarse for, where they would not be
// about the mesh's own origin. 0: there is none.
float lost_distance(const SubsurfaceBody::Member& m) {
  TriangleHit middle;
  middle.triangle = m.shells->thinnest, middle.u = middle.v = 1.0f / 3;
  const SurfaceHit at = surface_hit(*m.mesh, middle, m.to_body, m.to_object);
  const float depth = depth_below_surface(at, m.to_body);
  const float farthest = std::max(max_abs_component(m.mesh->bounds.lower), max_abs_component(m.mesh->bounds.upper));
  const float at_origin = depth * max_abs_component(m.mesh->bounds.extent()) / farthest;
  float lost = 0;
  for (const auto& medium : m.media)
    for (int c = 0; medium && c < 3; ++c) {
      const float distance = (*medium)[AlbedoInversion::exact].medium.scatter_distance[c];
      if (is_resolved(distance, depth) || !is_resolved(distance, at_origin)) continue;
      lost = lost > 0 ? std::min(lost, distance) : distance;
    }
  return lost;
}

void report_lost_distances(const ReportedScene& scene) {
  std::set<const Mesh*> seen;  // instances share them
  for (const auto& body : scene.snapshot.bodies)
    for (const auto& member : body->members) {
      if (!seen.insert(member.mesh).second) continue;
      const float lost = lost_distance(member);
      if (lost > 0)
        report(scene.sink, Severity::warning, "subsurface.farFromOrigin", name_of(scene, member.instance),
               plain_format("scatterDistance %.9g is below the rounding of this mesh's points, so far from its origin "
                            "they lie: light of that channel does not go below the surface; move the points nearer to "
                            "the origin of the mesh, and the mesh there by its transform",
                            double(lost)));
    }
}

// The diagonal of the box about a body, in its first instance.
float size_of(const SubsurfaceBody& body) {
  Bounds box;
  for (const auto& member : body.members) {
    std::optional<SubsurfaceBody::Maps> placed;
    const SubsurfaceBody::Maps& maps = member.array ? member.place(member.instance, &placed) : member;
    for (const Vec3f& corner : member.mesh->bounds.corners()) box.extend(maps.to_body.point(corner));
  }
  return length(box.extent());
}

// Told once for a material.
void report_far_distances(const ReportedScene& scene) {
  struct Far {
    std::string mesh;  // the first in the scene
    float distance, size;
    size_t others = 0;
  };
  std::map<std::string, Far> all;
  for (const auto& body : scene.snapshot.bodies) {
    scene.cancel.check();
    const float size = size_of(*body);
    for (const auto& member : body->members) {
      const auto& materials = scene.snapshot.instance(member.instance).materials;
      for (size_t slot = 0; slot < member.media.size(); ++slot) {
        if (!member.media[slot]) continue;
        const auto& medium = (*member.media[slot])[AlbedoInversion::exact].medium;
        const float distance = max_component(medium.scatter_distance);
        if (!(distance > size)) continue;
        const auto [known, is_new] =
            all.try_emplace(materials[slot]->name, Far{name_of(scene, member.instance), distance, size});
        known->second.others += is_new ? 0 : 1;
      }
    }
  }
  for (const auto& [material, far] : all)
    report(scene.sink, Severity::warning, "subsurface.farDistance", far.mesh,
           "material '" + material + "' lets light travel " +
               plain_format("%.3g units below the surface, and this mesh is %.3g across", double(far.distance),
                            double(far.size)) +
               (far.others > 0 ? ", " + std::to_string(far.others) + " more likewise" : std::string()) +
               plain_format(": it looks like thin fog; distances count in units of the scene: where these are metres, "
                            "%.3g millimetres are %.3g",
                            double(far.distance), double(far.distance) / 1000));
}

// The closed shells of bodies along a ray: the first that it leaves without having entered holds its origin.
class Surrounding {
 public:
  explicit Surrounding(const ReportedScene& scene) : scene_(scene) {}

  /// The index of an instance whose medium holds `p` (render space). Surfaces of `except` do not count.
  std::optional<uint32_t> find(const Vec3f& p, uint32_t except) const {
    std::vector<uint32_t> entered;
    Ray ray{p, normalize(Vec3f(0.36f, 0.48f, 0.8f))};
    TriangleHit hit;
    for (int i = 0; i < kMaxCrossings && scene_.snapshot.top->intersect(ray, &hit); ++i) {
      const Instance& instance = scene_.snapshot.instance(hit.instance);
      std::optional<Placement> moved;
      const Placement& placement = instance.at(hit, &moved);
      const SurfacePoint at =
          surface_point(instance.prototype->mesh, hit, placement.object_to_world, placement.world_to_object);
      ray.org = offset_point(at.p, dot(at.ng, ray.dir) >= 0 ? at.ng : -at.ng, at.offset);
      if (hit.instance == except || !is_solid(instance, hit.triangle)) continue;
      const auto known = std::find(entered.begin(), entered.end(), hit.instance);
      if (!instance.body->leaves(instance.member, hit, ray.dir))
        entered.push_back(hit.instance);
      else if (known == entered.end())
        return hit.instance;
      else
        entered.erase(known);
    }
    return std::nullopt;
  }

 private:
  static bool is_solid(const Instance& instance, uint32_t triangle) {
    if (!instance.body || !instance.material(triangle).scatters()) return false;
    const uint8_t flags = instance.body->members[instance.member].shells->flags(triangle);
    return !(flags & (MeshShells::kOpen | MeshShells::kInner));
  }

  const ReportedScene& scene_;
};

// False: no ray meets it.
bool has_size(const LightParameters& light) {
  if (light.type == LightType::distant) return light.angle != 0;
  return light.type != LightType::sphere || (light.radius != 0 && !light.treat_as_point);
}

// What becomes of light within a body: behind diffuse walls nothing, behind clear ones walks meet what has a size.
enum class Within { dark, sizeless, noisy };
const char* remedy_for(Within within) {
  if (within == Within::noisy)
    return ": walks meet it by chance, so its light is noisy; make it larger, or render more samples";
  if (within == Within::sizeless)
    return ": walks meet no light without size, so nothing of it leaves the body; give it a size, or move it outside";
  return ": walks below a surface meet no light, so nothing of it leaves the body; move it outside, or give the body a "
         "cavity around it";
}

// One report for each body and kind: the first light in it, and how many there are.
struct LightsWithin {
  std::string first;
  size_t count = 0;
  void add(const std::string& light) {
    if (count++ == 0) first = light;
  }
};
void report_within(const ReportedScene& scene, uint32_t body, Within within, const LightsWithin& lights) {
  const std::string others =
      lights.count > 1 ? ", as " + std::to_string(lights.count - 1) + (lights.count > 2 ? " others do" : " other does")
                       : "";
  report(scene.sink, Severity::warning, "light.within", lights.first,
         "it stands within the body of " + name_of(scene, body) + others + remedy_for(within));
}

void report_lights_within(const ReportedScene& scene) {
  constexpr uint32_t kNoInstance = ~0u;
  const Surrounding surrounding(scene);
  std::map<std::pair<uint32_t, Within>, LightsWithin> found;  // by instance
  const auto kind = [&](uint32_t body, bool is_met) {
    const Instance& instance = scene.snapshot.instance(body);
    const bool is_clear = std::any_of(instance.materials.begin(), instance.materials.end(),
                                      [](const auto* m) { return m->scatters() && m->constants.spec_trans > 0; });
    if (!is_clear || !instance.body->occupied) return Within::dark;
    return is_met ? Within::noisy : Within::sizeless;
  };
  for (const LightParameters& light : scene.description.lights) {
    scene.cancel.check();
    if (light.type == LightType::distant || light.type == LightType::dome || light.intensity == 0) continue;
    if (!is_valid_affine(light.light_to_world) || !is_within_reach(light.light_to_world)) continue;
    const Vec3f p = to_affine(moved_to(light.light_to_world, scene.snapshot.origin)).t;
    if (const auto body = surrounding.find(p, kNoInstance))
      found[{*body, kind(*body, has_size(light))}].add(light.name);
  }
  for (uint32_t i = 0; i < scene.snapshot.instances.size(); ++i) {
    const Instance& instance = scene.snapshot.instances[i];
    if (!emits(instance)) continue;
    scene.cancel.check();
    // A mesh that is partly outside is seen there.
    const Mesh& mesh = instance.prototype->mesh;
    std::optional<uint32_t> body;
    for (const size_t triangle : {size_t(0), mesh.triangles.size() / 2, mesh.triangles.size() - 1}) {
      const auto corners = mesh.corners_at(static_cast<uint32_t>(triangle), 0);
      body = surrounding.find(instance.object_to_world.point((corners[0] + corners[1] + corners[2]) * (1.0f / 3)), i);
      if (!body) break;
    }
    if (body) found[{*body, kind(*body, true)}].add(scene.drawn.alone[i]->name);
  }
  for (const auto& [where, lights] : found) report_within(scene, where.first, where.second, lights);
}

// What a subsurfaceSet does not show: where one medium ends and the next begins behind clear walls, and behind diffuse
// ones what lets light through.
void report_sets(const ReportedScene& scene) {
  struct Set {
    const InstanceDescription *cloudy = nullptr, *scattering = nullptr, *clear = nullptr;  // the first of each kind
    const DisneyMaterial* medium = nullptr;
    bool differs = false;
  };
  const auto is_same = [](const DisneyParameters& a, const DisneyParameters& b) {
    return a.medium_albedo() == b.medium_albedo() && a.scatter_distance == b.scatter_distance &&
           a.scatter_anisotropy == b.scatter_anisotropy && a.ior == b.ior;
  };
  std::map<std::string, Set> sets;
  for (const InstanceDescription* instance : scene.drawn.alone) {
    if (instance->subsurface_set.empty()) continue;
    Set& set = sets[instance->subsurface_set];
    const std::vector<size_t> slots = scattering_slots(*instance);
    if (slots.empty()) {
      if (!set.clear && !is_opaque_everywhere(*instance)) set.clear = instance;
      continue;
    }
    if (!set.scattering) set.scattering = instance;
    if (!is_cloudy(*instance)) continue;
    if (!set.cloudy) set.cloudy = instance;
    for (const size_t slot : slots) {
      const DisneyMaterial* const material = &*instance->materials[slot];
      if (!set.medium) set.medium = material;
      set.differs |= !is_same(set.medium->constants, material->constants);
    }
  }
  for (const auto& [name, set] : sets) {
    if (set.differs)
      report(scene.sink, Severity::warning, "subsurface.set", set.cloudy->name,
             "members of its subsurfaceSet " + name +
                 " have different media behind clear walls: within the set light is in the medium of the wall ahead, "
                 "wherever the meshes meet; give them one medium, or leave the set, where bodies that touch or lie "
                 "within each other keep their own");
    if (set.scattering && !set.cloudy && set.clear)
      report(scene.sink, Severity::warning, "subsurface.set", set.clear->name,
             "it lets light through, so light below the surface of " + set.scattering->name +
                 ", which is in the same subsurfaceSet " + name +
                 ", does not meet it: only opaque members are walls there, as bones are; make it opaque, or take it "
                 "out of the set");
  }
}

}  // namespace

std::string describe_open_edges(const OpenEdges& edges) {
  std::string text;
  const auto add = [&](const OpenEdges::Kind& kind, const char* have, const char* remedy) {
    if (kind.count == 0) return;
    const Vec3f &a = kind.first[0], &b = kind.first[1];
    text += "; " + std::to_string(kind.count) + have +
            plain_format(", one from (%g, %g, %g) to (%g, %g, %g): ", double(a.x), double(a.y), double(a.z),
                         double(b.x), double(b.y), double(b.z)) +
            remedy;
  };
  add(edges.of_one, " of its edges have one face", "close it there, or join it with the mesh that it meets there");
  add(edges.of_more, " have three faces or another odd number", "delete the faces inside");
  return text;
}

std::string describe_open_fellows(size_t others) {
  if (others == 0) return {};
  return "; " + std::to_string(others) +
         (others == 1 ? " other mesh of its subsurfaceSet is" : " other meshes of its subsurfaceSet are") +
         " not closed either: a set does not close the meshes that it unites";
}

void report_lights_without_size(const ReportedScene& scene) {
  if (scene.snapshot.features.emissive_meshes) return;
  const LightParameters* first = nullptr;
  for (const LightParameters& light : scene.description.lights) {
    if (light.intensity == 0) continue;
    if (has_size(light) || !light.shadow_enable) return;
    if (!first) first = &light;
  }
  if (!first) return;
  const auto refracts = [](const DisneyMaterial* m) {
    const DisneyParameters& p = m->constants;
    return !p.thin && p.spec_trans > 0 && p.metallic < 1 && p.ior != 1;
  };
  std::set<std::string> solids;  // instances share a name
  const auto look = [&](const Instance& instance, uint32_t index) {
    if (std::any_of(instance.materials.begin(), instance.materials.end(), refracts))
      solids.insert(name_of(scene, index));
  };
  for (uint32_t i = 0; i < scene.snapshot.instances.size(); ++i) look(scene.snapshot.instances[i], i);
  for (const InstanceArray& array : scene.snapshot.arrays) look(array.look, array.first);
  if (solids.empty()) return;
  const std::string others =
      solids.size() > 1 ? " and of " + std::to_string(solids.size() - 1) + (solids.size() > 2 ? " others" : " other")
                        : "";
  report(
      scene.sink, Severity::warning, "light.withoutSize", first->name,
      "no light of the scene has a size, and light without size does not pass where it is refracted: what lies within "
      "or behind the clear solid " +
          *solids.begin() + others +
          " is dark; give a light a radius or an angle, or the material `thin` if it is a pane");
}

void report_bodies(const ReportedScene& scene) {
  report_open_bodies(scene);
  report_thin_shells(scene);
  report_lost_distances(scene);
  report_far_distances(scene);
  report_lights_within(scene);
  report_sets(scene);
}

}  // namespace alabaster
