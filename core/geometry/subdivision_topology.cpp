#include "core/geometry/subdivision_topology.h"

#include <opensubdiv/far/error.h>
#include <opensubdiv/far/topologyDescriptor.h>
#include <opensubdiv/far/topologyRefinerFactory.h>

#include <mutex>
#include <vector>

#include "core/geometry/index.h"

namespace alabaster {
namespace {

namespace Far = OpenSubdiv::Far;
namespace Sdc = OpenSubdiv::Sdc;

// OpenSubdiv's callbacks are global and print unless they are set; ours hand the text to the build on the same thread.
thread_local std::string* g_messages = nullptr;

void keep_message(const char* text) {
  if (!g_messages || !text) return;
  if (!g_messages->empty()) *g_messages += "; ";
  *g_messages += text;
}

class MessageCapture {
 public:
  explicit MessageCapture(std::string* messages) {
    static std::once_flag once;
    std::call_once(once, [] {
      Far::SetErrorCallback([](Far::ErrorType, const char* text) { keep_message(text); });
      Far::SetWarningCallback([](const char* text) { keep_message(text); });
    });
    g_messages = messages;
  }
  ~MessageCapture() { g_messages = nullptr; }
  MessageCapture(const MessageCapture&) = delete;
  MessageCapture& operator=(const MessageCapture&) = delete;
};

Sdc::SchemeType scheme_type(SubdivisionScheme scheme) {
  if (scheme == SubdivisionScheme::loop) return Sdc::SCHEME_LOOP;
  if (scheme == SubdivisionScheme::bilinear) return Sdc::SCHEME_BILINEAR;
  return Sdc::SCHEME_CATMARK;
}

Sdc::Options::VtxBoundaryInterpolation boundary_option(BoundaryRule rule) {
  switch (rule) {
    case BoundaryRule::none:
      return Sdc::Options::VTX_BOUNDARY_NONE;
    case BoundaryRule::edge_only:
      return Sdc::Options::VTX_BOUNDARY_EDGE_ONLY;
    case BoundaryRule::edge_and_corner:
      break;
  }
  return Sdc::Options::VTX_BOUNDARY_EDGE_AND_CORNER;
}

Sdc::Options::FVarLinearInterpolation face_varying_option(FaceVaryingRule rule) {
  switch (rule) {
    case FaceVaryingRule::all:
      return Sdc::Options::FVAR_LINEAR_ALL;
    case FaceVaryingRule::none:
      return Sdc::Options::FVAR_LINEAR_NONE;
    case FaceVaryingRule::boundaries:
      return Sdc::Options::FVAR_LINEAR_BOUNDARIES;
    case FaceVaryingRule::corners_only:
      return Sdc::Options::FVAR_LINEAR_CORNERS_ONLY;
    case FaceVaryingRule::corners_plus2:
      return Sdc::Options::FVAR_LINEAR_CORNERS_PLUS2;
    case FaceVaryingRule::corners_plus1:
      break;
  }
  return Sdc::Options::FVAR_LINEAR_CORNERS_PLUS1;
}

Sdc::Options scheme_options(const Cage& cage) {
  Sdc::Options options;
  options.SetVtxBoundaryInterpolation(boundary_option(cage.boundary_rule));
  options.SetFVarLinearInterpolation(face_varying_option(cage.face_varying_rule));
  options.SetCreasingMethod(cage.crease_method == CreaseMethod::chaikin ? Sdc::Options::CREASE_CHAIKIN
                                                                        : Sdc::Options::CREASE_UNIFORM);
  options.SetTriangleSubdivision(cage.triangle_subdivision == TriangleSubdivision::smooth
                                     ? Sdc::Options::TRI_SUB_SMOOTH
                                     : Sdc::Options::TRI_SUB_CATMARK);
  return options;
}

// A face-varying value for each corner. Where the cage gives no indices, corners of one point that have equal values
// share one: the rule acts on seams, and a host that flattened its values did not mean a seam at every edge.
template <class T>
std::vector<int> face_varying_indices(const Cage& cage, const Primvar<T>& primvar) {
  if (!primvar.indices.empty()) return primvar.indices;
  std::vector<int> indices(cage.face_vertex_indices.size());
  std::vector<int> latest(cage.points.size(), -1), earlier(indices.size(), -1);  // corners of a point, as chains
  for (size_t corner = 0; corner < indices.size(); ++corner) {
    const size_t point = at(cage.face_vertex_indices[corner]);
    int match = latest[point];
    while (match >= 0 && !(primvar.values[at(match)] == primvar.values[corner])) match = earlier[at(match)];
    indices[corner] = match >= 0 ? match : static_cast<int>(corner);
    if (match >= 0) continue;
    earlier[corner] = latest[point];
    latest[point] = static_cast<int>(corner);
  }
  return indices;
}

}  // namespace

std::unique_ptr<Far::TopologyRefiner> make_refiner(const Cage& cage, std::string* messages) {
  const MessageCapture capture(messages);
  Far::TopologyDescriptor topology;
  topology.numVertices = static_cast<int>(cage.points.size());
  topology.numFaces = static_cast<int>(cage.face_vertex_counts.size());
  topology.numVertsPerFace = cage.face_vertex_counts.data();
  topology.vertIndicesPerFace = cage.face_vertex_indices.data();
  topology.numCreases = static_cast<int>(cage.crease_sharpnesses.size());  // single edges in a sanitized cage
  topology.creaseVertexIndexPairs = cage.crease_indices.data();
  topology.creaseWeights = cage.crease_sharpnesses.data();
  topology.numCorners = static_cast<int>(cage.corner_indices.size());
  topology.cornerVertexIndices = cage.corner_indices.data();
  topology.cornerWeights = cage.corner_sharpnesses.data();
  topology.numHoles = static_cast<int>(cage.hole_indices.size());
  topology.holeIndices = cage.hole_indices.data();
  topology.isLeftHanded = cage.left_handed;
  std::vector<std::vector<int>> value_indices;
  std::vector<Far::TopologyDescriptor::FVarChannel> channels;
  for_each_refined(cage, [&](const auto& primvar) {
    if (primvar.interpolation != Interpolation::face_varying) return;
    value_indices.push_back(face_varying_indices(cage, primvar));
    channels.emplace_back();
    channels.back().numValues = static_cast<int>(primvar.values.size());
    channels.back().valueIndices = value_indices.back().data();
  });
  topology.numFVarChannels = static_cast<int>(channels.size());
  topology.fvarChannels = channels.data();
  using Factory = Far::TopologyRefinerFactory<Far::TopologyDescriptor>;
  Factory::Options options(scheme_type(cage.scheme), scheme_options(cage));
  options.validateFullTopology = true;
  return std::unique_ptr<Far::TopologyRefiner>(Factory::Create(topology, options));
}

}  // namespace alabaster
