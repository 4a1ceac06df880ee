// The configuration that is used when the user names none: an OCIO config text made of OCIO's built-in transforms
// alone.
#pragma once

namespace alabaster {

/// Complete text of the built-in configuration (ocio_profile_version 2). Scene reference: ACES2065-1; display
/// reference: CIE XYZ adapted to D65; rendering space: linear Rec.709. The default display is sRGB and its default view
/// "ACES": a render holds light far above 1, and only a tone-mapped view shows a lit scene without clipped highlights.
/// "Un-tone-mapped" is for albedo, line-ups and graphics whose values must come out as they went in.
const char* builtin_config_text();

}  // namespace alabaster
