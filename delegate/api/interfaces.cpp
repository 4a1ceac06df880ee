// The abstract classes' destructors: out of line, so that each vtable and type_info lives once, in the library. And the
// answers of a scene that does not move and links no lights.
#include "delegate/api/render_delegate.h"

namespace alabaster::hd {

SceneDelegate::~SceneDelegate() = default;
CullStyle SceneDelegate::GetCullStyle(const Path&) {
  return CullStyle::dontCare;
}
BasisCurvesTopology SceneDelegate::GetBasisCurvesTopology(const Path&) {
  return {};
}
TimeSamples<Matrix4d> SceneDelegate::SampleTransform(const Path&) {
  return {};
}
TimeSamples<Value> SceneDelegate::SamplePrimvar(const Path&, const Token&) {
  return {};
}
TimeSamples<Matrix4d> SceneDelegate::SampleInstancerTransform(const Path&) {
  return {};
}
Token SceneDelegate::GetDisplayName(const Path&) {
  return {};
}
std::vector<Token> SceneDelegate::GetCategories(const Path&) {
  return {};
}
std::vector<std::vector<Token>> SceneDelegate::GetInstanceCategories(const Path&) {
  return {};
}
RenderParam::~RenderParam() = default;
Instancer::~Instancer() = default;
Prim::~Prim() = default;
PixelTransform::~PixelTransform() = default;
RenderPass::~RenderPass() = default;
RenderDelegate::~RenderDelegate() = default;

}  // namespace alabaster::hd
