// One reading of looks: networks of any of the surfaces that files bring, in the nodes that the renderer reads.
// Networks travel as they were authored (archive, Hydra, Python, C); the builder's thread reads them here.
// look_tables.h has the tables, delegate/manual/usd.md says what differs.
#pragma once

#include <functional>
#include <string>

#include "delegate/api/scene_types.h"

namespace alabaster::hd::looks {

/// Takes a diagnostic's code and text.
using WarnLook = std::function<void(const char* code, const std::string& text)>;

/// A network of AlabasterDisney; the network itself where its terminal "surface" names a node of none of LookTypes().
/// Warns once of each input or node that is left out. Parameters "colorSpace:NAME" beside NAME say the space of a
/// constant or a file, as OpenUSD's scene index has them; without it colours are linear Rec. 709, and files of
/// MaterialX raw.
MaterialNetwork ReadLook(const MaterialNetwork& network, const WarnLook& warn);

/// The types of surface nodes that are read, and AlabasterDisney, for messages: "A, B, C".
std::string LookTypes();

}  // namespace alabaster::hd::looks
