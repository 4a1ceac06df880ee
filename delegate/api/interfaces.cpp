// The abstract classes' destructors: out of line, so that each vtable and type_info lives once, in the library.
#include "delegate/api/render_delegate.h"

namespace alabaster::hd {

SceneDelegate::~SceneDelegate() = default;
RenderParam::~RenderParam() = default;
Instancer::~Instancer() = default;
Prim::~Prim() = default;
RenderPass::~RenderPass() = default;
RenderDelegate::~RenderDelegate() = default;

}  // namespace alabaster::hd
