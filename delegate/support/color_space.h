// The space of colours that a file gives in another one than the rendering space: a token beside their value.
#pragma once

namespace alabaster::hd::support {

/// After the name of a colour of a material's surface node or of a light. A new value of the colour takes it away.
inline constexpr const char* kColorSpace = ":colorSpace";
/// The token's value, and the role of such primvars: linear Rec. 709.
inline constexpr const char* kLinearRec709 = "lin_rec709";

}  // namespace alabaster::hd::support
